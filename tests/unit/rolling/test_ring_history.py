# SPDX-License-Identifier: MIT
import ring_history_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(ring_history_checks)
