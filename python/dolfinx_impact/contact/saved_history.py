# SPDX-License-Identifier: MIT
"""What a static contact remembers from one step to the next, as a table for checkpoints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..common.types import FloatArray, IntArray


@dataclass
class SavedHistory:
    """History of a contact.

    Attributes:
        on_facets: whether rows belong to slave facets, and not to owned slave nodes.
        keys: nodes, or numbers of facets that do not depend on the ranks, (n).
        columns: values by name, each (n, number of components).
        totals: vectors that are the same on all ranks, by name.
        corners: values at all owned nodes, (num_nodes, 1), of contacts with augmented multipliers; else None.
    """

    on_facets: bool
    keys: IntArray
    columns: dict[str, FloatArray]
    totals: dict[str, FloatArray]
    corners: FloatArray | None = None

    def table(self) -> FloatArray:
        """All columns side by side, (n, number of columns)."""
        return np.hstack([np.asarray(values, dtype=float) for values in self.columns.values()])

    def width(self) -> int:
        """Number of columns of `table`."""
        return sum(values.shape[1] for values in self.columns.values())

    def split(self, table: FloatArray) -> dict[str, FloatArray]:
        """Columns of a table by name.

        Args:
            table: table as `table` returns it.

        Returns:
            Values, each (n, number of components).
        """
        ends = np.cumsum([values.shape[1] for values in self.columns.values()])[:-1]
        return dict(zip(self.columns, (np.ascontiguousarray(part) for part in np.split(table, ends, axis=1))))

    def flat_totals(self) -> FloatArray:
        """All totals one after the other."""
        return np.concatenate([np.ravel(values) for values in self.totals.values()])

    def split_totals(self, flat: FloatArray) -> dict[str, FloatArray]:
        """Totals by name.

        Args:
            flat: vector as `flat_totals` returns it.

        Returns:
            Vectors.
        """
        ends = np.cumsum([np.size(values) for values in self.totals.values()])[:-1]
        return dict(zip(self.totals, np.split(flat, ends)))
