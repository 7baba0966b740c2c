# SPDX-License-Identifier: MIT
"""Exchange of nodal values."""

import halo_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(halo_checks, ranks=(2, 3, 4), timeout=100)
