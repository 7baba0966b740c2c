# SPDX-License-Identifier: MIT
"""Rows of one type in blocks: a table that grows without being copied."""

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from ..common.types import AnyArray

BLOCK = 2048  # rows, an even number: 0.2 MB with one contact


class RowBlocks:
    """Rows in blocks of equal size, of which only the last one may have free places.

    A table in one piece takes two to three times its size when it grows: the old piece, the new one with room for more,
    and the holes that old pieces leave. Here it is the rows and less than a block.

    Args:
        row_type: data type of a row, structured or of several numbers.
    """

    def __init__(self, row_type: npt.DTypeLike) -> None:
        self._type = row_type
        self.clear()

    def __len__(self) -> int:
        return self._size

    def clear(self) -> None:
        """Forget all rows."""
        self._blocks: list[AnyArray] = []
        self._size = 0

    def add(self, rows: AnyArray) -> None:
        """Append rows.

        Args:
            rows: (n) rows of the row type.
        """
        done = 0
        while done < len(rows):
            first = self._size % BLOCK
            if first == 0:
                self._blocks.append(np.zeros(BLOCK, self._type))
            count = min(BLOCK - first, len(rows) - done)
            self._blocks[-1][first : first + count] = rows[done : done + count]
            done, self._size = done + count, self._size + count

    def __iter__(self) -> Iterator[AnyArray]:
        """Views of the rows, a block at a time."""
        for k, block in enumerate(self._blocks):
            yield block[: min(BLOCK, self._size - k * BLOCK)]

    def rows(self) -> AnyArray:
        """Copy of the rows.

        Returns:
            (num_rows) rows of the row type.
        """
        return np.concatenate([np.zeros(0, self._type), *self])

    def drop_every_second(self) -> None:
        """Keep rows 0, 2, 4, ..., in place."""
        kept = 0
        for rows in self:  # rows move forward only, to places whose rows have moved already
            rows = rows[::2]
            first = kept % BLOCK
            self._blocks[kept // BLOCK][first : first + len(rows)] = rows
            kept += len(rows)
        self._size = kept
        del self._blocks[-(-kept // BLOCK) :]
