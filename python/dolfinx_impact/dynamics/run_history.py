# SPDX-License-Identifier: MIT
"""Energies and contact forces of an explicit run at every step."""

from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .. import _cpp
from ..common.described import Described
from ..common.types import FloatArray

# Energies by the names of ENERGIES: a mapping, or a row of a structured array.
Energies: TypeAlias = Mapping[str, float] | np.void

ENERGIES = (
    "kinetic", "internal", "contact", "friction", "impact", "damping", "viscosity", "plastic", "external",
)  # fmt: skip


def total_energy(values: Energies) -> float:
    """Total energy at one time: the sum of the energies minus the work of external forces; docs/explicit/energies.md.

    Args:
        values: energies by the names of ENERGIES [F L].

    Returns:
        Total energy [F L].
    """
    return float(sum(values[name] for name in ENERGIES[:-1]) - values[ENERGIES[-1]])


class RunHistory(Described):
    """Time, energies and contact forces before each step, and the drift of the total energy; a view of C++.

    Beyond `limit` rows every second one is dropped, and from then on only every second (fourth, ...) one is kept.

    Args:
        num_contacts: number of contacts of the problem [1].
        gdim: number of components of a contact force [1].
        history: RunHistory (C++) that is seen; None: a new one.

    Attributes:
        step_type: data type of a row as the C++ integrator writes it: the ENERGIES by name [F L], then `force`,
            (num_contacts, 3) [F].
        row_type: data type of a row of the history: `time` [T], then the fields of `step_type`.
    """

    def __init__(self, num_contacts: int, gdim: int, history: _cpp.problems.RunHistory | None = None) -> None:
        self._cpp_object = _cpp.problems.RunHistory(num_contacts) if history is None else history
        self._gdim, self._num_contacts = gdim, num_contacts
        fields: list[Any] = [*((name, float) for name in ENERGIES), ("force", float, (num_contacts, 3))]
        self.step_type: np.dtype[np.void] = np.dtype(fields)
        self.row_type: np.dtype[np.void] = np.dtype([("time", float), *fields])

    def add(self, times: FloatArray, steps: npt.NDArray[np.void]) -> npt.NDArray[np.void]:
        """Append rows.

        Args:
            times: time of each row, (n) [T].
            steps: (n) rows of `step_type`.

        Returns:
            (n) rows of `row_type`: the rows with their times.
        """
        self._cpp_object.add(np.ascontiguousarray(times, dtype=float), np.ascontiguousarray(steps).view(float).ravel())
        return self.rows(times, steps)

    def rows(self, times: FloatArray, steps: npt.NDArray[np.void]) -> npt.NDArray[np.void]:
        """Rows with their times.

        Args:
            times: time of each row, (n) [T].
            steps: (n) rows of `step_type`.

        Returns:
            (n) rows of `row_type`.
        """
        rows = np.zeros(len(steps), dtype=self.row_type)
        rows["time"] = times
        for name in steps.dtype.names or ():
            rows[name] = steps[name]
        return rows

    def begin_anew(self) -> None:
        """Forget all rows; the next row is the new reference of the drift."""
        self._cpp_object.begin_anew()

    def drift(self, values: Energies) -> float:
        """Relative change of the total energy since the start.

        Args:
            values: energies at the present time by the names of ENERGIES [F L].

        Returns:
            Change over the largest sum of absolute values of the energies [1].
        """
        return float(self._cpp_object.drift(np.array([values[name] for name in ENERGIES], dtype=float)))

    @property
    def last(self) -> np.void | None:
        """Row of `row_type` that was added last; None without rows."""
        row = self._cpp_object.last
        return row.view(self.row_type)[0] if len(row) else None

    @property
    def energies(self) -> FloatArray:
        """Times [T] and energies in the order of ENERGIES [F L], (num_rows, 10)."""
        columns: FloatArray = self._cpp_object.columns(0, 1 + len(ENERGIES))
        return columns

    @property
    def forces(self) -> list[FloatArray]:
        """Forces on the slaves, for each contact (num_rows, gdim) [F]."""
        first = 1 + len(ENERGIES)
        return [self._cpp_object.columns(first + 3 * k, self._gdim) for k in range(self._num_contacts)]

    @property
    def limit(self) -> int:
        """Largest number of rows that are kept [1]."""
        return int(self._cpp_object.limit)

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
        self._cpp_object.limit = int(value)
