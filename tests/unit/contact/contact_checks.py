# SPDX-License-Identifier: MIT
"""Contact problems whose bodies are cut by the ranks, against the same problem on one rank. See
on_ranks.py."""

from functools import partial

import numpy as np
from dolfinx import fem, mesh
from mpi4py import MPI
from scipy.spatial import cKDTree

import dolfinx_impact as di
from dolfinx_impact import meshes

COMM = MPI.COMM_WORLD
# The same equations, summed and solved in another order: round-off times the condition of some hundred unknowns.
SAME = 1e-10


def blocks(comm, dim):
    """Block on a wider block, not matching."""
    size = {"lower": (1.4, 0.5), "upper": (1.0, 0.5), "lower_cells": (7, 4), "upper_cells": (6, 4)}
    if dim == 3:
        size = {"lower": (1.4, 1.2, 0.5), "upper": (1.0, 0.8, 0.5), "lower_cells": (5, 4, 2), "upper_cells": (4, 3, 2)}
    return meshes.make("two_blocks", comm, **size)


def pressed(comm, dim, contact, friction=0.3, degree=1, pull=None, rtol=1e-10, options=None):
    """Press the upper block down, then pull it sideways; positions, results and totals of the contact points."""
    made = blocks(comm, dim)
    domain, tags = made.mesh, made.tags
    V = fem.functionspace(domain, ("Lagrange", degree, (dim,)))
    u = fem.Function(V)
    ends = [fem.locate_dofs_topological(V, dim - 1, made.facet_tags.find(tags[n])) for n in ("bottom", "top")]
    move = fem.Constant(domain, np.zeros(dim))
    bcs = [fem.dirichletbc(np.zeros(dim), ends[0], V), fem.dirichletbc(move, ends[1], V)]
    pair = di.ContactPair(made.facet_tags, tags["slave_surface"], tags["master_surface"], friction=friction)
    law = di.LinearElastic(1e3, 0.3, 1.0, "3d" if dim == 3 else "plane_strain")
    problem = di.StaticProblem(u, law, bcs=bcs, contact=[contact(pair)], options=options)
    move.value[dim - 1] = -0.02
    problem.solve(steps=2, rtol=rtol)
    move.value[0] = pull or (0.015 if dim == 2 else 0.009)
    report = problem.solve(steps=2, rtol=rtol)
    c = problem.contact[0]
    arrays = [c.points, c.pressure, c.traction, c.status, np.where(np.isfinite(c.gap), c.gap, 9.0)]
    arrays = [np.concatenate(comm.allgather(np.asarray(a, dtype=float))) for a in arrays]
    nodal = c.contact_forces().reshape(-1, dim).sum(axis=0)
    return arrays, c.force, c.area, comm.allreduce(nodal, MPI.SUM), report


def check_ranks():
    """Pressures, tractions, gaps, status, force and area are the same; slave and master forces are opposite."""
    standard = partial(di.Lagrange, basis="standard")
    for dim in (2, 3):
        for contact in (di.Lagrange, standard, lambda pair: di.Penalty(pair, penalty=1e5)):
            here = pressed(COMM, dim, contact)
            alone = pressed(MPI.COMM_SELF, dim, contact)
            scale = alone[0][1].max()
            assert np.any(alone[0][3] == 2) and np.any(alone[0][3] == 1), "some points slip, some stick"
            assert here[0][0].shape == alone[0][0].shape
            match = cKDTree(here[0][0]).query(alone[0][0])[1]
            assert len(np.unique(match)) == len(match)
            here[0][:] = [a[match] for a in here[0]]
            for a, b, size in zip(here[0], alone[0], (1.0, scale, scale, 1.0, 1.0)):
                assert a.shape == b.shape and np.abs(a - b).max() < SAME * size
            assert np.abs(here[1] - alone[1]).max() < SAME * np.abs(alone[1]).max()
            assert abs(here[2] - alone[2]) < SAME
            assert np.abs(here[3]).max() < 1e-12 * np.abs(alone[1]).max()


def check_coulomb():
    """No traction beyond friction times pressure; it opposes the slip; no adhesion; no penetration."""
    for dim in (2, 3):
        for contact in (di.Lagrange, lambda pair: di.Penalty(pair, penalty=1e5)):
            (_, pressure, traction, status, gap), force, *_ = pressed(COMM, dim, contact)
            tangential = np.linalg.norm(traction[:, : dim - 1], axis=1)  # the surfaces stay nearly horizontal
            scale = pressure.max()
            assert np.all(pressure >= 0.0)
            full = np.linalg.norm(traction, axis=1)
            assert np.all(full**2 <= (1 + 0.3**2) * pressure**2 + 1e-9 * scale**2)
            slips = status == 2
            assert np.allclose(full[slips] ** 2, (1 + 0.3**2) * pressure[slips] ** 2, atol=1e-9 * scale**2)
            assert np.all(np.abs(traction[status == 0]) == 0.0) and tangential.max() > 0.1 * scale
            assert force[0] < 0.0, "the upper block is pulled to the right: friction on it points to the left"
            if contact is di.Lagrange:
                assert gap.min() > -1e-11 and np.abs(pressure * gap)[gap < 1.0].max() < 1e-10 * scale


def check_errors_everywhere():
    """A failing problem raises the same error on all ranks and leaves u as it was."""
    made = blocks(COMM, 2)
    V = fem.functionspace(made.mesh, ("Lagrange", 1, (2,)))
    u = fem.Function(V)
    bottom = fem.locate_dofs_topological(V, 1, made.facet_tags.find(made.tags["bottom"]))
    pair = di.ContactPair(made.facet_tags, made.tags["slave_surface"], made.tags["master_surface"])
    press = di.Traction(made.facet_tags, made.tags["top"], (0.0, -1.0))
    problem = di.StaticProblem(
        u,
        di.LinearElastic(1e3, 0.3, 1.0, "plane_strain"),
        bcs=[fem.dirichletbc(np.zeros(2), bottom, V)],
        loads=[press],
        contact=[di.Lagrange(pair)],
    )
    try:
        problem.solve()
        message = "no error"
    except RuntimeError as e:
        message = str(e)
    assert all(m == message for m in COMM.allgather(message))
    assert "the body around (0.7, 0.75) is free to move along x" in message, message
    assert np.all(u.x.array == 0.0)


def check_cut_back():
    """An increment that does not converge is halved, and the report says so; the whole way is gone all the same."""
    domain = mesh.create_unit_square(COMM, 6, 6, mesh.CellType.quadrilateral)
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    u = fem.Function(V, name="u")
    top = mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[1], 1.0))
    tags = mesh.meshtags(domain, 1, np.sort(top), np.full(len(top), 3, dtype=np.int32))
    bottom = fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[1], 0.0))
    plate = di.RigidPlane((0.0, 1.0), (0.0, -1.0))
    problem = di.StaticProblem(
        u,
        di.NeoHookean(1.0, 0.3, 1.0, "plane_strain"),
        bcs=[fem.dirichletbc(np.zeros(2), bottom, V)],
        contact=[di.Lagrange(di.ContactPair(tags, 3, plate))],
    )
    plate.displacement = (0.0, -0.4)
    report = problem.solve(max_iterations=4)
    assert report.converged and report.cut_backs > 0 and report.fractions[-1] == 1.0
    assert sorted(report.fractions) == report.fractions and len(report.iterations) > 1
    assert f"cut back {report.cut_backs} times" in report.table()
    lowest = COMM.allreduce(float(np.max(problem.contact[0].points[:, 1], initial=-1.0)), MPI.MAX)
    assert abs(lowest - 0.6) < 1e-10
