# SPDX-License-Identifier: MIT
"""Stress at the nodes of a joint whose strain is the same everywhere: Hooke's in the rails, also where they meet what
is softer."""

import numpy as np
import pytest
from dolfinx import fem
from joint_checks import TINY
from mpi4py import MPI

from impact_studies.rail_joint import JointModel
from impact_studies.rail_joint.stress import NAMES, NodalStress

GRADIENT = 1e-4 * np.array([(1.0, 0.5, 0.3), (0.0, -2.0, 0.1), (0.7, 0.0, 2.4)])


def hooke(E, nu):
    strain = (GRADIENT + GRADIENT.T) / 2
    s = E / (1 + nu) * (strain + nu / (1 - 2 * nu) * np.trace(strain) * np.eye(3))
    deviator = s - np.trace(s) / 3 * np.eye(3)
    return [np.sqrt(1.5 * np.sum(deviator**2)), s[0, 0], s[1, 1], s[2, 2], s[0, 2]]


def test_parts_of_a_joint_that_is_strained_alike():
    model = JointModel(TINY, MPI.COMM_SELF)
    u = fem.Function(model.V)
    u.interpolate(lambda x: GRADIENT @ x)
    found = NodalStress(model, u).evaluate()
    assert tuple(found) == NAMES
    dofs = found["von_mises"].function_space.dofmap.list

    def nodes_of(*names):
        return np.unique(dofs[np.concatenate([model.cell_tags.find(model.tags[name]) for name in names])])

    post, rails = nodes_of("end_post"), nodes_of("master_body", "second_rail")
    both = np.intersect1d(post, rails)
    softer = model.material.materials[model.tags["end_post"]]
    assert len(rails) > len(both) > 0 and softer.E < 0.5 * TINY.E
    for name, expected, less in zip(NAMES, hooke(TINY.E, TINY.nu), hooke(softer.E, softer.nu)):
        # A node between two parts has the larger one. Round-off of stresses of the size E times the strain.
        assert found[name].x.array[rails] == pytest.approx(expected, rel=1e-9, abs=1e-14 * TINY.E), name
        assert abs(expected) > abs(less)
