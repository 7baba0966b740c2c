# SPDX-License-Identifier: MIT
"""Implicit problems on one rank and on two."""

import implicit_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(implicit_checks, ranks=(2,), timeout=300)
