# SPDX-License-Identifier: MIT
"""What saving and restoring runs has in common, whatever integrates them."""

from __future__ import annotations

import abc
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np

from ..assembly.fields import is_mixed
from ..assembly.history import MaterialHistory
from ..common import arguments
from ..common.collective import agree, guard
from ..common.interrupts import Interrupts
from ..common.types import AnyArray, FilePath, FloatArray
from ..io import checkpoint
from ..io.signature import Functions, Problem, functions_of_time, supports

if TYPE_CHECKING:
    from .recorder import Recorder

SAME = 1e-12  # relative tolerance for values of functions of time: another library version may round differently


class SavedProblem(Problem, Protocol):
    """What a checkpoint holds of a problem beside its signature."""

    @property
    def has_history(self) -> bool:
        """Whether a material has internal variables."""

    @property
    def history(self) -> MaterialHistory:
        """Internal variables of the materials."""


class Checkpoints(abc.ABC):
    """Saves and restores a problem in time. A subclass writes and reads what its integrator needs.

    Args:
        problem: problem in time.
    """

    def __init__(self, problem: SavedProblem) -> None:
        self._of, self.comm = problem, problem.comm

    def save(self, path: FilePath) -> None:
        """Write a checkpoint. Collective.

        Args:
            path: file to write.

        Raises:
            KeyboardInterrupt: a rank was interrupted; the file is complete.
            RuntimeError: the file cannot be written; on all ranks.
            TypeError: `path` is no name of a file.
            ValueError: u is on a mixed space; on all ranks.
        """
        with guard(self.comm, "save", path=path):
            arguments.path("path", path)
            self._check_space("save")
        with Interrupts(self.comm) as interrupts:
            self._save(path)
            for recorder in self._recorders():
                recorder.flush()
            interrupts.check()

    def restore(self, path: FilePath) -> None:
        """Set the problem to the state of a checkpoint. Collective.

        Args:
            path: file that `save` has written.

        Raises:
            KeyboardInterrupt: a rank was interrupted; the problem is restored.
            RuntimeError: the file cannot be read, or is damaged; on all ranks.
            TypeError: `path` is no name of a file.
            ValueError: the file belongs to another problem; on all ranks.
        """
        with guard(self.comm, "restore", path=path):
            arguments.path("path", path)
            self._check_space("restore")
        with Interrupts(self.comm) as interrupts:
            self._restore(path)
            interrupts.check()

    def _check_space(self, call: str) -> None:
        """Refuse spaces whose functions are no values at nodes."""
        if is_mixed(self._of.space):
            raise ValueError(
                f"{call}: checkpoints hold values at nodes, u is on a mixed space: keep the arrays of u, velocity and "
                "acceleration with a tool of DOLFINx, and begin again with u and velocity"
            )

    @abc.abstractmethod
    def _save(self, path: FilePath) -> None:
        """Write the checkpoint; the argument has been checked. Collective."""

    @abc.abstractmethod
    def _restore(self, path: FilePath) -> None:
        """Read the checkpoint and apply it; the argument has been checked. Collective."""

    @abc.abstractmethod
    def _recorders(self) -> Sequence[Recorder]:
        """Recorders of the problem."""

    def _material_history(self) -> dict[str, FloatArray]:
        """Internal variables by name, a row of all points of a cell for each owned cell; empty without any."""
        if not self._of.has_history:
            return {}
        found = {name: field.values for name, field in self._of.history.items()}
        # A rank may own no cells: the number of columns does not follow from the values then.
        return {name: values.reshape(len(values), math.prod(values.shape[1:])) for name, values in found.items()}

    def _set_material_history(self, tables: dict[str, FloatArray]) -> None:
        """Set the internal variables to tables as those of `_material_history`."""
        for name, table in tables.items():
            field = self._of.history[name]
            field.values = table.reshape(field.values.shape)

    def _check_supports(self, path: FilePath, file: checkpoint.Reader) -> None:
        """Raise ValueError on all ranks unless the supports are those of the checkpoint. Collective."""
        nodes, wanted = supports(self._of)
        found = file.all_at("supports", nodes)
        other = np.flatnonzero(np.any(found != wanted, axis=1))
        error = None
        if len(other):
            place = checkpoint.places(self._of.space)[nodes[other[0]]].tolist()
            error = ValueError(f"{path} is of another problem: supports differ, the first at {place}")
        agree(self.comm, error, "restore")

    @staticmethod
    def _check_functions(path: FilePath, saved: AnyArray, functions: Functions, time: float, end: float) -> None:
        """Raise ValueError unless the functions of time have the values that were saved.

        Args:
            path: file, for the text.
            saved: values in the checkpoint.
            functions: functions of time of the problem.
            time: time of the checkpoint [T].
            end: time up to which the integrator has used them [T].
        """
        here, there = functions_of_time(functions, time, end), np.asarray(saved)
        scale = np.abs(here).max(initial=0.0)
        if there.shape != here.shape or not np.all(np.abs(here - there) <= SAME * scale):
            raise ValueError(
                f"{path} is of another problem: functions of time (of loads, supports, obstacles) have other values up "
                f"to the time {time:g}"
            )
