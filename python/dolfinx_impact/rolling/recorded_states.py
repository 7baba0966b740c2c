# SPDX-License-Identifier: MIT
"""Steady states of rolling problems as their recorders see them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..assembly.history_field import HistoryField
from ..assembly.material_history import MaterialHistory
from ..common.described import Described
from ..statics.load_step_recorder import LoadStepRecorder
from ..statics.static_problem import StaticProblem


class RecordedStates(Described):
    """The steady states of a rolling problem; a recorder writes a frame for each, whatever increments or turns led to
    it.

    Args:
        equilibrium: static problem of the bodies.

    Attributes:
        recorders: recorders that write after each solve.
    """

    def __init__(self, equilibrium: StaticProblem) -> None:
        self._equilibrium = equilibrium
        self.u, self.space, self.material = equilibrium.u, equilibrium.space, equilibrium.material
        self.axisymmetric = equilibrium.axisymmetric
        self.recorders: list[LoadStepRecorder] = []

    @property
    def contact(self) -> Sequence[Any]:
        return self._equilibrium.contact

    @property
    def has_history(self) -> bool:
        return self._equilibrium.has_history

    @property
    def history(self) -> MaterialHistory:
        return self._equilibrium.history

    @property
    def stress(self) -> HistoryField:
        return self._equilibrium.stress

    @property
    def von_mises(self) -> HistoryField:
        return self._equilibrium.von_mises

    def solved(self) -> None:
        """Write a frame of every recorder. Collective."""
        for recorder in list(self.recorders):
            recorder.begin()
            recorder.after(1.0)
