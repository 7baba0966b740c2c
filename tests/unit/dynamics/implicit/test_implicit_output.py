# SPDX-License-Identifier: MIT
"""Checkpoints, output and steps that fail of implicit problems, on one rank and on two."""

import implicit_output_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(
    implicit_output_checks, ranks=(2,), timeout=300, in_make_test={"a_restored_run_is_the_uninterrupted_one": (2,)}
)
