# SPDX-License-Identifier: MIT
"""Residuals with averages over cells: the checks of averaged_form_checks.py on one rank and on several."""

import averaged_form_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(averaged_form_checks)
