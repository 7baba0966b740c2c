# SPDX-License-Identifier: MIT
"""Implicit problems on up to four ranks."""

import implicit_rank_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(
    implicit_rank_checks, ranks=(2, 3, 4), timeout=300, in_make_test={"runs_are_those_of_one_rank": (2,)}
)
