# SPDX-License-Identifier: MIT
"""Problems that are no longer used give back their memory."""

import memory_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(memory_checks, ranks=(2,), in_make_test={"solvers_are_freed": (1,)})
