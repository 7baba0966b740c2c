# SPDX-License-Identifier: MIT
"""Contact between bodies on 1 to 4 ranks."""

import contact_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(
    contact_checks, ranks=(2, 3, 4), timeout=300, in_make_test={"ranks": (2,)}
)
