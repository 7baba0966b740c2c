# SPDX-License-Identifier: MIT
"""Smooth surfaces on one to three ranks; see smooth_checks.py."""

import pathlib
import sys

from on_ranks import rank_tests

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import smooth_checks  # noqa: E402

test_one_rank, test_several_ranks = rank_tests(smooth_checks)
