# SPDX-License-Identifier: MIT
"""Internal variables of operators at their quadrature points, in the order of the mesh's cells."""

from collections.abc import Sequence

import numpy as np

from .. import _cpp
from ..common.types import ArrayLike, FloatArray


class PointHistory:
    """Internal variables of a form's cells, by name.

    Args:
        num_cells: number of owned cells on this rank.
        tagged: internal variables of each integral on the C++ side, with the tag of its cells; -1: of all.
    """

    def __init__(self, num_cells: int, tagged: Sequence[tuple[int, _cpp.operators.PointHistory]]) -> None:
        self.num_cells, self._tagged = num_cells, list(tagged)

    def __repr__(self) -> str:
        return f"PointHistory({', '.join(self.names)}; {self.num_points} points in each of {self.num_cells} cells)"

    def __add__(self, other: "PointHistory") -> "PointHistory":
        return PointHistory(self.num_cells, [*self._tagged, *other._tagged])

    @property
    def parts(self) -> list[_cpp.operators.PointHistory]:
        """Internal variables of each integral, on the C++ side."""
        return [part for _, part in self._tagged]

    def of_tag(self, tag: int) -> "PointHistory":
        """Internal variables of the cells of one tag.

        Args:
            tag: cell tag of a law, -1: the law of all cells.

        Returns:
            The part of them; its arrays have all cells of this rank, with zeros elsewhere.
        """
        return PointHistory(self.num_cells, [(t, part) for t, part in self._tagged if t == tag])

    @property
    def names(self) -> list[str]:
        """Names of all values at the points, history and others."""
        return list(dict.fromkeys(name for part in self.parts for name in part.names))

    @property
    def state_names(self) -> list[str]:
        """Names of the values that an evaluation starts from: what a checkpoint holds."""
        return [n for n in self.names if any(n in p.names and p.is_history(n) for p in self.parts)]

    @property
    def num_points(self) -> int:
        """Number of quadrature points of a cell; of several laws the largest."""
        return max((part.num_points for part in self.parts), default=0)

    @property
    def memory(self) -> int:
        """Memory of all values on this rank [bytes]."""
        return sum(part.memory for part in self.parts)

    def _parts_of(self, name: str) -> list[_cpp.operators.PointHistory]:
        found = [part for part in self.parts if name in part.names]
        if not found:
            raise ValueError(f"no values at the points are called {name!r}; there are: {', '.join(self.names)}")
        return found

    def values(self, name: str, trial: bool = False) -> FloatArray:
        """Values of this rank's cells, copied.

        Args:
            name: name of an output of the law.
            trial: of the last evaluation instead of the last commit. Outputs that are no history always are.

        Returns:
            (num_owned_cells, num_points, num_components); cells whose law has no such output have zeros.

        Raises:
            ValueError: the name is unknown.
        """
        found = self._parts_of(name)
        num_components = max(part.num_components(name) for part in found)
        values = np.zeros((self.num_cells, self.num_points, num_components))
        for part in found:
            own = part.values(name, trial).reshape(len(part.cells), part.num_points, part.num_components(name))
            values[part.cells, : part.num_points, : own.shape[2]] = own
        return values

    def set_values(self, name: str, values: ArrayLike) -> None:
        """Replace committed values of this rank's cells; trial values are forgotten.

        Args:
            name: name of the history.
            values: (num_owned_cells, num_points, num_components), as `values` returns them.

        Raises:
            ValueError: the name is unknown, the shape differs, or values are not finite.
        """
        found = self._parts_of(name)
        given = np.asarray(values, dtype=np.float64)
        shape = (self.num_cells, self.num_points, max(part.num_components(name) for part in found))
        if given.shape != shape:
            raise ValueError(f"values of {name!r} must have shape {shape}, found {given.shape}")
        for part in found:
            own = given[part.cells, : part.num_points, : part.num_components(name)]
            part.set_values(name, np.ascontiguousarray(own).reshape(-1))

    def store_snapshot(self) -> None:
        """Keep a copy of the present values; only of operators that overwrite them in place (SplitForce)."""
        for part in self.parts:
            part.store_snapshot()

    def restore_snapshot(self) -> None:
        """Go back to the values of the last snapshot."""
        for part in self.parts:
            part.restore_snapshot()

    def commit(self) -> None:
        """End of a step: the values of the last evaluation become the committed ones."""
        for part in self.parts:
            part.commit()

    def revert(self) -> None:
        """Forget the values of the last evaluation."""
        for part in self.parts:
            part.revert()
