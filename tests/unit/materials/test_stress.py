# SPDX-License-Identifier: MIT
"""Stresses of materials on several numbers of ranks; the checks are in stress_checks.py."""

import stress_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(stress_checks)
