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
        "parts_meshed_apart": (1,),
        "a_lifted_wheel_needs_no_factors_of_its_own": (1,),
        "killed_run_goes_on": (1,),
        "run_killed_in_every_stage_goes_on": (),
        "a_folder_of_an_older_version_goes_on": (1,),
        "a_run_in_a_folder_is_alone": (1, 2),
        "a_new_run_removes_the_results_of_an_old_one": (1, 2),
        "prediction_of_a_long_run": (),
    },
)
