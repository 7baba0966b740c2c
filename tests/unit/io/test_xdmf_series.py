# SPDX-License-Identifier: MIT
"""Series in XDMF on several numbers of ranks; the checks are in xdmf_series_checks.py."""

import xdmf_series_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(xdmf_series_checks)
