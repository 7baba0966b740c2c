# SPDX-License-Identifier: MIT
"""Bodies that only contact holds, on 1 to 3 ranks."""

import held_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(held_checks)
