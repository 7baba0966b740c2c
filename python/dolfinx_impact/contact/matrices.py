# SPDX-License-Identifier: MIT
"""PETSc matrices from entries, and nodal values over the ranks."""

import numpy as np
from dolfinx import la
from dolfinx.common import IndexMap
from mpi4py import MPI
from petsc4py import PETSc

from .. import _cpp
from ..common.types import FloatArray, IntArray


def rectangle(
    comm: MPI.Comm, num_rows: int, num_columns: int, rows: IntArray, cols: IntArray, values: FloatArray, block: int = 1
) -> PETSc.Mat:
    """Matrix to which any rank may contribute entries; entries of one place are added. Collective.

    Args:
        comm: communicator of the matrix.
        num_rows: number of rows of this rank.
        num_columns: number of columns of this rank.
        rows: global rows of the entries.
        cols: global columns of the entries.
        values: the entries.
        block: size of blocks.

    Returns:
        Assembled matrix.
    """
    A = PETSc.Mat().create(comm)
    A.setSizes(((num_rows, PETSc.DETERMINE), (num_columns, PETSc.DETERMINE)))
    A.setBlockSize(block)
    A.setType(PETSc.Mat.Type.AIJ)
    integers = (np.ascontiguousarray(np.ravel(a), dtype=np.int64) for a in (rows, cols))
    _cpp.linear.add_triplets(A, *integers, np.ascontiguousarray(np.ravel(values), dtype=np.float64))
    return A


def owned_rows(A: PETSc.Mat) -> tuple[IntArray, IntArray, FloatArray]:
    """This rank's rows of a matrix.

    Args:
        A: the matrix.

    Returns:
        Row pointers, global columns, values.
    """
    return A.getValuesCSR()


class NodalSum:
    """Sums and updates of nodal values over the ranks.

    Args:
        index_map: index map of the nodes.
        block: number of values per node.
    """

    def __init__(self, index_map: IndexMap, block: int) -> None:
        self.index_map, self.block = index_map, block
        self._vector = la.vector(index_map, block)

    def __call__(self, values: FloatArray) -> FloatArray:
        """Add the contributions of all ranks. Collective.

        Args:
            values: contributions at owned and ghost nodes, (num_nodes, block).

        Returns:
            Sums at owned and ghost nodes, (num_nodes, block).
        """
        self._vector.array[:] = np.ravel(values)
        self._vector.scatter_reverse(la.InsertMode.add)
        self._vector.scatter_forward()
        return self._vector.array.reshape(-1, self.block).copy()

    def forward(self, values: FloatArray) -> FloatArray:
        """Update the values at ghost nodes from their owners. Collective.

        Args:
            values: values at owned and ghost nodes, (num_nodes, block).

        Returns:
            Values at owned and ghost nodes, (num_nodes, block).
        """
        self._vector.array[:] = np.ravel(values)
        self._vector.scatter_forward()
        return self._vector.array.reshape(-1, self.block).copy()
