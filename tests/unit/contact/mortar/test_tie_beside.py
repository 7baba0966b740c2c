# SPDX-License-Identifier: MIT
"""Ties beside contacts of other kinds, on one rank and several."""

import tie_beside_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(tie_beside_checks)
