# SPDX-License-Identifier: MIT
"""Initial penetration is refused, reported or removed before the first load step, on 1 to 3 ranks."""

import initial_penetration_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(initial_penetration_checks, ranks=(2, 3), timeout=200)
