# SPDX-License-Identifier: MIT
"""Explicit runs compute owned cells and exchange what they need, whatever ghost cells a mesh came with. See
on_ranks.py."""

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import compat

COMM = MPI.COMM_WORLD
MODES = ("none", "shared_facet", "shared_vertex")


def two_boxes(mode):
    """A box above another one, in one mesh, whose nodes do not meet: cells in the order of the ranks along x."""
    n, x, cells = 5, [], []
    for k, (low, high) in enumerate((((0.0, 0.0, 0.0), (1.0, 1.0, 0.4)), ((0.13, 0.11, 0.402), (0.83, 0.91, 0.8)))):
        grids = [np.linspace(a, b, n + 1 - k) for a, b in zip(low, high)]
        count = n + 1 - k
        number = k * (n + 1) ** 3 + np.arange(count**3).reshape(count, count, count)
        x.append(np.stack(np.meshgrid(*grids, indexing="ij"), axis=-1).reshape(-1, 3))
        corners = [number[i : i + count - 1, j : j + count - 1, m : m + count - 1].ravel()
                   for m in (0, 1) for j in (0, 1) for i in (0, 1)]  # fmt: skip
        cells.append(np.column_stack(corners))
    points, all_cells = np.concatenate(x), np.concatenate(cells)
    if COMM.rank > 0:
        points, all_cells = points[:0], all_cells[:0]
    element = mesh.create_unit_cube(MPI.COMM_SELF, 1, 1, 1, mesh.CellType.hexahedron).ufl_domain()
    return mesh.create_mesh(
        COMM,
        all_cells.astype(np.int64),
        x=points,
        e=element.ufl_coordinate_element(),
        partitioner=compat.create_cell_partitioner(getattr(mesh.GhostMode, mode)),
    )


def run(mode, method=None):
    """The upper box thrown at the lower one; problem, messages and values that all ranks send in a step."""
    domain = two_boxes(mode)
    V = fem.functionspace(domain, ("Lagrange", 1, (3,)))
    velocity = fem.Function(V)
    velocity.interpolate(lambda x: np.where(x[2] > 0.401, 1.0, 0.0) * np.array([[0.5], [0.2], [-1.0]]))
    tags, contact = [], []
    for marker in (lambda x: np.isclose(x[2], 0.402), lambda x: np.isclose(x[2], 0.4)):
        tags.append(mesh.locate_entities_boundary(domain, 2, marker))
    found, values = np.concatenate(tags), np.repeat([1, 2], [len(t) for t in tags])
    order = np.argsort(found)
    facet_tags = mesh.meshtags(domain, 2, found[order].astype(np.int32), values[order].astype(np.int32))
    if method is not None:
        contact = [method(di.ContactPair(facet_tags, slave=1, master=2, friction=0.3))]
    law = di.NeoHookean(1e3, 0.3, 1.0, "3d")
    problem = di.ExplicitProblem(fem.Function(V), law, velocity=velocity, contact=contact)
    problem.advance(0.02, progress=False)
    return problem, COMM.allreduce(np.array(problem._cpp_object.integrator.traffic) / problem.step)


def owned_sum(problem):
    """Sum of squared displacements over all nodes."""
    owned = problem.u.x.array[: problem.num_owned]
    return COMM.allreduce(float(owned @ owned))


def cells_computed(problem):
    """Cells that all ranks compute in a step."""
    parts = problem._bodies.internal._parts
    return COMM.allreduce(sum(part._cpp_object.flops for part in parts) / parts[0]._kernels[0].flops)


def check_no_more_is_exchanged():
    """Values that are sent: those of nodes at which cells of several ranks meet, to and fro, three each."""
    for mode in MODES:
        problem, (messages, values) = run(mode)
        V, topology = problem.space, problem.space.mesh.topology
        num_cells, owned = topology.index_map(3).size_local, V.dofmap.index_map.size_local
        needed = np.unique(V.dofmap.list[:num_cells])
        count = COMM.allreduce(int(np.sum(needed >= owned)))
        owners = np.asarray(V.dofmap.index_map.owners)[needed[needed >= owned] - owned]
        assert cells_computed(problem) == topology.index_map(3).size_global == 125 + 64
        # One exchange each way in each step, and a few more at the start, at the end, and for results.
        steps = problem.step
        assert 2 * 3 * count <= values <= 2 * 3 * count * (steps + 3) / steps
        assert messages <= 2 * COMM.allreduce(len(np.unique(owners))) * (steps + 3) / steps


def check_the_same_run():
    """With contact, penalty and kinematic: the ghost cells of a mesh change nothing but round-off."""
    for method in (di.Penalty, di.Kinematic):
        runs = [run(mode, method) for mode in MODES]
        found = [(owned_sum(p), *p.contact[0].force, p.energy["kinetic"]) for p, _ in runs]
        assert np.abs(found[0][1:4]).max() > 0.0, "the boxes meet"
        for values in found[1:]:
            # Sums over 100 steps in another order; partitions differ, and so does round-off: some 1e-14 a step.
            assert values == pytest.approx(found[0], rel=1e-9)


def check_ghosts_are_up_to_date():
    """Functions that users read have the values of the owners at all ghosts, also those that no cell of a rank has."""

    def stale(f):
        before = f.x.array.copy()
        f.x.scatter_forward()
        return COMM.allreduce(int(np.sum(before != f.x.array)))

    for mode in MODES:
        problem, _ = run(mode, di.Penalty)
        assert [stale(f) for f in (problem.u, problem.velocity, problem.acceleration)] == [0, 0, 0], mode
        seen = []
        problem.advance(problem.time + 0.01, progress=False, callback=lambda p: seen.append(stale(p.u)))
        assert seen and not any(seen), mode
