# SPDX-License-Identifier: MIT
"""Guards of public calls on 1, 2 and 3 ranks."""

import collective_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(collective_checks, timeout=60)
