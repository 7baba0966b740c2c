# SPDX-License-Identifier: MIT
"""Saving and restoring implicit runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ... import _cpp
from ...common.collective import agree, attempt
from ...common.types import FilePath, FloatArray
from ...io import checkpoints
from ...io.checkpoint import Attribute
from ...io.checkpoints import Checkpoints, number, refuse
from ...io.signature import Problem, functions_of_time
from ..functions_of_time import FunctionsOfTime
from ..subject import check_nodal, in_time

if TYPE_CHECKING:
    from ..recorder import Recorder

WORKS = ("work internal", "work external", "work damping")
NUMBERS = ("time", "step", "largest", "total_start", "largest_displacement", *WORKS)


class ImplicitRestart(Checkpoints):
    """Saves and restores an implicit problem; see NewmarkProblem.save and restore.

    Args:
        problem: the problem, as a checkpoint tells it from others.
        cpp_object: the problem in C++.
        functions: functions of time of loads, supports and obstacles.
        recorders: Recorders that write during the run.
        sample: function that returns values of all functions of time at given times.
        resumed: function that computes what follows from a restored state.
    """

    more = ("functions of time",)

    def __init__(
        self,
        problem: Problem,
        cpp_object: _cpp.problems.NewmarkProblem,
        functions: FunctionsOfTime,
        recorders: Sequence[Recorder],
        sample: Callable[[FloatArray], FloatArray],
        resumed: Callable[[], None],
    ) -> None:
        super().__init__(in_time(problem))
        self._space, self._cpp_object, self._functions = problem.space, cpp_object, functions
        self._written_by, self._sample, self._resumed = recorders, sample, resumed

    def _recorders(self) -> Sequence[Recorder]:
        return self._written_by

    def _check_kind(self, call: str) -> None:
        check_nodal(self._space, call)

    def _state(self) -> _cpp.state.State:
        return self._cpp_object.saved_state()

    def _attributes(self) -> dict[str, Attribute]:
        time = self._cpp_object.time
        table, error = attempt(functions_of_time, self._functions, time, time)
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
        checkpoints.check_functions(path, attributes["functions of time"], self._functions, time, time)

    def _apply(self, saved: _cpp.state.State, attributes: Mapping[str, Any], checked: Any) -> None:
        self._cpp_object.resume(saved, self._sample)
        self._resumed()

    def _forget(self) -> None:
        """Factors, start vectors, candidates of the search."""
        self._cpp_object.forget()
