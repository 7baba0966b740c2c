# SPDX-License-Identifier: MIT
"""Problems of the catalogue's materials on a machine without compilers and with empty caches: a script of its own.

Usage: python3 without_compiler.py CELL DEGREE HYPOTHESIS
"""

import sys

import numpy as np
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di

COMM = MPI.COMM_WORLD
SLAVE, MASTER, TOP = 1, 2, 3
DIM = {"triangle": 2, "quadrilateral": 2, "tetrahedron": 3, "hexahedron": 3}


def blocks(cell):
    """Two blocks, one on the other: a row of cells between them is left out."""
    dim = DIM[cell]
    create, kind = (mesh.create_rectangle if dim == 2 else mesh.create_box), getattr(mesh.CellType, cell)
    low, high = np.array([1.0, 0.0, 0.0])[:dim], np.array([2.0, 1.5, 1.0])[:dim]
    whole = create(COMM, [low, high], [2, 3, 2][:dim], kind, ghost_mode=mesh.GhostMode.shared_facet)
    imap = whole.topology.index_map(dim)
    cells = np.arange(imap.size_local + imap.num_ghosts, dtype=np.int32)
    y = mesh.compute_midpoints(whole, dim, cells)[:, 1]
    domain = mesh.create_submesh(whole, dim, cells[(y < 0.5) | (y > 1.0)])[0]
    domain.geometry.x[domain.geometry.x[:, 1] > 0.75, 1] -= 0.5
    return domain


def problem_of(kind, domain, degree, hypothesis):
    dim = domain.topology.dim
    domain.topology.create_connectivity(dim - 1, dim)
    V = fem.functionspace(domain, ("Lagrange", degree, (dim,)))
    u = fem.Function(V, name="displacement")
    imap = domain.topology.index_map(dim)
    cells = np.arange(imap.size_local + imap.num_ghosts, dtype=np.int32)
    middle = mesh.compute_midpoints(domain, dim, cells)[:, 1]
    tags = mesh.meshtags(domain, dim, cells, np.where(middle < 0.5, 1, 2).astype(np.int32))
    boundary = mesh.exterior_facet_indices(domain.topology)
    points = mesh.compute_midpoints(domain, dim - 1, boundary)
    to_cell = domain.topology.connectivity(dim - 1, dim)
    above = np.array([middle[to_cell.links(f)[0]] > 0.5 for f in boundary], dtype=bool)
    between = np.isclose(points[:, 1], 0.5)
    sides = [(SLAVE, between & above), (MASTER, between & ~above), (TOP, np.isclose(points[:, 1], 1.0))]
    facets = np.concatenate([boundary[where] for _, where in sides]).astype(np.int32)
    values = np.concatenate([np.full(where.sum(), tag, dtype=np.int32) for tag, where in sides])
    order = np.argsort(facets)
    facet_tags = mesh.meshtags(domain, dim - 1, facets[order], values[order])
    bcs = []
    for axis, where in ((1, lambda x: np.isclose(x[1], 0.0)), *((i, None) for i in range(dim) if i != 1)):
        found = fem.locate_dofs_topological(
            V.sub(axis), dim - 1, mesh.locate_entities_boundary(domain, dim - 1, where or (lambda x: x[0] > -1.0))
        )
        bcs.append(fem.dirichletbc(0.0, found, V.sub(axis)))
    soft, stiff = (di.LinearElastic(E, 0.3, 1.0, hypothesis) for E in (1e3, 2e3))
    push = np.zeros(dim)
    push[1] = -1.0
    options = {
        "bcs": bcs,
        "loads": [di.Traction(facet_tags, TOP, push), di.BodyForce(push)],
    }
    pair = di.ContactPair(facet_tags, slave=SLAVE, master=MASTER)
    material = di.MaterialMap(tags, {1: soft, 2: stiff})
    if kind == "static":
        problem = di.StaticProblem(u, material, contact=[di.Lagrange(pair)], **options)
        problem.solve()
    elif kind == "implicit":
        problem = di.NewmarkProblem(u, material, contact=[di.Lagrange(pair)], **options)
        problem.advance(until=0.02, dt=0.01)
    else:
        problem = di.ExplicitProblem(u, material, contact=[di.Penalty(pair)], **options)
        problem.advance(until=0.02)
    moved = COMM.allreduce(float(np.abs(u.x.array).max()), MPI.MAX)
    stress = COMM.allreduce(float(problem.von_mises.at_nodes().x.array.max()), MPI.MAX)
    assert moved > 0.0 and np.isfinite(stress) and stress > 0.0
    return moved, stress


def main():
    cell, degree, hypothesis = sys.argv[1:]
    for kind in ("static", "implicit", "explicit"):
        found = problem_of(kind, blocks(cell), int(degree), hypothesis)
        if COMM.rank == 0:
            print(kind, *(f"{value:.6e}" for value in found), flush=True)


main()
