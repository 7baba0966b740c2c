# SPDX-License-Identifier: MIT
"""Mass matrices of implicit problems; the checks are in inertia_checks.py."""

import inertia_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(inertia_checks)
