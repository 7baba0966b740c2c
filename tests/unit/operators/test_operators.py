# SPDX-License-Identifier: MIT
"""Matrix-free operators equal DOLFINx's assembly on 1, 2 and 3 ranks."""

import operator_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(operator_checks)
