# SPDX-License-Identifier: MIT
"""Recorder on 1 and 2 ranks."""

import recorder_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(recorder_checks, ranks=(2,), timeout=300)
