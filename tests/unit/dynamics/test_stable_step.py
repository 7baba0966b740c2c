# SPDX-License-Identifier: MIT
"""Stable steps of bodies that change as they go; the checks are in stable_step_checks.py."""

import stable_step_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(stable_step_checks)
