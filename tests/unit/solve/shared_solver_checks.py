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
MANY = 40  # iterations that the factors may always take
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


LOWER, UPPER = 1.0, 2.0 / 3.0  # heights of two blocks


def stacked():
    """Space of two blocks, one above the other."""
    domain = mesh.create_box(COMM, [np.zeros(3), np.array([1.0, 1.0, 2.0])], (3, 3, 12), mesh.CellType.hexahedron)
    apart = mesh.locate_entities(domain, 3, lambda x: (x[2] < LOWER + SMALL) | (x[2] > LOWER + GAP - SMALL))
    part = mesh.create_submesh(domain, 3, apart)[0]
    x = part.geometry.x
    x[x[:, 2] > LOWER + SMALL, 2] -= GAP - SMALL
    return fem.functionspace(part, ("Lagrange", 1, (3,)))


def pressed(V, contact):
    """Problem of two blocks. A load presses the upper one on the lower one, which alone holds it upwards.

    Args:
        contact: "multipliers", "springs", or "none": the upper block is lifted off, and held as a whole.
    """
    below = fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[2], 0.0))
    bcs, upper = [fem.dirichletbc(np.zeros(3), below, V)], LOWER + 0.5 * SMALL
    if contact == "none":
        bcs.append(fem.dirichletbc(np.zeros(3), fem.locate_dofs_geometrical(V, lambda x: x[2] > upper), V))
    for c in range(2) if contact != "none" else ():
        W, _ = V.sub(c).collapse()
        side = fem.locate_dofs_geometrical((V.sub(c), W), lambda x: np.isclose(x[c], 0.0) & (x[2] > upper))
        bcs.append(fem.dirichletbc(fem.Function(W), side, V.sub(c)))
    heights = {1: LOWER + SMALL, 2: LOWER, 3: LOWER + UPPER + SMALL}
    facets = {
        tag: mesh.locate_entities_boundary(V.mesh, 2, lambda x: np.isclose(x[2], z, rtol=0.0, atol=0.1 * SMALL))
        for tag, z in heights.items()
    }
    numbers = np.concatenate(list(facets.values()))
    values = np.concatenate([np.full(len(found), tag, dtype=np.int32) for tag, found in facets.items()])
    order = np.argsort(numbers)
    tags = mesh.meshtags(V.mesh, 2, numbers[order], values[order])
    pair = di.ContactPair(tags, slave=1, master=2)
    kinds = {"multipliers": [di.Lagrange(pair)], "springs": [di.Penalty(pair, penalty=20.0)], "none": []}
    loads = [di.Traction(tags, 3, (0.0, 0.0, -1e-3))]
    if contact == "none":
        loads = [di.Traction(tags, 2, (1e-3, 0.0, -1e-3))]
    before, LIMITS.patience = LIMITS.patience, MANY
    try:
        return di.StaticProblem(
            fem.Function(V), di.LinearElastic(1.0, 0.3), bcs=bcs, loads=loads, contact=kinds[contact],
            options={"pc_type": "cholesky"},
        )  # fmt: skip
    finally:
        LIMITS.patience = before


def check_factors_of_multipliers_serve_without_them():
    """Gaps are released (ReleasedFactors.h): for springs, and for a block that is lifted off."""
    V = stacked()
    first = pressed(V, "multipliers")
    solved(first)
    assert COMM.allreduce(int(first.contact[0].active.sum()), MPI.SUM) == 16
    for contact, most in (("springs", 30), ("none", 12)):
        expected = solved(pressed(V, contact))
        second, before = pressed(V, contact), first.linear_solver.num_iterations
        second.share_linear_solver(first)
        np.testing.assert_allclose(solved(second), expected, rtol=0, atol=1e-8 * np.abs(expected).max())
        assert second.linear_solver.num_set_ups == first.linear_solver.num_set_ups == 1
        assert second.linear_solver.num_iterations - before < most
    solved(first)
    assert first.linear_solver.num_set_ups == 1


def check_what_cannot_be_shared():
    V = beside_each_other()
    first = loaded(V, 0.0)
    with pytest.raises(TypeError, match="give a StaticProblem"):
        first.share_linear_solver(first.linear_solver)
    with pytest.raises(ValueError, match="displacements on one space"):
        first.share_linear_solver(loaded(beside_each_other(), 0.0))
