# SPDX-License-Identifier: MIT
"""Problems that end at different times on the ranks leave no rank waiting."""

import petsc_communicators_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(petsc_communicators_checks, timeout=60)
