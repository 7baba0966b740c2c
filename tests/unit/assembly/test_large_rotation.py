# SPDX-License-Identifier: MIT
"""Bodies of small strain that turn far are told; the checks are in large_rotation_checks.py."""

import large_rotation_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(large_rotation_checks)
