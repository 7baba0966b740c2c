# SPDX-License-Identifier: MIT
"""Table of one row per step in a bounded amount of memory."""

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from ..common.types import AnyArray
from .row_blocks import RowBlocks

LIMIT = 250_000  # rows: 26 MB with one contact, on every rank


class History:
    """Table that grows by rows, up to a limit.

    When the table has more than `limit` rows, every second row is dropped, and from then on only every second (fourth,
    ...) row is added. The first row always stays, and the rows stay equally spaced.

    Args:
        row_type: data type of a row, structured or of several numbers.
        limit: largest number of rows, two or more [1].

    Attributes:
        stride: one row is kept of this many [1].
        last: row that was added last, kept or not; None before the first.
    """

    def __init__(self, row_type: npt.DTypeLike, limit: int = LIMIT) -> None:
        self._rows, self._limit = RowBlocks(row_type), limit
        self.clear()

    def clear(self) -> None:
        """Forget all rows."""
        self._rows.clear()
        self._count, self.stride = 0, 1
        self.last: np.void | AnyArray | None = None

    @property
    def limit(self) -> int:
        """Largest number of rows that are kept [1]."""
        return self._limit

    @limit.setter
    def limit(self, value: int) -> None:
        """Set the largest number of rows; rows beyond it are dropped.

        Args:
            value: number of rows, two or more [1].

        Raises:
            ValueError: the value is no integer, or less than two.
        """
        if isinstance(value, bool) or int(value) != value or value < 2:
            raise ValueError(f"history_limit is {value!r}: give a number of rows, two or more")
        self._limit = int(value)
        self._thin()

    def add(self, rows: AnyArray) -> None:
        """Append rows.

        Args:
            rows: (n) rows of the row type.
        """
        if len(rows) == 0:
            return
        self.last = rows[-1].copy()
        kept = rows[-self._count % self.stride :: self.stride]
        self._count += len(rows)
        self._rows.add(kept)
        self._thin()

    def __len__(self) -> int:
        return len(self._rows)

    def __iter__(self) -> Iterator[AnyArray]:
        """Views of the rows that are kept, a block at a time."""
        return iter(self._rows)

    def rows(self) -> AnyArray:
        """Copy of the rows that are kept.

        Returns:
            (num_rows) rows of the row type.
        """
        return self._rows.rows()

    def _thin(self) -> None:
        while len(self._rows) > self._limit:
            self._rows.drop_every_second()
            self.stride *= 2
