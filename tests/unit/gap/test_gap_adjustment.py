# SPDX-License-Identifier: MIT
"""Offsets, clearances and adjusted gaps; the checks are in gap_adjustment_checks.py."""

import gap_adjustment_checks
from gap_adjustment_checks import *  # noqa: F401, F403
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(gap_adjustment_checks)
