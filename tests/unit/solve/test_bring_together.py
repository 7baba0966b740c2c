# SPDX-License-Identifier: MIT
"""Static solves of bodies that are apart, on 1 to 3 ranks."""

import bring_together_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(bring_together_checks)
