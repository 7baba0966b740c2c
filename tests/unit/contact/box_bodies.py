# SPDX-License-Identifier: MIT
"""Boxes in one mesh, whose cells are given to the ranks at random: bodies of tests that need several contacts."""

import itertools

import basix.ufl
import numpy as np
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from over_ranks import smallest

import dolfinx_impact as di
from dolfinx_impact import compat

CELLS = {2: ("quadrilateral", "triangle"), 3: ("hexahedron", "tetrahedron")}


def grid(low, high, counts, cell):
    """Points and cells of one box, from its corners, its numbers of cells and the kind of the cells."""
    dim = len(low)
    axes = [np.linspace(a, b, n + 1) for a, b, n in zip(low, high, counts)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, dim)
    number = np.arange(len(points)).reshape([n + 1 for n in counts])
    cells = []
    for corner in itertools.product(*(range(n) for n in counts)):
        # Corners of a cell in DOLFINx's order: the first coordinate runs fastest.
        steps = [step[::-1] for step in itertools.product((0, 1), repeat=dim)]
        nodes = [number[tuple(np.add(corner, step))] for step in steps]
        if cell in ("quadrilateral", "hexahedron"):
            cells.append(nodes)
            continue
        for order in itertools.permutations(range(dim)):  # Kuhn's simplices
            path = np.cumsum([0, *(2**axis for axis in order)])
            cells.append([nodes[k] for k in path])
    return points, np.array(cells, dtype=np.int64)


class Boxes:
    """Boxes side by side, each with a mesh of its own.

    Args:
        boxes: list of (low corner, high corner, cells along the axes).
        cell: kind of the cells.
        degree: of the displacements.
        turn: angle about the origin, in the plane of the first two axes [rad].
        poisson: Poisson's ratio; Young's modulus is 1000.
        comm: communicator.
    """

    def __init__(self, boxes, cell, degree=1, turn=0.0, poisson=0.0, comm=MPI.COMM_WORLD):
        parts = [grid(*box, cell) for box in boxes]
        first = np.cumsum([0, *(len(p) for p, _ in parts)])
        points = np.vstack([p for p, _ in parts])
        cells = np.vstack([c + start for (_, c), start in zip(parts, first)])
        self.dim = points.shape[1]
        self.axes = np.eye(self.dim)
        self.axes[:2, :2] = [[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]  # rows
        body = np.concatenate([np.full(len(c), b) for b, (_, c) in enumerate(parts)])
        if comm.rank:
            cells, points = cells[:0], points[:0]
        ranks = np.random.default_rng(1).integers(0, comm.size, len(body)).astype(np.int32)

        def scattered(comm, count, *_):
            own = ranks if comm.rank == 0 else ranks[:0]
            return compat.adjacencylist(own, np.arange(len(own) + 1, dtype=np.int32))

        element = ufl.Mesh(basix.ufl.element("Lagrange", cell, 1, shape=(self.dim,)))
        self.mesh = mesh.create_mesh(comm, cells, x=points @ self.axes, e=element, partitioner=scattered)
        topology = self.mesh.topology
        for a, b in ((self.dim - 1, self.dim), (self.dim, self.dim - 1)):
            topology.create_connectivity(a, b)
        self.V = fem.functionspace(self.mesh, ("Lagrange", degree, (self.dim,)))
        self.u = fem.Function(self.V)
        facets = mesh.exterior_facet_indices(topology)
        cell_of = [topology.connectivity(self.dim - 1, self.dim).links(f)[0] for f in facets]
        self._facets = facets
        self._body = body[topology.original_cell_index[np.array(cell_of, dtype=np.int64)]]
        self._middle = mesh.compute_midpoints(self.mesh, self.dim - 1, facets)[:, : self.dim] @ self.axes.T
        hypothesis = "plane_strain" if self.dim == 2 else "3d"
        self.law = di.LinearElastic(1000.0, poisson, density=1.0, hypothesis=hypothesis)

    def facets(self, body, axis, at, where=lambda x: True):
        """This rank's facets of a body at a coordinate, in the axes of the boxes."""
        chosen = (self._body == body) & (np.abs(self._middle[:, axis] - at) < 1e-9)
        chosen &= np.array([bool(where(x)) for x in self._middle], dtype=bool)
        return self._facets[chosen]

    def tags(self, surfaces):
        """Tags of surfaces: {tag: arguments of `facets`, or a list of such}."""
        parts = {tag: given if isinstance(given, list) else [given] for tag, given in surfaces.items()}
        found = [(tag, np.concatenate([self.facets(*one) for one in given])) for tag, given in parts.items()]
        facets = np.concatenate([f for _, f in found])
        values = np.concatenate([np.full(len(f), tag, dtype=np.int32) for tag, f in found])
        order = np.argsort(facets)
        return mesh.meshtags(self.mesh, self.dim - 1, facets[order], values[order])

    def hold(self, body, axis, at, *components, value=0.0):
        """Supports of a face along axes of the mesh."""
        facets = self.facets(body, axis, at)
        return [
            fem.dirichletbc(value, fem.locate_dofs_topological(self.V.sub(c), self.dim - 1, facets), self.V.sub(c))
            for c in components
        ]

    def sum(self, values):
        """Sum over the ranks."""
        return self.mesh.comm.allreduce(np.asarray(values, dtype=float), MPI.SUM)

    def lowest(self, component):
        """Smallest component of the displacement, of all ranks."""
        return smallest(self.u.x.array.reshape(-1, self.dim)[:, component], self.mesh.comm)

    def support(self, problem):
        """Sum of the reactions: forces of the supports on the bodies."""
        owned = self.V.dofmap.index_map.size_local * self.dim
        return self.sum(problem.reactions().x.array[:owned].reshape(-1, self.dim).sum(axis=0))

    def imbalance(self, problem):
        """Largest residual at free degrees of freedom, of all ranks."""
        owned = self.V.dofmap.index_map.size_local * self.dim
        left = np.where(problem.fixed[:owned], 0.0, problem.reactions().x.array[:owned])
        return self.mesh.comm.allreduce(float(np.abs(left).max(initial=0.0)), MPI.MAX)
