# SPDX-License-Identifier: MIT
"""Two bodies with a random partition of the mesh, and the facets of their contact surfaces."""

import numpy as np
from dolfinx import fem
from mpi4py import MPI

from dolfinx_impact import _cpp, compat, meshes


def scattered(seed):
    """Partitioner that gives every cell to a random rank; no ghost cells."""

    def partition(comm, num_parts, cell_types, cells):
        count = {"interval": 2, "triangle": 3, "quadrilateral": 4, "tetrahedron": 4, "hexahedron": 8}
        num_cells = len(cells[0]) // count[cell_types[0].name]
        rng = np.random.default_rng(seed + comm.rank)
        return compat.adjacencylist(rng.integers(num_parts, size=num_cells).astype(np.int32))

    return partition


def two_bodies(comm=MPI.COMM_WORLD, dim=2, cell=None, geometry_degree=1, degree=1, seed=None, **parameters):
    """Space, slave and master facets of `two_blocks`, with surfaces that are bent by a smooth map."""
    sizes = dict(lower=(1.0,) * dim, upper=(0.9,) * dim, gap=-0.01)
    cells = dict(lower_cells=(3,) * dim, upper_cells=(2,) * dim)
    options = {} if seed is None else {"partitioner": scattered(seed)}
    cell = cell or ("quadrilateral" if dim == 2 else "hexahedron")
    m = meshes.make("two_blocks", comm, cell=cell, degree=geometry_degree, **(sizes | cells | parameters), **options)
    x = m.mesh.geometry.x
    x[:, dim - 1] += 0.05 * np.sin(3 * x[:, 0] + x[:, 1] * (dim - 2)) * x[:, dim - 1]
    V = fem.functionspace(m.mesh, ("Lagrange", degree, (dim,)))
    tdim = m.mesh.topology.dim
    m.mesh.topology.create_connectivity(tdim - 1, tdim)
    m.mesh.topology.create_connectivity(tdim, tdim - 1)
    found = [m.facet_tags.find(m.tags[name]) for name in ("slave_surface", "master_surface")]
    return V, *(_cpp.surface.make_surface(V._cpp_object, facets) for facets in found)
