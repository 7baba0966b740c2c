# SPDX-License-Identifier: MIT
import ring_history_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(
    ring_history_checks,
    in_make_test={
        "plastic_flow_of_a_ring_dissipates": (1,),
        "a_rigid_turn_leaves_the_stress_of_a_ring_that_was_strained": (1,),
    },
)
