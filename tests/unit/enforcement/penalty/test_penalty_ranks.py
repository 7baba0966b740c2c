# SPDX-License-Identifier: MIT
"""Penalty contact does not depend on the number of ranks."""

import penalty_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(penalty_checks, ranks=(2, 3, 4), timeout=120)
