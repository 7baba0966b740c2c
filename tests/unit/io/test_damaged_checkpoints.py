# SPDX-License-Identifier: MIT
"""Damaged and foreign checkpoints on 1, 2 and 3 ranks."""

import damaged_checkpoint_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(damaged_checkpoint_checks, ranks=(2, 3), timeout=300)
