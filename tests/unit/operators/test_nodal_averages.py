# SPDX-License-Identifier: MIT
"""Averages at nodes of values at quadrature points, on 1, 2 and 3 ranks."""

import nodal_averages_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(nodal_averages_checks)
