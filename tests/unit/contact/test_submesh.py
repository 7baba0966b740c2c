# SPDX-License-Identifier: MIT
"""Contact on a submesh, whose cells have no numbers in any input."""

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.common.cell_numbers import has_input


def two_blocks():
    """A square without its middle row of cells: displacement space and facet tags (1: slave, 2: master)."""
    square = mesh.create_rectangle(MPI.COMM_SELF, [[0.0, 0.0], [1.0, 1.0]], [4, 5], mesh.CellType.quadrilateral)
    middles = mesh.compute_midpoints(square, 2, np.arange(20, dtype=np.int32))
    kept = np.flatnonzero(np.abs(middles[:, 1] - 0.5) > 0.05).astype(np.int32)
    blocks = mesh.create_submesh(square, 2, kept)[0]
    sides = [mesh.locate_entities_boundary(blocks, 1, lambda x, y=y: np.isclose(x[1], y)) for y in (0.6, 0.4)]
    facets, values = np.hstack(sides), np.repeat(np.array([1, 2], dtype=np.int32), [len(side) for side in sides])
    order = np.argsort(facets)
    tags = mesh.meshtags(blocks, 1, facets[order], values[order])
    return fem.functionspace(blocks, ("Lagrange", 1, (2,))), tags


@pytest.mark.parametrize("method", (di.Penalty, di.Kinematic))
def test_blocks_of_a_submesh_collide(method, tmp_path):
    V, tags = two_blocks()
    assert not has_input(V.mesh.topology)  # what this test is about
    velocity = fem.Function(V)
    upper = V.tabulate_dof_coordinates()[:, 1] > 0.5
    velocity.x.array.reshape(-1, 2)[upper, 1] = -0.1
    law = di.LinearElastic(1.0, 0.0, 1.0, "plane_strain")
    problem = di.ExplicitProblem(fem.Function(V), law, velocity=velocity, contact=[method(di.ContactPair(tags, 1, 2))])
    before = problem.mass.array @ problem.velocity.x.array
    problem.advance(2.5, progress=False)
    assert problem.force_history[0][:, 1].max() > 0.0
    after = problem.mass.array @ problem.velocity.x.array
    assert after == pytest.approx(before, rel=1e-12)  # momentum, to round-off
    assert abs(problem.energy["drift"]) < 1e-10
    with pytest.raises(RuntimeError, match="a submesh does not have"):
        problem.save(tmp_path / "run.h5")
    with pytest.raises(RuntimeError, match="unstable"):  # names a cell
        problem.advance(60.0, dt=1.5 * problem.stable_step(), unsafe=True, energy_limits=None, progress=False)
