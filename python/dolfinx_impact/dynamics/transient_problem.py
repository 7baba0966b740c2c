# SPDX-License-Identifier: MIT
"""What problems in time have in common."""

from __future__ import annotations

from .. import _cpp
from ..assembly.body_results import BodyResults
from ..common.types import FloatArray
from .run_history import RunHistory


class TransientProblem(BodyResults):
    """Base of problems in time; a derived class sets `_cpp_object` and `_history`."""

    _cpp_object: _cpp.problems.ExplicitProblem | _cpp.problems.NewmarkProblem
    _history: RunHistory

    @property
    def time(self) -> float:
        """Present time [T]."""
        return float(self._cpp_object.time)

    @property
    def step(self) -> int:
        """Number of the present step [1]."""
        return int(self._cpp_object.step)

    @property
    def energy_history(self) -> FloatArray:
        """Time and energies, (num_rows, 10): time [T], then the energies of `energy` in its order, up to external
        [F L]. The first row is the start of the run. Explicit runs have a row before every step, those of more than
        `history_limit` steps of every second, fourth, ... step; implicit ones have a row after every step."""
        return self._history.energies

    @property
    def force_history(self) -> list[FloatArray]:
        """Forces on the slaves at the times of `energy_history`, for each contact (num_rows, gdim) [F]."""
        return self._history.forces
