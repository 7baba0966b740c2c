# SPDX-License-Identifier: MIT
"""Recipes whose cells go to ranks by what they cost; io/test_bisection.py has the cuts."""

import pytest
from mesh_modules import meshes
from mpi4py import MPI


def test_a_recipe_takes_a_weight_or_a_partitioner():
    with pytest.raises(ValueError, match="not both"):
        meshes.make("two_bars", MPI.COMM_SELF, weight=lambda x: x[:, 0], partitioner=lambda *given: None)
