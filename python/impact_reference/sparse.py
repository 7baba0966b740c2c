# SPDX-License-Identifier: MIT
"""A sparse matrix small enough not to need SciPy."""

import numpy as np

from . import _reference


class Csr:
    """Square sparse matrix by rows: `indptr`, `indices`, `data`, `shape`, with increasing columns in each row."""

    def __init__(self, indptr, indices, data):
        self.indptr = np.ascontiguousarray(indptr, dtype=np.int64)
        self.indices = np.ascontiguousarray(indices, dtype=np.int64)
        self.data = np.ascontiguousarray(data, dtype=float)
        self.shape = (self.indptr.size - 1, self.indptr.size - 1)

    def toarray(self):
        """Dense copy, shape `shape`."""
        dense = np.zeros(self.shape)
        rows = np.repeat(np.arange(self.shape[0]), np.diff(self.indptr))
        dense[rows, self.indices] = self.data
        return dense

    def dot(self, x):
        """Matrix times a vector of shape (n,) or (n / gdim, gdim); returns shape (n,)."""
        x = np.ascontiguousarray(x, dtype=float).reshape(-1)
        return _reference.csr_dot(self.indptr, self.indices, self.data, x)

    __matmul__ = dot

    def diagonal(self):
        """The diagonal, shape (n,)."""
        rows = np.repeat(np.arange(self.shape[0]), np.diff(self.indptr))
        result = np.zeros(self.shape[0])
        on = rows == self.indices
        result[rows[on]] = self.data[on]
        return result

    def __repr__(self):
        return f"Csr(shape={self.shape}, entries={self.data.size})"
