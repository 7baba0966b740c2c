# SPDX-License-Identifier: MIT
"""Factors of one problem for another one of the same bodies, on the ranks of COMM_WORLD. See on_ranks.py."""

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.statics.linear_solver import LIMITS

COMM = MPI.COMM_WORLD
RTOL = 1e-10
PATIENCE = 5  # iterations: factors of so few unknowns are worth none, and those of the same bodies need one
GAP, SMALL = 1.0 / 3.0, 1e-6  # the gap is as wide as two cells


def beside_each_other():
    """Space of two bars of the same height, which nothing joins."""
    domain = mesh.create_box(COMM, [np.zeros(3), np.ones(3)], (6, 3, 6), mesh.CellType.hexahedron)
    apart = mesh.locate_entities(domain, 3, lambda x: (x[0] < 0.5 + SMALL) | (x[0] > 0.5 + GAP - SMALL))
    part = mesh.create_submesh(domain, 3, apart)[0]
    return fem.functionspace(part, ("Lagrange", 1, (3,)))


def loaded(V, shear, held="ends", load=1e-3):
    """Problem of both bars on their lower sides. The left one is sheared by a load on its upper side.

    Args:
        held: "ends", or "right": the right one as a whole, too.
    """
    below = fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[2], 0.0))
    bcs = [fem.dirichletbc(np.zeros(3), below, V)]
    if held == "right":
        right = fem.locate_dofs_geometrical(V, lambda x: x[0] > 0.5 + SMALL)
        bcs.append(fem.dirichletbc(np.zeros(3), right, V))
    above = mesh.locate_entities_boundary(V.mesh, 2, lambda x: np.isclose(x[2], 1.0) & (x[0] < 0.5 + SMALL))
    tags = mesh.meshtags(V.mesh, 2, above, np.ones(len(above), dtype=np.int32))
    traction = di.Traction(tags, 1, (shear, 0.0, -load))
    before, LIMITS.patience = LIMITS.patience, PATIENCE
    try:
        return di.StaticProblem(fem.Function(V), di.LinearElastic(1.0, 0.3), bcs=bcs, loads=[traction])
    finally:
        LIMITS.patience = before


def solved(problem):
    problem.solve(rtol=RTOL, progress=False)
    return problem.u.x.array.copy()


def check_factors_serve_another_problem():
    V = beside_each_other()
    first = loaded(V, 0.0)
    solved(first)
    for held in ("ends", "right"):  # the pins of a whole body reach no equation of another one
        expected = solved(loaded(V, 1e-3, held))
        second = loaded(V, 1e-3, held)
        second.share_linear_solver(first)
        np.testing.assert_allclose(solved(second), expected, rtol=0, atol=1e-7 * np.abs(expected).max())
        assert second.linear_solver.num_set_ups == first.linear_solver.num_set_ups == 1
    assert np.abs(expected).max() > 1e-4
    solved(first)  # goes on with them, too
    assert first.linear_solver.num_set_ups == 1
    first.linear_solver.reset()
    assert second.linear_solver.factors is None


def check_what_cannot_be_shared():
    V = beside_each_other()
    first = loaded(V, 0.0)
    with pytest.raises(TypeError, match="give a StaticProblem"):
        first.share_linear_solver(first.linear_solver)
    with pytest.raises(ValueError, match="displacements on one space"):
        first.share_linear_solver(loaded(beside_each_other(), 0.0))
