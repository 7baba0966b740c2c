# SPDX-License-Identifier: MIT
"""Rows of numbers, one for each step, in a bounded amount of memory."""

import numpy as np

LIMIT = 250_000  # rows: 24 MB with one contact, on every rank


class History:
    """A table that grows by rows. When it has more than `limit` every second one is dropped, and from then on only
    every second (fourth, ...) row is taken: the first row stays, rows stay equally far apart.

    Args:
        row_type: data type of a row, structured or of several numbers.
        limit: largest number of rows, two or more.

    Attributes:
        stride: one of so many rows is kept. last: the row added last, kept or not; None at first.
    """

    def __init__(self, row_type: np.dtype, limit: int = LIMIT) -> None:
        self._type, self._limit = row_type, limit
        self.clear()

    def clear(self):
        """Forget all rows."""
        self._table, self._size = np.zeros(0, self._type), 0
        self._count, self.stride, self.last = 0, 1, None

    @property
    def limit(self):
        return self._limit

    @limit.setter
    def limit(self, value):
        if isinstance(value, bool) or int(value) != value or value < 2:
            raise ValueError(f"history_limit is {value!r}: give a number of rows, two or more")
        self._limit = int(value)
        self._thin()

    def add(self, rows):
        """Append rows, (n,) of the row type."""
        if len(rows) == 0:
            return
        self.last = rows[-1].copy()
        kept = rows[-self._count % self.stride :: self.stride]
        self._count += len(rows)
        rows, first = kept, self._size
        self._reserve(first + len(rows))
        self._table[first : first + len(rows)] = rows
        self._size = first + len(rows)
        self._thin()

    def rows(self):
        """All rows kept, (n,) of the row type; a copy."""
        return self._table[: self._size].copy()

    def _reserve(self, size):
        if size > len(self._table):
            table = np.zeros(max(size, 2 * len(self._table), 64), self._type)
            table[: self._size] = self._table[: self._size]
            self._table = table

    def _thin(self):
        while self._size > self._limit:
            kept = self._table[: self._size : 2].copy()
            self._table, self._size, self.stride = kept, len(kept), 2 * self.stride
