# SPDX-License-Identifier: MIT
"""PETSc matrices from entries, and nodal values over the ranks."""

import numpy as np
from dolfinx import la
from petsc4py import PETSc

from .. import _cpp


def rectangle(comm, num_rows, num_columns, rows, cols, values, block=1):
    """Matrix whose entries any rank may give; equal places add up. Collective.

    Args:
        num_rows, num_columns: of this rank.
        rows, cols: global numbers.
        values: entries.
        block: size of blocks.
    """
    A = PETSc.Mat().create(comm)
    A.setSizes(((num_rows, PETSc.DETERMINE), (num_columns, PETSc.DETERMINE)))
    A.setBlockSize(block)
    A.setType(PETSc.Mat.Type.AIJ)
    integers = (np.ascontiguousarray(np.ravel(a), dtype=np.int64) for a in (rows, cols))
    _cpp.linear.add_triplets(A, *integers, np.ascontiguousarray(np.ravel(values), dtype=np.float64))
    return A


def owned_rows(A):
    """This rank's rows as (row pointers, global columns, values)."""
    return A.getValuesCSR()


class NodalSum:
    """Sums and updates of nodal values over the ranks.

    Args:
        index_map: of nodes (owned, then ghosts).
        block: values per node.
    """

    def __init__(self, index_map, block):
        self.index_map, self.block = index_map, block
        self._vector = la.vector(index_map, block)

    def __call__(self, values):
        """Contributions of all ranks, added; complete on ghosts as well. Collective."""
        self._vector.array[:] = np.ravel(values)
        self._vector.scatter_reverse(la.InsertMode.add)
        self._vector.scatter_forward()
        return self._vector.array.reshape(-1, self.block).copy()

    def forward(self, values):
        """Values at the ghosts from their owners. Collective."""
        self._vector.array[:] = np.ravel(values)
        self._vector.scatter_forward()
        return self._vector.array.reshape(-1, self.block).copy()
