# SPDX-License-Identifier: MIT
"""Integrals over interior facets and stresses at points: the checks of facet_forms_checks.py."""

import facet_forms_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(facet_forms_checks)
