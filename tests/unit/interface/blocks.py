# SPDX-License-Identifier: MIT
"""Two blocks one upon the other whose meshes do not match, on all ranks: bodies of laws of the interface."""

import copy

import basix.ufl
import numpy as np
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import compat

SLAVE, MASTER, TOP, BOTTOM = 3, 4, 5, 6


def box(cell, low, high, n):
    """Points and cells of a box."""
    kind = mesh.CellType[cell]
    if len(n) == 2:
        made = mesh.create_rectangle(MPI.COMM_SELF, [low, high], n, kind)
    else:
        made = mesh.create_box(MPI.COMM_SELF, [low, high], n, kind)
    cells = np.array(compat.geometry_dofmap(made), dtype=np.int64)
    return made.geometry.x[:, : len(n)].copy(), cells


class Blocks:
    """A block from x = 0 to 1 with its top at 1, and one that stands on it at a gap.

    Args:
        cell: cell.
        lower, upper: number of cells along each axis.
        gap: distance of the upper block [L].
        degree: of the displacement.
        rough: size of random displacements of the nodes of both blocks [L].
        narrow: the upper block's distance from the sides of the lower one [L].
    """

    def __init__(self, cell, lower, upper, gap=0.0, degree=1, rough=0.0, narrow=0.0):
        dim, root = len(lower), MPI.COMM_WORLD.rank == 0
        split = 1.0 + gap + 1e-3  # the blocks are apart while facets are told apart
        parts = []
        if root:
            low, high = [narrow] * (dim - 1) + [split], [1.0 - narrow] * (dim - 1) + [split + 0.5]
            parts = [box(cell, [0.0] * dim, [1.0] * dim, lower), box(cell, low, high, upper)]
        points = np.vstack([p for p, _ in parts]) if root else np.zeros((0, dim))
        corners = {"triangle": 3, "quadrilateral": 4, "tetrahedron": 4, "hexahedron": 8}[cell]
        cells = np.vstack([parts[0][1], parts[1][1] + len(parts[0][0])]) if root else np.zeros((0, corners), np.int64)
        element = ufl.Mesh(basix.ufl.element("Lagrange", cell, 1, shape=(dim,)))
        self.mesh = mesh.create_mesh(MPI.COMM_WORLD, cells, x=points, e=element)
        heights = {SLAVE: split, MASTER: 1.0, TOP: split + 0.5, BOTTOM: 0.0}
        found = {
            tag: mesh.locate_entities_boundary(self.mesh, dim - 1, lambda x, z=z: np.isclose(x[dim - 1], z))
            for tag, z in heights.items()
        }
        facets = np.concatenate(list(found.values()))
        values = np.repeat(list(found), [len(f) for f in found.values()]).astype(np.int32)
        order = np.argsort(facets)
        self.tags = mesh.meshtags(self.mesh, dim - 1, facets[order], values[order])
        x = self.mesh.geometry.x
        x[x[:, dim - 1] > split - 5e-4, dim - 1] -= 1e-3
        self.dim = dim
        self.V = fem.functionspace(self.mesh, ("Lagrange", degree, (dim,)))
        self.u = fem.Function(self.V)
        self.rough = rough

    def again(self):
        """The same mesh with another displacement, for results that are compared: DOLFINx may partition a second mesh
        otherwise."""
        other = copy.copy(self)
        other.u = fem.Function(self.V)
        return other

    def held(self, tag, *components):
        """Conditions that hold components of a side at zero."""
        facets = self.tags.find(tag)
        return [
            fem.dirichletbc(0.0, fem.locate_dofs_topological(self.V.sub(c), self.dim - 1, facets), self.V.sub(c))
            for c in components
        ]

    def pair(self, **options):
        """The upper block's face on the lower one's."""
        return di.ContactPair(self.tags, slave=SLAVE, master=MASTER, **options)

    def random(self, size, seed=1):
        """Random displacements that do not depend on the ranks."""
        rng = np.random.default_rng(seed)
        waves, phases = rng.normal(size=(self.dim, self.dim)) * 3.0, rng.uniform(0, 6, self.dim)
        out = fem.Function(self.V)
        out.interpolate(lambda x: size * np.sin(waves @ x[: self.dim] + phases[:, None]))
        return out

    def total(self, values):
        """Sum over the ranks."""
        return self.mesh.comm.allreduce(np.sum(values, axis=0), MPI.SUM)
