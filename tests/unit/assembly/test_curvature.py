# SPDX-License-Identifier: MIT
"""Signs of a residual's tangent; the checks are in curvature_checks.py."""

import curvature_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(curvature_checks)
