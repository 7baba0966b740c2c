# SPDX-License-Identifier: MIT
"""Implicit problems on one rank."""

import implicit_checks
from on_ranks import rank_tests

test_one_rank, _ = rank_tests(implicit_checks)
