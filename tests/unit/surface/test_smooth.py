# SPDX-License-Identifier: MIT
"""Smooth surfaces on one to three ranks; see smooth_checks.py."""

from on_ranks import rank_tests
import smooth_checks


test_one_rank, test_several_ranks = rank_tests(smooth_checks)
