# SPDX-License-Identifier: MIT
"""What a penalty contact says of the springs that it has."""

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di


def pressed(**given):
    """A unit square that is pressed onto a plane by a hundredth."""
    domain = mesh.create_unit_square(MPI.COMM_SELF, 2, 2, mesh.CellType.quadrilateral)
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    low, top = (mesh.locate_entities_boundary(domain, 1, lambda x, y=y: np.isclose(x[1], y)) for y in (0.0, 1.0))
    tags = mesh.meshtags(domain, 1, np.sort(low), np.full(len(low), 1, np.int32))
    down = fem.dirichletbc(np.array([0.0, -0.01]), fem.locate_dofs_topological(V, 1, top), V)
    pair = di.ContactPair(tags, 1, di.RigidPlane((0.0, 0.0), (0.0, 1.0)), friction=0.3)
    law = di.LinearElastic(1.0, 0.3, hypothesis="plane_strain")
    return di.StaticProblem(fem.Function(V), law, bcs=[down], contact=[di.Penalty(pair, **given)])


def test_penalties_in_use():
    problem = pressed(penalty=10.0, tangential=4.0)
    problem.solve()
    assert (problem.contact[0].penalty, problem.contact[0].tangential) == (10.0, 4.0)
    problem = pressed()
    assert problem.contact[0].penalty is None and problem.contact[0].tangential is None
    problem.solve()
    contact = problem.contact[0]
    assert contact.penalty > 1.0 and 0.0 < contact.tangential <= contact.penalty
    # Springs in series with the square: what they take of the way is the pressure over their stiffness.
    assert contact.pressure.max() == pytest.approx(-contact.penalty * contact.gap.min(), rel=1e-9)


def test_the_convex_tangent_is_asked_for():
    contact = pressed(penalty=10.0).contact[0]
    assert contact.convex is False
    contact.convex = True
    assert contact.convex is True
