# SPDX-License-Identifier: MIT
"""Nodal forces of loads that do not follow the body; the checks are in dead_load_checks.py."""

import dead_load_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(dead_load_checks)
