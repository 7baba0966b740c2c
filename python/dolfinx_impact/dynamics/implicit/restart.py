# SPDX-License-Identifier: MIT
"""Saving and restoring implicit runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from dolfinx.fem import FunctionSpace

from ... import _cpp
from ...common.collective import agree, attempt
from ...common.types import FilePath, FloatArray
from ...io import checkpoints
from ...io.checkpoint import Attribute, Subject
from ...io.checkpoints import Checkpoints, number, refuse
from ...io.signature import functions_of_time
from ..functions_of_time import FunctionsOfTime
from ..subject import check_nodal
from .stepper import ImplicitStepper

if TYPE_CHECKING:
    from ..recorder import Recorder

WORKS = ("work internal", "work external", "work damping")
NUMBERS = ("time", "step", "largest", "total_start", "largest_displacement", *WORKS)


class SavedImplicit(Protocol):
    """An implicit problem as its checkpoints see it.

    Attributes:
        space: displacement space.
        functions: functions of time.
        stepper: time stepping.
    """

    space: FunctionSpace
    functions: FunctionsOfTime
    stepper: ImplicitStepper

    @property
    def time(self) -> float: ...

    @property
    def _cpp_object(self) -> _cpp.problems.NewmarkProblem:
        """The problem in C++."""

    def sample(self, times: FloatArray) -> FloatArray: ...


class ImplicitRestart(Checkpoints):
    """Saves and restores an implicit problem; see NewmarkProblem.save and restore.

    Args:
        subject: the problem as checkpoints of all problems see it.
        problem: the problem.
        resumed: function that computes what follows from a restored state.
    """

    more = ("functions of time",)

    def __init__(self, subject: Subject, problem: SavedImplicit, resumed: Callable[[], None]) -> None:
        super().__init__(subject)
        self.problem, self._resumed = problem, resumed

    def _recorders(self) -> Sequence[Recorder]:
        return self.problem.stepper.recorders

    def _check_kind(self, call: str) -> None:
        check_nodal(self.problem.space, call)

    def _state(self) -> _cpp.state.State:
        return self.problem._cpp_object.saved_state()

    def _attributes(self) -> dict[str, Attribute]:
        time = self.problem.time
        table, error = attempt(functions_of_time, self.problem.functions, time, time)
        agree(self.comm, error, "functions of time")
        return {"functions of time": table}

    def _check(self, path: FilePath, saved: _cpp.state.State, attributes: Mapping[str, Any]) -> None:
        for name in NUMBERS:
            if not math.isfinite(number(saved, name)):
                raise refuse(path, f"{name} is {number(saved, name)!r}")
        time, step = number(saved, "time"), number(saved, "step")
        if not (time >= 0.0 and 0 <= step < 2**53 and (step > 0) == (time > 0.0)):
            raise refuse(path, f"time is {time}, step {step}")
        if number(saved, "largest") < 0.0 or number(saved, "largest_displacement") < 0.0:
            raise refuse(path, "largest values are negative")
        if not np.all(np.isfinite(saved.array("obstacles"))):
            raise refuse(path, f"obstacles is {saved.array('obstacles')!r}")
        checkpoints.check_functions(path, attributes["functions of time"], self.problem.functions, time, time)

    def _apply(self, saved: _cpp.state.State, attributes: Mapping[str, Any], checked: Any) -> None:
        self.problem._cpp_object.resume(saved, self.problem.sample)
        self._resumed()

    def _forget(self) -> None:
        """Factors, start vectors, candidates of the search."""
        self.problem._cpp_object.forget()
