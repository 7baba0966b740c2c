# SPDX-License-Identifier: MIT
"""Trusses and shells: the checks of embedded_checks.py."""

import embedded_checks
from on_ranks import rank_tests

# Shells take ten seconds to compile.
test_one_rank, test_several_ranks = rank_tests(embedded_checks, in_make_test={"shells": ()})
