# SPDX-License-Identifier: MIT
"""Hertz's contacts on 1 to 4 ranks."""

import hertz_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(hertz_checks, ranks=(2, 3, 4), timeout=300, in_make_test={"hertz": (2,)})
