# SPDX-License-Identifier: MIT
"""Axisymmetric surfaces that are tied to each other, on one rank and several."""

import tie_axisymmetric_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(tie_axisymmetric_checks)
