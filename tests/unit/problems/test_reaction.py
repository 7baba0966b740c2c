# SPDX-License-Identifier: MIT
"""Reactions and section forces; the checks are in reaction_checks.py."""

import reaction_checks
from on_ranks import rank_tests
from reaction_checks import *  # noqa: F401, F403

test_one_rank, test_several_ranks = rank_tests(reaction_checks)
