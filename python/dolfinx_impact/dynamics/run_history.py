# SPDX-License-Identifier: MIT
"""Energies and contact forces of an explicit run at every step."""

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias, cast

import numpy as np
import numpy.typing as npt

from ..common.described import Described
from ..common.types import FloatArray
from .history import History

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
    """Time, energies and contact forces before each step, and the drift of the total energy.

    Args:
        num_contacts: number of contacts of the problem [1].
        gdim: number of components of a contact force [1].

    Attributes:
        step_type: data type of a row as the C++ integrator writes it: the ENERGIES by name [F L], then `force`,
            (num_contacts, 3) [F].
        row_type: data type of a row of the history: `time` [T], then the fields of `step_type`.
        total_start: total energy at the start, the reference of the drift; None before the first row [F L].
        largest: largest sum of absolute values of the energies so far, the scale of the drift [F L].
    """

    def __init__(self, num_contacts: int, gdim: int) -> None:
        self._gdim = gdim
        fields: list[Any] = [*((name, float) for name in ENERGIES), ("force", float, (num_contacts, 3))]
        self.step_type: np.dtype[np.void] = np.dtype(fields)
        self.row_type: np.dtype[np.void] = np.dtype([("time", float), *fields])
        self._rows = History(self.row_type)
        self.total_start: float | None = None
        self.largest = 0.0

    def add(self, times: FloatArray, steps: npt.NDArray[np.void]) -> npt.NDArray[np.void]:
        """Append rows.

        Args:
            times: time of each row, (n) [T].
            steps: (n) rows of `step_type`.

        Returns:
            (n) rows of `row_type`: the rows with their times.
        """
        rows = np.zeros(len(steps), dtype=self.row_type)
        rows["time"] = times
        for name in steps.dtype.names or ():
            rows[name] = steps[name]
        if len(rows):
            if self.total_start is None:
                self.total_start = total_energy(rows[0])
            sizes = sum(np.abs(rows[name]) for name in ENERGIES)
            self.largest = max(self.largest, float(sizes.max()))
            self._rows.add(rows)
        return rows

    def begin_anew(self) -> None:
        """Forget all rows; the next row is the new reference of the drift."""
        self._rows.clear()
        self.total_start, self.largest = None, 0.0

    def resume(self, total_start: float | None, largest: float) -> None:
        """Forget all rows and set the reference of the drift to that of a checkpoint.

        Args:
            total_start: total energy at the start of the run; None if there is none [F L].
            largest: largest sum of absolute values of the energies so far [F L].
        """
        self._rows.clear()
        self.total_start, self.largest = total_start, largest

    def drift(self, values: Energies) -> float:
        """Relative change of the total energy since the start.

        Args:
            values: energies at the present time by the names of ENERGIES [F L].

        Returns:
            Change over the largest sum of absolute values of the energies [1].
        """
        total = total_energy(values)
        change = total - (total if self.total_start is None else self.total_start)
        largest = max(self.largest, float(sum(abs(values[name]) for name in ENERGIES)))
        return change / largest if largest > 0.0 else 0.0

    @property
    def last(self) -> np.void | None:
        """Row of `row_type` that was added last; None without rows."""
        return cast(np.void | None, self._rows.last)  # rows of `row_type` are structured

    @property
    def energies(self) -> FloatArray:
        """Times [T] and energies in the order of ENERGIES [F L], (num_rows, 10)."""
        names = ("time", *ENERGIES)
        return self._columns(lambda rows: np.column_stack([rows[name] for name in names]), len(names))

    @property
    def forces(self) -> list[FloatArray]:
        """Forces on the slaves, for each contact (num_rows, gdim) [F]."""
        num_contacts = self.row_type["force"].shape[0]
        return [self._columns(lambda rows: rows["force"][:, k, : self._gdim], self._gdim) for k in range(num_contacts)]

    def _columns(self, of: Callable[[npt.NDArray[np.void]], FloatArray], num_columns: int) -> FloatArray:
        """Numbers of all rows, (num_rows, num_columns), found block by block: no rows are copied."""
        out, first = np.empty((len(self._rows), num_columns)), 0
        for rows in self._rows:
            out[first : first + len(rows)] = of(rows)
            first += len(rows)
        return out

    @property
    def limit(self) -> int:
        """Largest number of rows that are kept [1]."""
        return self._rows.limit

    @limit.setter
    def limit(self, value: int) -> None:
        """Set the largest number of rows; see History.limit.

        Args:
            value: number of rows, two or more [1].
        """
        self._rows.limit = value
