# SPDX-License-Identifier: MIT
"""Residuals with averages over cells: the checks of averages_checks.py on one rank and on several."""

import averages_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(averages_checks)
