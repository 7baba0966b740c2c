# SPDX-License-Identifier: MIT
"""Bodies that yield on 1, 2 and 3 ranks."""

import yielding_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(yielding_checks)
