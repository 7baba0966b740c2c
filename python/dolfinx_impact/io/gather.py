# SPDX-License-Identifier: MIT
"""Distributed fields and meshes as plain arrays on rank 0: for pictures, tables, and the hand-written solver."""

from dataclasses import dataclass

import numpy as np


def together(comm, work):
    """Run work() on rank 0 of `comm`; return its result on all ranks, or raise its error on all ranks."""
    outcome = (None, None)
    if comm.rank == 0:
        try:
            outcome = (None, work())
        except (OSError, RuntimeError, TypeError, ValueError) as error:
            outcome = (error, None)
        except Exception as error:  # whatever it is, the other ranks must hear of it
            outcome = (RuntimeError(f"{type(error).__name__}: {error}"), None)
    error, result = comm.bcast(outcome, root=0)
    if error is not None:
        raise error
    return result


@dataclass
class Gathered:
    """A mesh or a field without partition.

    Attributes:
        points: of the nodes, shape (num_nodes, gdim) [L].
        cells: nodes of each cell in DOLFINx's order, shape (num_cells, nodes per cell).
        values: at the nodes, shape (num_nodes, components); None for a mesh.
        cell_type, degree: of the cells.
        offset: number, in `cells`, of this rank's first cell; known on every rank.
    """

    points: np.ndarray
    cells: np.ndarray
    values: np.ndarray | None
    cell_type: str
    degree: int
    offset: int

    def vtk(self):
        """(cells in VTK's node order, VTK's number of the cell type)."""
        from dolfinx.cpp.io import perm_vtk
        from dolfinx.cpp.mesh import to_type

        kinds = {"triangle": (5, 69), "quadrilateral": (9, 70), "tetrahedron": (10, 71), "hexahedron": (12, 72)}
        order = perm_vtk(to_type(self.cell_type), self.cells.shape[1])
        return self.cells[:, np.argsort(order)], kinds[self.cell_type][self.degree > 1]


def _gather(comm, dofmap, index_map, points, values):
    """Cells in global numbers, and rows of points and values in the order of these numbers, on rank 0."""
    offset = comm.exscan(len(dofmap)) or 0
    owned = index_map.size_local
    numbers = index_map.local_to_global(dofmap.ravel().astype(np.int32)).reshape(dofmap.shape)
    parts = [None if a is None else comm.gather(a, root=0) for a in (numbers, points[:owned], values)]
    if comm.rank > 0:
        return None, None, None, offset
    return *(None if part is None else np.concatenate(part) for part in parts), offset


def gather_mesh(mesh):
    """Geometry of a mesh; its arrays are None except on rank 0. Collective."""
    num_cells = mesh.topology.index_map(mesh.topology.dim).size_local
    g = mesh.geometry
    cells, points, _, offset = _gather(mesh.comm, g.dofmap[:num_cells], g.index_map(), g.x[:, : g.dim], None)
    return Gathered(points, cells, None, mesh.topology.cell_name(), g.cmap.degree, offset)


def gather_field(function):
    """A Lagrange field; its arrays are None except on rank 0. Collective.

    Node k of the result is global node k of the function's space: rows of different fields on one space correspond.
    """
    V = function.function_space
    mesh, dofmap = V.mesh, V.dofmap
    num_cells = mesh.topology.index_map(mesh.topology.dim).size_local
    owned = dofmap.index_map.size_local
    values = function.x.array[: owned * dofmap.bs].reshape(owned, dofmap.bs)
    points = V.tabulate_dof_coordinates()[:, : mesh.geometry.dim]
    cells, points, values, offset = _gather(mesh.comm, dofmap.list[:num_cells], dofmap.index_map, points, values)
    return Gathered(points, cells, values, mesh.topology.cell_name(), V.element.basix_element.degree, offset)


def gather_rows(comm, rows):
    """Rows of all ranks one after another on rank 0, None elsewhere. Collective."""
    parts = comm.gather(np.asarray(rows), root=0)
    return None if comm.rank > 0 else np.concatenate(parts)
