# SPDX-License-Identifier: MIT
"""Ctrl-C on 1, 2 and 3 ranks."""

import interrupt_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(interrupt_checks, ranks=(2, 3), timeout=300)
