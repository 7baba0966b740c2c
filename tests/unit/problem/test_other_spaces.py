# SPDX-License-Identifier: MIT
"""Unknowns that are no displacement, and meshes that are no bodies: the checks of other_spaces_checks.py."""

import other_spaces_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(other_spaces_checks)
