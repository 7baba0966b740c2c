# SPDX-License-Identifier: MIT
"""Bodies in one mesh, each with a grid of its own that is mapped, and a velocity, for contact that finds itself."""

import basix.ufl
import numpy as np
import ufl
from box_bodies import grid
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import compat


class Flying:
    """Bodies with their velocities; the cells are given to the ranks at random.

    Args:
        bodies: list of (counts along the axes, map of points in the unit box, velocity as vector or function of
            undeformed points (n, dim) -> (n, dim)).
        cell: kind of the cells.
        law: material.
    """

    def __init__(self, bodies, cell, law=None, comm=MPI.COMM_WORLD):
        dim = len(bodies[0][0])
        parts = [grid((0,) * dim, (1,) * dim, counts, cell) for counts, *_ in bodies]
        maps = [b[1] for b in bodies]
        parts = [_joined(m(p), c) for m, (p, c) in zip(maps, parts)]
        first = np.cumsum([0, *(len(p) for p, _ in parts)])
        points = np.vstack([p for p, _ in parts])
        cells = np.vstack([c + start for (_, c), start in zip(parts, first)])
        body = np.concatenate([np.full(len(c), b) for b, (_, c) in enumerate(parts)])
        if comm.rank:
            cells, points = cells[:0], points[:0]
        ranks = np.random.default_rng(1).integers(0, comm.size, len(body)).astype(np.int32)

        def scattered(comm, count, *_):
            own = ranks if comm.rank == 0 else ranks[:0]
            return compat.adjacencylist(own, np.arange(len(own) + 1, dtype=np.int32))

        element = ufl.Mesh(basix.ufl.element("Lagrange", cell, 1, shape=(dim,)))
        self.dim, self.comm = dim, comm
        self.mesh = m = mesh.create_mesh(comm, cells, x=points, e=element, partitioner=scattered)
        for a, b in ((dim - 1, dim), (dim, dim - 1)):
            m.topology.create_connectivity(a, b)
        self.V = fem.functionspace(m, ("Lagrange", 1, (dim,)))
        self.X = self.V.tabulate_dof_coordinates()[:, :dim]
        of_cell = body[m.topology.original_cell_index]
        self.body = np.zeros(len(self.X), dtype=int)
        for c, nodes in enumerate(self.V.dofmap.list):
            self.body[nodes] = of_cell[c]
        self.velocity = fem.Function(self.V)
        v = self.velocity.x.array.reshape(-1, dim)
        for b, (_, _, given) in enumerate(bodies):
            own = self.body == b
            v[own] = given(self.X[own]) if callable(given) else given
        facets = mesh.exterior_facet_indices(m.topology)
        tagged = []
        for f in facets:
            c = m.topology.connectivity(dim - 1, dim).links(f)[0]
            tagged.append(of_cell[c] + 1)
        self.tags = mesh.meshtags(m, dim - 1, facets, np.array(tagged, dtype=np.int32))
        self.law = law or di.NeoHookean(
            1000.0, 0.3, density=1.0, **({"hypothesis": "plane_strain"} if dim == 2 else {})
        )

    def problem(self, friction=0.0, contact=None, **options):
        contact = [di.GeneralContact(self.tags, friction=friction)] if contact is None else contact
        return di.ExplicitProblem(fem.Function(self.V), self.law, velocity=self.velocity, contact=contact, **options)

    def _owned(self, problem):
        n = self.V.dofmap.index_map.size_local
        m = problem.mass.array[: n * self.dim].reshape(-1, self.dim)
        v = problem.velocity.x.array[: n * self.dim].reshape(-1, self.dim)
        x = (self.X + problem.u.x.array.reshape(-1, self.dim))[:n]
        return n, m, v, x

    def momentum(self, problem, body=None):
        n, m, v, _ = self._owned(problem)
        which = slice(None) if body is None else self.body[:n] == body
        return self.comm.allreduce((m * v)[which].sum(axis=0), MPI.SUM)

    def angular_momentum(self, problem):
        _, m, v, x = self._owned(problem)
        if self.dim == 2:
            return self.comm.allreduce(np.array([(m[:, 0] * (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0])).sum()]), MPI.SUM)
        return self.comm.allreduce((m * np.cross(x, v)).sum(axis=0), MPI.SUM)

    def mean_velocity(self, problem, body):
        n, m, _, _ = self._owned(problem)
        return self.momentum(problem, body) / self.comm.allreduce(m[self.body[:n] == body, 0].sum(), MPI.SUM)

    def centre(self, problem, body):
        n, m, _, x = self._owned(problem)
        own = self.body[:n] == body
        sums = self.comm.allreduce(np.concatenate([(m * x)[own].sum(axis=0), [m[own, 0].sum()]]), MPI.SUM)
        return sums[:-1] / sums[-1]


def _joined(points, cells):
    """A grid whose map brings nodes to the same place, as that of a ring does."""
    _, kept, number = np.unique(points.round(9), axis=0, return_index=True, return_inverse=True)
    return points[kept], number.reshape(-1)[cells]


def ring(radius, thickness, middle=(0.0, 0.0)):
    """Map of the unit box onto a ring, around it along the first axis and inward along the second."""

    def place(p):
        angle, r = -2.0 * np.pi * p[:, 0], radius - thickness * p[:, 1]
        return np.column_stack([r * np.cos(angle), r * np.sin(angle)]) + middle

    return place


def box(low, high, turn=None):
    """Map of the unit box onto a box, turned by a matrix about its middle."""
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    middle = 0.5 * (low + high)

    def place(p):
        x = low + p * (high - low)
        return x if turn is None else middle + (x - middle) @ np.asarray(turn).T

    return place


def rotation(axis, angle):
    """Matrix of a rotation about an axis in space."""
    a = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    K = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
