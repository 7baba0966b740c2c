# SPDX-License-Identifier: MIT
import rolling_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(
    rolling_checks,
    in_make_test={
        "an_explicit_run_goes_on_with_the_contact_forces": (2,),
        "linear_bodies_have_one_tangent": (2,),
        "a_sweep_goes_on_where_it_was_stopped": (2,),
    },
)
