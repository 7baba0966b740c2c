# SPDX-License-Identifier: MIT
"""A small mesh of distorted cells on one rank, which forms are tried on."""

import basix.ufl
import numpy as np
import ufl
from dolfinx import fem, mesh
from dolfinx.mesh import Mesh
from mpi4py import MPI


def block(cell: str, n: int, geometry_degree: int = 1, distortion: float = 0.08, gdim: int | None = None) -> Mesh:
    """Unit square or cube on this rank alone, distorted inside; geometry of degree 2 is curved.

    Args:
        cell: cell of the mesh.
        n: cells per side.
        geometry_degree: degree of the geometry, 1 or 2.
        distortion: amplitude of the map that moves the inner nodes [L].
        gdim: dimension; None takes that of the cell.

    Returns:
        Mesh with sides of length 1 [L].
    """
    kind = getattr(mesh.CellType, cell)
    dim = gdim or (2 if cell in ("triangle", "quadrilateral") else 3)
    if dim == 2:
        domain = mesh.create_unit_square(MPI.COMM_SELF, n, n, kind)
    else:
        domain = mesh.create_unit_cube(MPI.COMM_SELF, n, n, n, kind)
    if geometry_degree == 2:
        domain = with_quadratic_geometry(domain)
    distort(domain, distortion)
    return domain


def distort(domain: Mesh, amount: float) -> None:
    """Move the inner nodes by a smooth map that keeps the faces of the unit block plane.

    Args:
        domain: mesh of the unit square or cube, which is changed.
        amount: amplitude of the map [L].
    """
    x = domain.geometry.x
    dim = domain.geometry.dim
    bubble = np.prod(np.sin(np.pi * x[:, :dim]), axis=1)
    for i in range(dim):
        x[:, i] += amount * bubble * np.cos(2.0 * x[:, (i + 1) % dim] + i)


def with_quadratic_geometry(domain: Mesh) -> Mesh:
    """Copy of a mesh with geometry of degree 2: edge nodes in the middle of the straight edges.

    Args:
        domain: mesh with geometry of degree 1, on one rank.

    Returns:
        Mesh with geometry of degree 2.
    """
    cell, dim = domain.topology.cell_name(), domain.geometry.dim
    V = fem.functionspace(domain, ("Lagrange", 2))
    x = V.tabulate_dof_coordinates()[:, :dim]
    element = basix.ufl.element("Lagrange", cell, 2, shape=(dim,))
    return mesh.create_mesh(MPI.COMM_SELF, V.dofmap.list.astype(np.int64), x=x, e=ufl.Mesh(element))
