# SPDX-License-Identifier: MIT
import creep_file_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(
    creep_file_checks,
    in_make_test={
        "each_parameter_belongs_to_the_file": (1, 2),
        "models_that_are_nearly_the_same_are_refused": (1,),  # makes five models: minutes on ranks
        "files_without_an_identity_are_refused": (2,),
    },
)
