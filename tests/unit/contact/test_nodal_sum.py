# SPDX-License-Identifier: MIT
"""Nodal values over the ranks; the checks are in nodal_sum_checks.py."""

import nodal_sum_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(nodal_sum_checks)
