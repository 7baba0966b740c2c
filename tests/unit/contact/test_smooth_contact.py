# SPDX-License-Identifier: MIT
"""Contact with smooth surfaces."""

import smooth_contact_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(
    smooth_contact_checks, ranks=(2, 3), in_make_test={"a_smooth_wheel_rolls_evenly": (2,)}
)
