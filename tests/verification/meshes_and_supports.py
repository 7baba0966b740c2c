# SPDX-License-Identifier: MIT
"""Meshes, tags and supports that the closed-form checks share."""

import numpy as np
from dolfinx import fem, mesh
from mpi4py import MPI

from dolfinx_impact.own_forms.distorted_block import block, distort, with_quadratic_geometry

__all__ = [
    "block",
    "clamp",
    "distort",
    "every_boundary_dof",
    "rectangle",
    "tagged",
    "value_at",
    "with_quadratic_geometry",
]


def rectangle(cell, low, high, shape):
    return mesh.create_rectangle(MPI.COMM_SELF, [low, high], shape, getattr(mesh.CellType, cell))


def tagged(domain, **places):
    """MeshTags of boundary facets, numbered 1, 2, ... in the order given; each place is a condition on coordinates."""
    dim = domain.topology.dim - 1
    found = [mesh.locate_entities_boundary(domain, dim, condition) for condition in places.values()]
    facets = np.concatenate(found)
    values = np.repeat(np.arange(1, len(found) + 1), [len(f) for f in found]).astype(np.int32)
    order = np.argsort(facets)
    return mesh.meshtags(domain, dim, facets[order], values[order])


def clamp(V, tags, tag, component=None, value=0.0):
    """Dirichlet condition on tagged facets, for one component or (None) all of them."""
    dim = V.mesh.topology.dim - 1
    if component is None:
        dofs = fem.locate_dofs_topological(V, dim, tags.find(tag))
        return fem.dirichletbc(np.broadcast_to(value, V.mesh.geometry.dim).astype(float), dofs, V)
    dofs = fem.locate_dofs_topological(V.sub(component), dim, tags.find(tag))
    return fem.dirichletbc(float(value), dofs, V.sub(component))


def every_boundary_dof(V):
    dim = V.mesh.topology.dim
    V.mesh.topology.create_connectivity(dim - 1, dim)
    return fem.locate_dofs_topological(V, dim - 1, mesh.exterior_facet_indices(V.mesh.topology))


def value_at(u, point):
    """Nodal value of u at the node nearest to a point, which must be there."""
    V = u.function_space
    x = V.tabulate_dof_coordinates()[:, : V.mesh.geometry.dim]
    distance = np.linalg.norm(x - np.asarray(point), axis=1)
    assert distance.min() < 1e-12
    return u.x.array.reshape(-1, V.dofmap.bs)[np.argmin(distance)]
