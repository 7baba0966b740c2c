# SPDX-License-Identifier: MIT
"""Problems on ranks without cells, on 1, 2 and 3 ranks."""

import empty_rank_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(empty_rank_checks, timeout=120)
