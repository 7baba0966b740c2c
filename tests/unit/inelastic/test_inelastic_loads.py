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


@pytest.mark.parametrize("kind", ["static", "explicit", "newmark"])
@pytest.mark.parametrize("yielding", [(1,), (1, 2)])
def test_tags_that_share_a_material(kind, yielding):
    """One object for several tags is the same as one object for each of them."""
    domain = mesh.create_box(MPI.COMM_SELF, [(0, 0, 0), (1, 1, 4)], (2, 2, 4), mesh.CellType.hexahedron)
    V = fem.functionspace(domain, ("Lagrange", 1, (3,)))
    cells = np.arange(16, dtype=np.int32)
    layers = 1 + np.minimum(3, mesh.compute_midpoints(domain, 3, cells)[:, 2].astype(np.int32))
    tags = mesh.meshtags(domain, 3, cells, layers)
    bottom = fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[2], 0.0))
    bcs, found = [fem.dirichletbc(np.zeros(3), bottom, V)], []
    for shared in (True, False):

        def laws(tag):
            if tag in yielding:
                return di.J2Plasticity(2e5, 0.3, 1.0, yield_stress=100.0, hardening=2e3)
            return di.LinearElastic(2e5, 0.3, 1.0)

        one = {True: laws(yielding[0]), False: laws(4)}
        material = di.MaterialMap(tags, {t: one[t in yielding] if shared else laws(t) for t in (1, 2, 3, 4)})
        u, load = fem.Function(V), di.BodyForce((0.0, 0.0, -40.0))
        if kind == "static":
            problem = di.StaticProblem(u, material, bcs=bcs, loads=[load])
            problem.solve(rtol=1e-13)
        else:
            Problem = di.ExplicitProblem if kind == "explicit" else di.NewmarkProblem
            problem = Problem(u, material, velocity=fem.Function(V), bcs=bcs, loads=[load])
            problem.advance(until=0.02, dt=2e-4 if kind == "explicit" else 5e-3, progress=False)
        found.append((u.x.array.copy(), problem.history["plastic_strain"].values, problem.history["stress"].values))
    for one, other in zip(*found):
        assert np.abs(one - other).max() < 1e-9 * max(1e-3, np.abs(one).max())  # round-off, Newton's tolerance
