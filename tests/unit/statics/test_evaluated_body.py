# SPDX-License-Identifier: MIT
"""Stresses that a user computes at quadrature points: the checks of evaluated_body_checks.py."""

import evaluated_body_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(evaluated_body_checks)
