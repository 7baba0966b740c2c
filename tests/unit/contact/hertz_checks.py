# SPDX-License-Identifier: MIT
"""Hertz's contacts on gmsh meshes whose cells are given to the ranks at random, so that the contact zone is split,
against one rank. See on_ranks.py."""

import numpy as np
from dolfinx import fem
from idle_rank import working_ranks
from mpi4py import MPI
import partitioned_bodies
from scipy.spatial import cKDTree

import dolfinx_impact as di
from dolfinx_impact import meshes


COMM = MPI.COMM_WORLD
# The same equations, summed and solved in another order: round-off times the condition of a few hundred unknowns.
SAME = 1e-10
SIZES = dict(radius=10.0, a=1.0, width=6.0, height=6.0, coarse=3.0)
FACETS = {2: 0.3, 3: 0.4}  # edges of the contact zone, by dimension
RECIPES = {2: ("cylinder_on_half_plane", "triangle"), 3: ("sphere_on_half_space", "tetrahedron")}


def pressed(comm, dim, method, partitioner=None):
    """A round body pressed on a block by a displacement: contact points with pressure, gap, traction; force, area."""
    recipe, cell = RECIPES[dim]
    m = meshes.make(recipe, comm, cell=cell, h=FACETS[dim], partitioner=partitioner, **SIZES)
    V = fem.functionspace(m.mesh, ("Lagrange", 1, (dim,)))
    down = fem.Constant(m.mesh, -0.3)
    sides = [("bottom", axis, 0.0) for axis in range(dim)] + [("symmetry_x", 0, 0.0), ("top", dim - 1, down)]
    sides += [("symmetry_y", 1, 0.0)] if dim == 3 else []
    bcs = []
    for name, axis, value in sides:
        dofs = fem.locate_dofs_topological(V.sub(axis), dim - 1, m.facet_tags.find(m.tags[name]))
        bcs.append(fem.dirichletbc(value, dofs, V.sub(axis)))
    pair = di.ContactPair(m.facet_tags, m.tags["slave_surface"], m.tags["master_surface"])
    law = di.LinearElastic(1e3, 0.3, 1.0, "3d" if dim == 3 else "plane_strain")
    problem = di.StaticProblem(fem.Function(V), law, bcs=bcs, contact=[method(pair)])
    problem.solve(rtol=1e-12)
    c = problem.contact[0]
    ranks = comm.allreduce(int(np.any(c.status > 0)), MPI.SUM)
    arrays = [c.points, c.pressure, c.traction, np.where(np.isfinite(c.gap), c.gap, 9.0), c.status]
    return [np.concatenate(comm.allgather(np.asarray(a, dtype=float))) for a in arrays], c.force, c.area, ranks


def check_hertz():
    """Places, pressures, tractions, gaps, status, force and area are those of one rank."""
    for dim in RECIPES:
        for method in (di.Lagrange, lambda pair: di.Penalty(pair, penalty=1e4)):
            here = pressed(COMM, dim, method, partitioned_bodies.scattered(4) if COMM.size > 1 else None)
            alone = pressed(MPI.COMM_SELF, dim, method)
            assert here[3] > 1 or working_ranks(COMM) == 1, "the contact is split between ranks"
            assert np.count_nonzero(alone[0][4]) > 3
            match = cKDTree(here[0][0]).query(alone[0][0])[1]
            assert len(np.unique(match)) == len(match) == len(here[0][0])
            scale = alone[0][1].max()
            for name, a, b, size in zip(
                ("places", "pressures", "tractions", "gaps", "status"), here[0], alone[0], (1.0, scale, scale, 1.0, 1.0)
            ):
                difference = np.abs(a[match] - b).max() / size
                assert difference < SAME, (dim, name, difference)
            assert np.abs(here[1] - alone[1]).max() < SAME * np.abs(alone[1]).max()
            assert abs(here[2] - alone[2]) < SAME * alone[2]
