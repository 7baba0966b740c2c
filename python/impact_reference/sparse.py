# SPDX-License-Identifier: MIT
"""A sparse matrix by rows, so that this package does not need SciPy."""

import numpy as np

from . import _reference
from .array_types import ArrayLike, FloatArray


class Csr:
    """Square sparse matrix by rows: `indptr`, `indices`, `data` and `shape`.

    Args:
        indptr: start of each row in `indices` and `data`, shape (n + 1).
        indices: columns of the entries, increasing in each row, shape (num_entries).
        data: entries, shape (num_entries) [unit of the matrix].
    """

    def __init__(self, indptr: ArrayLike, indices: ArrayLike, data: ArrayLike) -> None:
        self.indptr = np.ascontiguousarray(indptr, dtype=np.int64)
        self.indices = np.ascontiguousarray(indices, dtype=np.int64)
        self.data = np.ascontiguousarray(data, dtype=float)
        self.shape = (self.indptr.size - 1, self.indptr.size - 1)

    def toarray(self) -> FloatArray:
        """Dense copy of the matrix.

        Returns:
            Array, shape (n, n) [unit of the matrix].
        """
        dense = np.zeros(self.shape)
        rows = np.repeat(np.arange(self.shape[0]), np.diff(self.indptr))
        dense[rows, self.indices] = self.data
        return dense

    def dot(self, x: ArrayLike) -> FloatArray:
        """Product of the matrix and a vector.

        Args:
            x: vector, shape (n) or (n / gdim, gdim).

        Returns:
            Product, shape (n).
        """
        x = np.ascontiguousarray(x, dtype=float).reshape(-1)
        return _reference.csr_dot(self.indptr, self.indices, self.data, x)

    __matmul__ = dot

    def diagonal(self) -> FloatArray:
        """Entries of the diagonal, zero where the matrix stores none.

        Returns:
            Diagonal, shape (n) [unit of the matrix].
        """
        rows = np.repeat(np.arange(self.shape[0]), np.diff(self.indptr))
        result = np.zeros(self.shape[0])
        on_diagonal = rows == self.indices
        result[rows[on_diagonal]] = self.data[on_diagonal]
        return result

    def __repr__(self) -> str:
        return f"Csr(shape={self.shape}, entries={self.data.size})"
