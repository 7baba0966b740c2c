# SPDX-License-Identifier: MIT
"""Saving and restoring explicit runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np

from .. import _cpp
from ..common.collective import agree, attempt
from ..common.types import ArrayLike, FilePath
from ..io import checkpoints
from ..io.checkpoint import Attribute
from ..io.checkpoints import SAME, Checkpoints, Place, number, refuse
from ..io.given_arguments import short
from ..io.signature import functions_of_time
from .recorder import Recorder
from .started_problem import StartedProblem
from .step_schedule import StepSchedule
from .subject import check_nodal, in_time
from .time_stepper import TimeStepper

TABLES = ("works", "common")  # numbers that the integrator saves by name: sums over ranks, equal on all ranks
NUMBERS = (
    "time",
    "next_time",
    "step",
    "safe_step",
    "nominal_step",
    "check_step",
    "check_interval",
    "largest",
    "total_start",
    "deformed",
    "input_change",
    "allowed_change",
    "sensitivity",
)
# Of the watch over the stable step, by cell: see StableStepWatch.
WATCH = ("squares", "rates", "since")
XI_MARGIN = 0.5  # reference coordinates on facets are in [0, 1]; tracked nodes may lie outside by this much

Want: TypeAlias = Callable[[bool | np.bool_, str], None]  # raises ValueError with a text unless a condition holds


class Restart(Checkpoints):
    """Saves and restores an explicit problem; see ExplicitProblem.save and restore.

    Args:
        problem: ExplicitProblem.
        stepper: its TimeStepper.
    """

    more = ("schedule", "functions of time", *TABLES)
    equal = ("common",)
    infinite = ("common", "results")  # a step that nothing limits, gaps of nodes without a master

    def __init__(self, problem: StartedProblem, stepper: TimeStepper) -> None:
        super().__init__(in_time(problem))
        self.problem, self.stepper, self._cpp_object = problem, stepper, problem._cpp_object

    def _recorders(self) -> Sequence[Recorder]:
        return self.stepper.recorders

    def _check_kind(self, call: str) -> None:
        check_nodal(self.problem.space, call)

    def _state(self) -> _cpp.state.State:
        self.stepper.refresh()
        return self._with(self._cpp_object.saved_state())

    def _like(self) -> _cpp.state.State:
        return self._with(self._cpp_object.empty_state())

    def _with(self, run: _cpp.state.State) -> _cpp.state.State:
        """The state of the C++ problem, with results of contacts."""
        for k, contact in enumerate(self.problem.contact):
            for part in contact.results_state():
                part.rename(f"{part.name}{k}")
                run.add(part)
        return run

    @staticmethod
    def _sides(saved: _cpp.state.State, k: int) -> list[_cpp.state.State]:
        """States of the sides of a contact."""
        return [saved.part(name) for name in saved.parts if name.startswith(f"contact{k}_")]

    def _attributes(self) -> dict[str, Attribute]:
        stepper, s = self.stepper, self.stepper.schedule
        steps: list[float] = [s.begin, s.until, s.first, s.last, s.auto] if s else []
        table, error = attempt(functions_of_time, stepper.functions, self._cpp_object.time, stepper.next_time)
        agree(self.comm, error, "functions of time")
        return {"schedule": np.array(steps, dtype=float), "functions of time": table, **self._names()}

    def _names(self) -> dict[str, str]:
        """Names in TABLES as texts."""
        parts = self._cpp_object.integrator.empty_state()
        return {table: short(", ".join(parts.part(table).names)) for table in TABLES}

    def _check(self, path: FilePath, saved: _cpp.state.State, attributes: Mapping[str, Any]) -> StepSchedule | None:
        """Check the values on this rank.

        Returns:
            Steps of an `advance` that was interrupted, or None.
        """

        def want(right: bool | np.bool_, what: str) -> None:
            if not right:
                raise refuse(path, what)

        a = {name: number(saved, name) for name in NUMBERS}
        for name, value in a.items():
            want(not math.isnan(value), f"{name} is {value!r}")
        time, beyond, step = a["time"], a["next_time"], int(a["step"])
        want(0.0 <= time <= beyond < math.inf, f"time is {time}, the next one {beyond}")
        want(0 <= step < 2**53 and (step > 0) == (time > 0.0), f"step is {a['step']}")
        want(a["safe_step"] > 0.0 and a["nominal_step"] > 0.0, f"steps are {a['safe_step']} and {a['nominal_step']}")
        checks = a["check_step"], a["check_interval"]
        want(all(0 < c < 2**53 for c in checks), f"checks of the stable step are {checks}")
        want(0.0 <= a["largest"] < math.inf and abs(a["total_start"]) < math.inf, "energies are no numbers")
        want(a["deformed"] in (0, 1) and a["allowed_change"] > 0.0, "changes of the stable step")
        want(a["sensitivity"] > 0.0 or self.stepper.watch is None, f"sensitivity is {a['sensitivity']}")
        if self.stepper.watch is not None:
            of_cells = [saved.array(f"watch {name}") for name in WATCH]
            want(
                all(np.all(np.isfinite(r)) for r in (*of_cells, saved.array("watch"))),
                "the watch of the stable step has values that are no numbers",
            )
            want(all(np.all(r >= 0.0) for r in of_cells), "the watch of the stable step has negative values")
        schedule = _schedule(attributes["schedule"], want, time, step)
        for table, names in self._names().items():
            want(str(attributes[table]) == names, f"{table} are {attributes[table]!r}")
        common = _numbers(saved.part("integrator").part("common"))
        numbers = [value for name, value in common.items() if name != "contact_step"]  # infinite where nothing limits
        want(np.all(np.isfinite(numbers)), "the table ranks/common has values that are no numbers")
        want(common["reference"] >= 0.0 and common["largest"] >= 0.0, "energies of ranks/common")
        want(common["last_step"] >= 0.0 and common["contact_step"] > 0.0, "steps of ranks/common")
        want(0.0 <= common["release_share"] <= 1.0, "what releases give back is no part")
        facets = 8 * self.problem.space.mesh.topology.index_map(self.problem.space.mesh.topology.dim).size_global
        for k in range(len(self.problem.contact)):
            for side in self._sides(saved, k):
                _check_nodes(side, facets, want)
            totals = list(_numbers(saved.part(f"contact{k}")).values())
            want(np.all(np.isfinite(np.concatenate([np.ravel(t) for t in totals]))), f"contact{k} is {totals!r}")
        checkpoints.check_functions(path, attributes["functions of time"], self.stepper.functions, time, beyond)
        return schedule

    def _apply(self, saved: _cpp.state.State, attributes: Mapping[str, Any], checked: StepSchedule | None) -> None:
        """It raises no exceptions."""
        # The present constants, functions and loads are those of the state that was read.
        self.stepper.inputs.update_all()
        self.stepper.resume(saved, checked)
        self.stepper.state.update()
        for k, contact in enumerate(self.problem.contact):
            contact.resume_results(saved.part(f"results{k}"), saved.part(f"contact{k}"))


def _numbers(state: _cpp.state.State) -> dict[str, Any]:
    """Numbers, or vectors, of a state by name."""
    found = {name: state.array(name) for name in state.names}
    return {name: values[0].item() if len(values) == 1 else values for name, values in found.items()}


def _schedule(values: ArrayLike, want: Want, time: float, step: int) -> StepSchedule | None:
    """Steps of an `advance` that was interrupted, from its five numbers; None without numbers."""
    numbers = np.asarray(values, dtype=float).ravel()
    want(len(numbers) in (0, 5) and np.all(np.isfinite(numbers)), f"schedule is {numbers.tolist()}")
    if not len(numbers):
        return None
    begin, until, first, last, auto = (float(number) for number in numbers)
    schedule = StepSchedule(begin, until, int(first), int(last), bool(auto))
    right = 0.0 <= begin < until and 0 <= first < last and auto in (0.0, 1.0) and first % 1 == last % 1 == 0.0
    right = right and first <= step <= last and bool(abs(schedule.time(step) - time) <= SAME * until)
    want(right, f"schedule is {numbers.tolist()} at the time {time} and step {step}")
    return schedule


def _check_nodes(state: _cpp.state.State, facets: int, want: Want) -> None:
    """Check the history of a contact's nodes.

    Args:
        state: state of a side of a contact.
        facets: upper bound of the numbers of facets [1].
        want: raises ValueError unless a condition holds.
    """
    if "closed" in state.names:  # ties have multipliers alone
        right = np.all(np.isin(state.array("closed"), (-1, 0, 1)))
        want(right, "a contact's nodes have a state that does not exist")
    if "facet" in state.names:  # neither ties nor general contact follow facets
        facet, xi = state.array("facet"), state.array("xi")
        want(np.all((facet >= -1) & (facet < facets)), "a contact's nodes are on facets that do not exist")
        want(np.all((xi >= -XI_MARGIN) & (xi <= 1.0 + XI_MARGIN)), "a contact's nodes are beside their facets")
    rows = [np.ravel(state.array(name)) for name in state.names if state.place(name) == Place.node]
    want(
        all(np.all(np.isfinite(values)) for values in rows),
        "forces, energies or impulses of a contact's nodes are no numbers",
    )
