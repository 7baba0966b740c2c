# SPDX-License-Identifier: MIT
"""Residuals on mixed spaces: the checks of mixed_spaces_checks.py on one rank and on several."""

import mixed_spaces_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(mixed_spaces_checks)
