# SPDX-License-Identifier: MIT
import rolling_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(rolling_checks)
