# SPDX-License-Identifier: MIT
"""Meshes that meshio reads; the checks are in meshio_checks.py."""

import meshio_checks
from meshio_checks import *  # noqa: F401, F403
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(meshio_checks)
