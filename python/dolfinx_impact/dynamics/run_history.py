# SPDX-License-Identifier: MIT
"""Energies and contact forces of an explicit run, step by step."""

from collections.abc import Mapping

import numpy as np

from .history import History

ENERGIES = ("kinetic", "internal", "contact", "friction", "impact", "damping", "viscosity", "external")


def total_energy(values: Mapping[str, float] | np.ndarray) -> float:
    """Total of the energies at one time, docs/explicit/energies.md: their sum less the work of external forces.

    Args:
        values: energies by the names of ENERGIES: a mapping, or a row of a structured array [F L].
    """
    return float(sum(values[name] for name in ENERGIES[:-1]) - values[ENERGIES[-1]])


class RunHistory:
    """Rows with time, energies and contact forces before each step, and the drift of the total energy.

    Args:
        num_contacts: contacts of the problem.
        gdim: components of a contact's force.

    Attributes:
        step_type: data type of a row as the C++ integrator writes it: the ENERGIES by name [F L], then `force`,
            (num_contacts, 3) [F].
        row_type: the same after `time` [T].
        total_start: total energy that the drift counts from; None before the first row [F L].
        largest: largest sum of absolute values of the energies so far, which the drift is relative to [F L].
    """

    def __init__(self, num_contacts: int, gdim: int) -> None:
        self._gdim = gdim
        fields = [*((name, float) for name in ENERGIES), ("force", float, (num_contacts, 3))]
        self.step_type, self.row_type = np.dtype(fields), np.dtype([("time", float), *fields])
        self._rows = History(self.row_type)
        self.total_start: float | None = None
        self.largest = 0.0

    def add(self, times: np.ndarray, steps: np.ndarray) -> np.ndarray:
        """Append rows.

        Args:
            times: time of each row, (n,) [T].
            steps: rows of `step_type`, (n,).

        Returns:
            The rows with their times, of `row_type`, (n,).
        """
        rows = np.zeros(len(steps), dtype=self.row_type)
        rows["time"] = times
        for name in self.step_type.names:
            rows[name] = steps[name]
        if len(rows):
            if self.total_start is None:
                self.total_start = total_energy(rows[0])
            sizes = sum(np.abs(rows[name]) for name in ENERGIES)
            self.largest = max(self.largest, float(sizes.max()))
            self._rows.add(rows)
        return rows

    def begin_anew(self) -> None:
        """Forget all rows; drift counts from the next one."""
        self._rows.clear()
        self.total_start, self.largest = None, 0.0

    def resume(self, total_start: float | None, largest: float) -> None:
        """Forget all rows; drift goes on from what a checkpoint tells."""
        self._rows.clear()
        self.total_start, self.largest = total_start, largest

    def drift(self, values: Mapping[str, float] | np.ndarray) -> float:
        """Change of the total energy since the start over the largest sum of absolute values of the energies [1].

        Args:
            values: energies at the present time, as for `total_energy` [F L].
        """
        total = total_energy(values)
        change = total - (total if self.total_start is None else self.total_start)
        largest = max(self.largest, float(sum(abs(values[name]) for name in ENERGIES)))
        return change / largest if largest > 0.0 else 0.0

    @property
    def last(self) -> np.ndarray | None:
        """The row that was added last, of `row_type`."""
        return self._rows.last

    @property
    def energies(self) -> np.ndarray:
        """Times [T] and energies in the order of ENERGIES [F L], (num_rows, 9)."""
        rows = self._rows.rows()
        return np.column_stack([rows["time"], *(rows[name] for name in ENERGIES)])

    @property
    def forces(self) -> list[np.ndarray]:
        """Force on the slave of each contact, (num_rows, gdim) [F]."""
        force = self._rows.rows()["force"]
        return [force[:, k, : self._gdim].copy() for k in range(force.shape[1])]

    @property
    def limit(self) -> int:
        """Largest number of rows that are kept [1]."""
        return self._rows.limit

    @limit.setter
    def limit(self, value: int) -> None:
        self._rows.limit = value
