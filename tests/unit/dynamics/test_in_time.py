# SPDX-License-Identifier: MIT
"""Values that a user sets for a time, and loads beside a residual; the checks are in in_time_checks.py."""

import in_time_checks
from on_ranks import rank_tests
from in_time_checks import *  # noqa: F401, F403

# What repeats on other cells is left to `make verify`: their kernels take the time.
test_one_rank, test_several_ranks = rank_tests(
    in_time_checks, in_make_test={"loads_beside_a_residual_on_other_cells": ()}
)
