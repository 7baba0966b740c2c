# SPDX-License-Identifier: MIT
"""Model and passage of a rail joint with coarse cells."""

import joint_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(
    joint_checks,
    ranks=(2,),
    timeout=300,
    in_make_test={
        "the_wheel_is_balanced": (2,),
        "resumed_run_is_the_same_run": (),
        "prediction_of_a_long_run": (),
    },
)
