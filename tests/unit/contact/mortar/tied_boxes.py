# SPDX-License-Identifier: MIT
"""Two boxes that are tied to each other, in meshes that do not match."""

import numpy as np
from box_bodies import CELLS, Boxes
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di

SLAVE, MASTER, TOP, BOTTOM = 3, 4, 5, 6


def dimension(cell):
    return 2 if cell in CELLS[2] else 3


def boxes(cell, slave=3, master=2, degree=1, turn=0.0, comm=MPI.COMM_WORLD, poisson=0.3, layers=2):
    """A box on a box along the last axis, with so many cells along the joint; the upper one is the slave."""
    dim = dimension(cell)
    low, high = np.zeros(dim), np.ones(dim)
    up = np.eye(dim)[-1]
    parts = [
        (low, high, [master] * (dim - 1) + [layers]),
        (low + up, high + up, [slave] * (dim - 1) + [layers]),
    ]
    m = Boxes(parts, cell, degree, turn, poisson, comm)
    m.tag = m.tags(
        {SLAVE: (1, dim - 1, 1.0), MASTER: (0, dim - 1, 1.0), TOP: (1, dim - 1, 2.0), BOTTOM: (0, dim - 1, 0.0)}
    )
    return m


def pair(m, **options):
    return di.ContactPair(m.tag, slave=SLAVE, master=MASTER, **options)


def tie(m, **options):
    return di.Tie(pair(m), **options)


def curve(m, amount=0.2):
    """Bend the mesh of boxes, their joint with it."""
    x = m.mesh.geometry.x
    bent = x.copy()
    bent[:, m.dim - 1] += amount * np.sin(2.0 * x[:, 0]) * (1.0 if m.dim == 2 else np.cos(x[:, 1]))
    x[:] = bent


def outside(m, holes=(SLAVE, MASTER)):
    """Facets of the boundary without those of some tags."""
    every = mesh.exterior_facet_indices(m.mesh.topology)
    return np.setdiff1d(every, np.concatenate([m.tag.find(t) for t in holes]))


def prescribe(m, field):
    """Supports that move the outer boundary as a function of positions does, (gdim, n)."""
    moved = fem.Function(m.V)
    moved.interpolate(field)
    dofs = fem.locate_dofs_topological(m.V, m.dim - 1, outside(m))
    return [fem.dirichletbc(moved, dofs)]


def largest_error(m, field):
    """Largest difference of the displacement from a function of positions, relative to the function, of all ranks."""
    exact = fem.Function(m.V)
    exact.interpolate(field)
    owned = m.V.dofmap.index_map.size_local * m.dim

    def most(v):
        return m.mesh.comm.allreduce(float(np.abs(v[:owned]).max(initial=0.0)), MPI.MAX)

    return most(m.u.x.array - exact.x.array) / most(exact.x.array)


def linear(dim):
    """A displacement field with all components of strain and rotation."""
    A = 1e-3 * np.array([[1.0, 0.4, -0.3], [-0.7, 0.6, 0.2], [0.5, -0.1, -0.8]])[:dim, :dim]
    return lambda x: A @ x[:dim]
