# SPDX-License-Identifier: MIT
"""Distributed fields and meshes as plain arrays on rank 0: for figures, tables and the hand-written solver."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from dolfinx import fem
from dolfinx.common import IndexMap
from dolfinx.mesh import Mesh
from mpi4py import MPI

from .. import compat
from ..common.collective import common
from ..common.types import AnyArray, FloatArray, IntArray

T = TypeVar("T")


def together(comm: MPI.Intracomm, work: Callable[[], T]) -> T:
    """Run a function on rank 0. Collective.

    Args:
        comm: communicator.
        work: function without arguments; it must not communicate.

    Returns:
        What the function returned, on all ranks.

    Raises:
        Exception: what the function raised, on all ranks. Types other than OSError, RuntimeError, TypeError and
            ValueError become RuntimeError.
    """
    outcome: tuple[Exception | None, T | None] = (None, None)
    if comm.rank == 0:
        try:
            outcome = (None, work())
        except (OSError, RuntimeError, TypeError, ValueError) as e:
            outcome = (e, None)
        except Exception as e:  # whatever it is, the other ranks must get it
            outcome = (RuntimeError(f"{type(e).__name__}: {e}"), None)
    error, result = comm.bcast(outcome, root=0)
    if error is not None:
        raise common(error)
    return result


@dataclass
class Gathered:
    """A mesh or a field without partition.

    Attributes:
        points: coordinates of the nodes, (num_nodes, gdim); None except on rank 0 [L].
        cells: nodes of each cell in DOLFINx's order, (num_cells, nodes per cell); None except on rank 0.
        values: values at the nodes, (num_nodes, components); None for a mesh and except on rank 0.
        cell_type: name of the cells' type.
        degree: degree of the cells [1].
        offset: number, in `cells`, of this rank's first cell; known on every rank [1].
    """

    points: FloatArray | None
    cells: IntArray | None
    values: FloatArray | None
    cell_type: str
    degree: int
    offset: int

    def vtk(self) -> tuple[IntArray, int]:
        """Cells for VTK; on rank 0 only.

        Returns:
            Cells in VTK's order of nodes, (num_cells, nodes per cell), and VTK's number of the cell type.
        """
        from dolfinx.cpp.io import perm_vtk
        from dolfinx.cpp.mesh import to_type

        assert self.cells is not None
        kinds = {"triangle": (5, 69), "quadrilateral": (9, 70), "tetrahedron": (10, 71), "hexahedron": (12, 72)}
        order = perm_vtk(to_type(self.cell_type), self.cells.shape[1])
        return self.cells[:, np.argsort(order)], kinds[self.cell_type][self.degree > 1]


def _gather(
    comm: MPI.Intracomm, dofmap: IntArray, index_map: IndexMap, points: FloatArray, values: FloatArray | None
) -> tuple[IntArray | None, FloatArray | None, FloatArray | None, int]:
    """Gather cells in global numbers, and rows of points and values in the order of these numbers. Collective.

    Returns:
        Cells, points and values, None except on rank 0, and the number of this rank's first cell.
    """
    offset = comm.exscan(len(dofmap)) or 0
    owned = index_map.size_local
    numbers = index_map.local_to_global(dofmap.ravel().astype(np.int32)).reshape(dofmap.shape)
    parts = [None if a is None else comm.gather(a, root=0) for a in (numbers, points[:owned], values)]
    if comm.rank > 0:
        return None, None, None, offset
    cells, x, rows = (None if part is None else np.concatenate(part) for part in parts)
    return cells, x, rows, offset


def gather_mesh(mesh: Mesh) -> Gathered:
    """Gather the geometry of a mesh. Collective.

    Args:
        mesh: mesh.

    Returns:
        Geometry without values; its arrays are None except on rank 0.
    """
    num_cells = mesh.topology.index_map(mesh.topology.dim).size_local
    g, dofmap = mesh.geometry, compat.geometry_dofmap(mesh)
    cells, points, _, offset = _gather(mesh.comm, dofmap[:num_cells], g.index_map(), g.x[:, : g.dim], None)
    return Gathered(points, cells, None, mesh.topology.cell_name(), compat.coordinate_element(mesh).degree, offset)


def gather_field(function: fem.Function) -> Gathered:
    """Gather a Lagrange field. Collective.

    Node k of the result is global node k of the function's space: rows of different fields on one space correspond.

    Args:
        function: Lagrange function.

    Returns:
        Nodes, cells and values; its arrays are None except on rank 0.
    """
    V = function.function_space
    mesh, dofmap = V.mesh, V.dofmap
    num_cells = mesh.topology.index_map(mesh.topology.dim).size_local
    owned = dofmap.index_map.size_local
    here = function.x.array[: owned * dofmap.bs].reshape(owned, dofmap.bs)
    x = V.tabulate_dof_coordinates()[:, : mesh.geometry.dim]
    cells, points, values, offset = _gather(mesh.comm, dofmap.list[:num_cells], dofmap.index_map, x, here)
    return Gathered(points, cells, values, mesh.topology.cell_name(), V.element.basix_element.degree, offset)


def gather_rows(comm: MPI.Intracomm, rows: AnyArray) -> AnyArray | None:
    """Gather the rows of all ranks, in the order of the ranks. Collective.

    Args:
        comm: communicator.
        rows: this rank's rows, (n, ...).

    Returns:
        Rows of all ranks on rank 0, None elsewhere.
    """
    parts = comm.gather(np.asarray(rows), root=0)
    return None if parts is None else np.concatenate(parts)
