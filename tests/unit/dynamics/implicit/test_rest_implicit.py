# SPDX-License-Identifier: MIT
"""Bodies that touch and are at rest, in static and implicit problems: nothing moves, and nothing stops the solve."""

import itertools

import numpy as np
import pytest
from dolfinx import fem
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import meshes

TOP = 0.7 / 3  # of the floor: no height of a node is exact
CELLS = {2: ("triangle", "quadrilateral"), 3: ("tetrahedron", "hexahedron")}
METHODS = {
    "penalty": di.Penalty,
    "augmented": lambda pair: di.Penalty(pair, augmented=True),
    "multipliers": di.Lagrange,
    "saddle point": lambda pair: di.Lagrange(pair, basis="standard"),
}
# Gaps are zero to 3e-17 m: springs and multipliers answer such overlaps, and nothing else acts.
MOST = 1e-15


def blocks(kind, cell, degree, floor, method, friction):
    """A steel block on a floor that it touches; held above in static problems, free to fly in time."""
    dim = next(d for d, cells in CELLS.items() if cell in cells)
    low = meshes.make(
        "two_blocks", MPI.COMM_SELF, cell=cell, lower=(TOP,) * dim, upper=(0.3 / 7,) * (dim - 1) + (0.1,),
        lower_cells=(2,) * dim, upper_cells=(2,) * (dim - 1) + (1,),
    )  # fmt: skip
    V = fem.functionspace(low.mesh, ("Lagrange", degree, (dim,)))
    up = np.eye(3)[dim - 1, :dim]
    master = low.tags["master_surface"] if floor == "block" else di.RigidPlane(TOP * up, up)
    pair = di.ContactPair(low.facet_tags, low.tags["slave_surface"], master, friction=friction)
    heights = V.tabulate_dof_coordinates()[:, dim - 1]
    still = np.isclose(heights, 0.0) | (np.isclose(heights, heights.max()) if kind is di.StaticProblem else False)
    law = di.LinearElastic(200e9, 0.3, 7800.0, "plane_strain" if dim == 2 else None)
    bcs = [fem.dirichletbc(np.zeros(dim), np.flatnonzero(still).astype(np.int32), V)]
    return kind(fem.Function(V), law, bcs=bcs, contact=[METHODS[method](pair)])


def rows():
    """Obstacles take dual multipliers only."""
    kinds, cells = (di.StaticProblem, di.NewmarkProblem), sum(CELLS.values(), ())
    table = itertools.product(kinds, cells, (1, 2), ("plane", "block"), METHODS, (0.0, 0.3))
    return [row for row in table if row[3:5] != ("plane", "saddle point")]


@pytest.mark.covering(2)
@pytest.mark.parametrize("kind, cell, degree, floor, method, friction", rows())
def test_bodies_that_touch_stay_at_rest(kind, cell, degree, floor, method, friction):
    problem = blocks(kind, cell, degree, floor, method, friction)
    if kind is di.StaticProblem:
        assert problem.solve(progress=False).converged
    else:
        problem.advance(5e-5, dt=1e-5, progress=False)
        assert problem.time == 5e-5
    assert np.max(np.abs(problem.u.x.array)) < MOST


@pytest.mark.parametrize("method", ("multipliers", "saddle point"))
def test_the_least_load_is_not_taken_for_rest(method):
    """A weight whose pressure is a few hundred times that of gaps of round-off arrives below whole."""
    problem = blocks(di.StaticProblem, "quadrilateral", 1, "block", method, 0.3)
    V = problem.space
    weight = 1e-3  # [N/m]
    height = V.tabulate_dof_coordinates()[:, 1]
    low = fem.dirichletbc(np.zeros(2), np.flatnonzero(np.isclose(height, 0.0)).astype(np.int32), V)
    block = di.BodyForce((0.0, -weight / (7800.0 * (0.3 / 7 * 0.1 + TOP * TOP))))
    problem = di.StaticProblem(
        fem.Function(V), problem.material, bcs=[low], loads=[block], contact=[METHODS[method](problem.contact[0].pair)]
    )
    problem.solve(progress=False)
    upper = 0.3 / 7 * 0.1 / (0.3 / 7 * 0.1 + TOP * TOP)  # share of the weight
    # Gaps of round-off redistribute the pressure, not its sum: equilibrium holds to the solver's tolerance.
    assert problem.contact[0].force[1] == pytest.approx(weight * upper, rel=1e-3)
