# SPDX-License-Identifier: MIT
"""Saving and restoring problems: what a problem has to describe, and what is done with it."""

from __future__ import annotations

import abc
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Protocol

import numpy as np

from .. import _cpp
from ..common import arguments
from ..common.collective import agree, attempt, guard
from ..common.interrupts import Interrupts
from ..common.types import AnyArray, FilePath
from . import checkpoint
from .checkpoint import Attribute, Place, State, Subject
from .signature import Functions, functions_of_time

SAME = 1e-12  # relative tolerance for values of functions of time: another library version may round differently


class Flushes(Protocol):
    """A recorder that keeps what it will write later."""

    def flush(self) -> None:
        """Write it. Collective."""


class Checkpoints(abc.ABC):
    """Saves and restores a problem. A subclass says what the state is and how the problem goes on from one.

    Args:
        subject: the problem as a checkpoint sees it.

    Attributes:
        more: names of the attributes beside the state.
        equal: names of the state's vectors of ranks that are equal on all ranks.
        infinite: names, up to digits at their ends, of parts and fields that may have infinite values.
    """

    more: ClassVar[Sequence[str]] = ()
    equal: ClassVar[Sequence[str]] = ()
    infinite: ClassVar[Sequence[str]] = ()

    def __init__(self, subject: Subject) -> None:
        self.subject, self.comm = subject, subject.space.mesh.comm

    def save(self, path: FilePath) -> None:
        """Write a checkpoint. Collective.

        Args:
            path: file to write.

        Raises:
            KeyboardInterrupt: a rank was interrupted; the file is complete.
            RuntimeError: the file cannot be written; on all ranks.
            TypeError: `path` is no name of a file.
            ValueError: a checkpoint cannot hold the state; on all ranks.
        """
        with guard(self.comm, "save", path=path):
            arguments.path("path", path)
            self._check_kind("save")
        with Interrupts(self.comm) as interrupts:
            checkpoint.write(path, self.subject, self._state(), self._attributes())
            self._forget()
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
            self._check_kind("restore")
        with Interrupts(self.comm) as interrupts:
            saved, attributes = checkpoint.read(path, self.subject, self._like(), self.more, self.equal, self.infinite)
            checked, error = attempt(self._check, path, saved, attributes)
            agree(self.comm, error, "restore")
            self._apply(saved, attributes, checked)
            self._forget()
            interrupts.check()

    def _check_kind(self, call: str) -> None:
        """Raise ValueError for problems whose state a checkpoint cannot hold. Not collective."""

    @abc.abstractmethod
    def _state(self) -> _cpp.state.State:
        """What a checkpoint holds. Collective."""

    def _like(self) -> _cpp.state.State:
        """A state with the structure of `_state`, whose values do not matter. Collective."""
        return self._state()

    def _attributes(self) -> dict[str, Attribute]:
        """What a checkpoint holds beside the state: texts and vectors of any length, by the names in `more`.
        Collective."""
        return {}

    def _check(self, path: FilePath, saved: _cpp.state.State, attributes: Mapping[str, Any]) -> Any:
        """Raise ValueError unless values are those of a run of this problem. Not collective.

        Returns:
            What `_apply` is given.
        """

    @abc.abstractmethod
    def _apply(self, saved: _cpp.state.State, attributes: Mapping[str, Any], checked: Any) -> None:
        """Set the problem to a state that was read and checked. Collective."""

    def _forget(self) -> None:
        """Forget what a checkpoint does not have, so that a problem that was saved and one that was restored go on
        alike, to the last digit. Collective."""

    @abc.abstractmethod
    def _recorders(self) -> Sequence[Flushes]:
        """Recorders that keep what they will write later."""


def refuse(path: FilePath, what: str) -> ValueError:
    """The error of a file with values that no run has.

    Args:
        path: the file.
        what: what is wrong.
    """
    return ValueError(f"{path} is of no run: {what}")


def add_numbers(state: _cpp.state.State, **numbers: float) -> None:
    """Add numbers that are the same on all ranks.

    Args:
        state: state that gets them.
        numbers: whole or real numbers by name.
    """
    for name, value in numbers.items():
        state.add(name, Place.all, np.array([value], dtype=np.int64 if isinstance(value, int) else float))


def number(state: _cpp.state.State, name: str) -> float:
    """A number of a state.

    Args:
        state: state.
        name: name of the field.
    """
    value: float = state.array(name)[0].item()
    return value


def check_functions(path: FilePath, saved: AnyArray, functions: Functions, time: float, end: float) -> None:
    """Raise ValueError unless functions of time have the values that were saved.

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


__all__ = ["Checkpoints", "Place", "SAME", "State", "add_numbers", "check_functions", "number", "refuse"]
