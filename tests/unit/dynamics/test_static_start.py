# SPDX-License-Identifier: MIT
"""Explicit runs that begin with an equilibrium."""

import static_start_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(static_start_checks, ranks=(2, 3))
