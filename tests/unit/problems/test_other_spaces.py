# SPDX-License-Identifier: MIT
"""Unknowns that are no displacement, and meshes that are no bodies: the checks of other_spaces_checks.py."""

import other_spaces_checks
from on_ranks import rank_tests

# The other rows of runs in time are left to `make verify`.
test_one_rank, test_several_ranks = rank_tests(
    other_spaces_checks, in_make_test={"implicit_on_the_other_rows": (), "explicit_on_the_other_rows": ()}
)
