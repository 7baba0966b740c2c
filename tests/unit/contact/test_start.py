# SPDX-License-Identifier: MIT
"""What is refused, told and removed before anything is loaded, on 1 to 3 ranks."""

import start_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(start_checks, ranks=(2, 3), timeout=200)
