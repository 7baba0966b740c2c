# SPDX-License-Identifier: MIT
"""What a contact by multipliers says of its nodes after a solve, and what may be set."""

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di

FRICTION = 0.3


@pytest.fixture(scope="module")
def slid():
    """A unit square that was pressed onto a plane by a hundredth and drawn along it until all of it slips."""
    domain = mesh.create_unit_square(MPI.COMM_SELF, 3, 2, mesh.CellType.quadrilateral)
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    low, top = (mesh.locate_entities_boundary(domain, 1, lambda x, y=y: np.isclose(x[1], y)) for y in (0.0, 1.0))
    tags = mesh.meshtags(domain, 1, np.sort(low), np.full(len(low), 1, np.int32))
    moved = fem.Constant(domain, (0.0, -0.01))
    held = fem.dirichletbc(moved, fem.locate_dofs_topological(V, 1, top), V)
    pair = di.ContactPair(tags, 1, di.RigidPlane((0.0, 0.0), (0.0, 1.0)), friction=FRICTION)
    law = di.LinearElastic(1.0, 0.3, hypothesis="plane_strain")
    problem = di.StaticProblem(fem.Function(V), law, bcs=[held], contact=[di.Lagrange(pair)])
    problem.solve()
    moved.value[:] = (0.05, -0.01)
    problem.solve(steps=2)
    return problem.contact[0]


def test_nodes_that_slip(slid):
    assert np.all(slid.status == di.ContactStatus.slip) and np.all(slid.sliding)
    # Friction acts against the slip, at its limit; the way is what the top was moved less the shear of the square.
    np.testing.assert_allclose(slid.direction, np.tile([-1.0, 0.0], (4, 1)), atol=1e-9)
    np.testing.assert_allclose(slid.friction_traction, FRICTION * slid.multiplier[:, None] * slid.direction, atol=1e-12)
    np.testing.assert_array_equal(slid.traction_n, slid.friction_traction)
    assert np.all((0.0 < slid.total_slip[:, 0]) & (slid.total_slip[:, 0] < 0.05)) and np.all(slid.total_slip[:, 1] == 0)


def test_springs_of_the_bodies(slid):
    """Of the order of Young's modulus times the area of a node over the height of a cell."""
    assert np.all((0.01 < slid.nodal_stiffness) & (slid.nodal_stiffness < 100.0))


def test_tractions_can_be_set(slid):
    before = slid.friction_traction.copy()
    slid.friction_traction = 2.0 * before
    np.testing.assert_array_equal(slid.friction_traction, 2.0 * before)
    slid.friction_traction = before
    assert slid.opening.shape == (4,) and np.all(slid.opening == 0.0)
