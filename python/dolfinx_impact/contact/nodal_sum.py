# SPDX-License-Identifier: MIT
"""Nodal values over the ranks."""

from typing import Any

import numpy as np
from dolfinx import la

from ..common.types import AnyArray, FloatArray


class NodalSum:
    """Sums and updates of nodal values over the ranks.

    Args:
        index_map: of nodes (owned, then ghosts).
        block: values per node.
    """

    def __init__(self, index_map: Any, block: int) -> None:
        self.index_map, self.block = index_map, block
        self._vector = la.vector(index_map, block)

    @property
    def num_nodes(self) -> int:
        """Nodes of this rank, owned and ghosts."""
        return self.index_map.size_local + self.index_map.num_ghosts

    def __call__(self, values: AnyArray) -> FloatArray:
        """Contributions of all ranks, added; complete on ghosts as well. Collective.

        Args:
            values: (nodes, block), owned and ghosts.

        Returns:
            sums, (nodes, block).
        """
        self._vector.array[:] = np.ravel(values)
        self._vector.scatter_reverse(la.InsertMode.add)
        self._vector.scatter_forward()
        return self._vector.array.reshape(-1, self.block).copy()

    def forward(self, values: AnyArray) -> FloatArray:
        """Values at the ghosts from their owners. Collective.

        Args:
            values: (nodes, block); those of ghosts do not count.

        Returns:
            (nodes, block).
        """
        self._vector.array[:] = np.ravel(values)
        self._vector.scatter_forward()
        return self._vector.array.reshape(-1, self.block).copy()
