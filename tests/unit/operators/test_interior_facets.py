# SPDX-License-Identifier: MIT
"""Facets between two cells: the checks of interior_facets_checks.py."""

import interior_facets_checks
from on_ranks import rank_tests

# Kernels of hexahedra take six seconds to compile.
test_one_rank, test_several_ranks = rank_tests(
    interior_facets_checks, in_make_test={"hexahedra": (), "tetrahedra": (2,)}
)
