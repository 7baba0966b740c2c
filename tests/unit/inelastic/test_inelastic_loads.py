# SPDX-License-Identifier: MIT
"""Loads that need other quadrature rules than the kernels of a material with internal variables."""

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di


@pytest.mark.parametrize("kind", ["static", "newmark"])
def test_body_force_by_an_expression(kind):
    """A constant body force, written as an expression of the place, does what the numbers do."""
    domain = mesh.create_box(MPI.COMM_SELF, [(0, 0, 0), (1, 1, 2)], (2, 2, 3), mesh.CellType.hexahedron)
    V = fem.functionspace(domain, ("Lagrange", 1, (3,)))
    bottom = fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[2], 0.0))
    bcs = [fem.dirichletbc(np.zeros(3), bottom, V)]
    steel = di.J2Plasticity(2e5, 0.3, 1.0, yield_stress=100.0, hardening=2e3)
    x, found = ufl.SpatialCoordinate(domain), []
    for vector in ((0.0, 0.0, -80.0), ufl.as_vector([0.0, 0.0, -80.0 + 0.0 * x[0]])):
        u, load = fem.Function(V), di.BodyForce(vector)
        if kind == "static":
            problem = di.StaticProblem(u, steel, bcs=bcs, loads=[load])
            problem.solve(rtol=1e-13)
        else:
            problem = di.NewmarkProblem(u, steel, velocity=fem.Function(V), bcs=bcs, loads=[load])
            problem.advance(until=0.02, dt=5e-3, progress=False)
        found.append((u.x.array.copy(), problem.history["plastic_strain"].values.max()))
    assert kind == "newmark" or found[0][1] > 1e-5, "the foot of the column yields"
    # Both are integrated exactly: round-off, times what Newton's tolerance leaves.
    assert np.abs(found[0][0] - found[1][0]).max() < 1e-9 * np.abs(found[0][0]).max()
