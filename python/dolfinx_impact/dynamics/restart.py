# SPDX-License-Identifier: MIT
"""Saving and restoring explicit runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from .. import _cpp
from ..io import checkpoint
from ..common.collective import agree, attempt
from ..common.types import AnyArray, ArrayLike, FilePath, FloatArray, IntArray
from ..io.given_arguments import short
from ..io.signature import functions_of_time
from .checkpoints import SAME, Checkpoints
from .step_schedule import StepSchedule

if TYPE_CHECKING:
    from .explicit import ExplicitProblem
    from .recorder import Recorder
    from .time_stepper import TimeStepper

ENERGY = ("stored", "friction", "normal", "later_friction", "later_normal", "recoverable")
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
NodeHistory: TypeAlias = dict[str, AnyArray]  # arrays of a contact's nodes by name, rows by node


@dataclass
class Stored:
    """Tables of a checkpoint as read, before their values are checked.

    Attributes:
        file: reader of the checkpoint.
        names: names of the entries of each of TABLES.
        tables: entries of each of TABLES, this rank's share.
        sides: C++ contacts.
        histories: packed history of each side, rows by node.
        sums: energies of each side in the order of ENERGY [F L], then the force on its slave [F], this rank's share.
        results: results of each contact, rows by node.
    """

    file: checkpoint.Reader
    names: dict[str, list[str]]
    tables: dict[str, FloatArray]
    sides: list[_cpp.nodal.NodePenalty | _cpp.nodal.KinematicContact]
    histories: list[FloatArray]
    sums: list[FloatArray]
    results: list[FloatArray]


@dataclass
class Checked:
    """Contents of a checkpoint after all values have been checked.

    Attributes:
        stored: tables as read.
        schedule: steps of an `advance` that was interrupted, or None.
        tables: entries of each of TABLES by name.
        histories: history of each side.
    """

    stored: Stored
    schedule: StepSchedule | None
    tables: dict[str, dict[str, float]]
    histories: list[NodeHistory]


class Restart(Checkpoints):
    """Saves and restores an explicit problem; see ExplicitProblem.save and restore.

    Args:
        problem: ExplicitProblem.
        stepper: its TimeStepper.
    """

    def __init__(self, problem: ExplicitProblem, stepper: TimeStepper) -> None:
        super().__init__(problem)
        self.problem, self.stepper, self.integrator = problem, stepper, stepper.integrator

    def _recorders(self) -> Sequence[Recorder]:
        return self.stepper.recorders

    def _save(self, path: FilePath) -> None:
        self.stepper.refresh()
        state = self.integrator.save()
        bs = self.problem.space.dofmap.index_map_bs
        arrays = {name: values.reshape(-1, bs) for name, values in state["arrays"].items()}
        nodal: dict[str, tuple[IntArray, FloatArray]] = {}
        ranks = {table: np.array(list(state[table].values())) for table in TABLES}
        for k, contact in enumerate(self.problem.contact):
            for j, side in enumerate(contact.sides()):
                nodal[f"contact{k}_{j}"] = (side.nodes, _pack(side.history()))
                energy = [side.own_energy()[name] for name in ENERGY]
                ranks[f"contact{k}_{j}"] = np.array([*energy, *side.force])
        stepper, totals = self.stepper, {}
        for k, contact in enumerate(self.problem.contact):
            rows, totals[f"contact{k}"] = contact.save_results()
            nodal[f"results{k}"] = (contact.nodes, rows)
        s = stepper.schedule
        steps = [s.begin, s.until, s.first, s.last, s.auto] if s else []
        history, watch, changes = stepper.history, stepper.watch, stepper.inputs.changes
        table, error = attempt(functions_of_time, stepper.functions, stepper.time, stepper.next_time)
        agree(self.comm, error, "functions of time")
        attributes = {
            **totals,
            "time": stepper.time, "next_time": stepper.next_time, "step": stepper.step, "safe_step": stepper.safe_step,
            "nominal_step": stepper.nominal_step, "check_step": stepper.check_step,
            "check_interval": stepper.check_interval, "largest": history.largest,
            "total_start": 0.0 if history.total_start is None else history.total_start,
            "deformed": int(stepper.deformed), "input_change": changes.total if changes.stale else -1.0,
            "allowed_change": changes.allowed, "sensitivity": 0.0 if watch is None else watch.sensitivity,
            "schedule": np.array(steps, dtype=float), "functions of time": table,
            **{table: short(", ".join(state[table])) for table in TABLES},
        }  # fmt: skip
        cellwise = self._material_history()
        if watch is not None:
            arrays["watch"] = watch.reference[: self.problem.num_owned].reshape(-1, bs)
            cellwise |= {f"watch {name}": getattr(watch, name)[:, None] for name in WATCH}
        checkpoint.write(path, self.problem, arrays, nodal, cellwise, ranks, attributes)

    def _restore(self, path: FilePath) -> None:
        self._apply(self._read(path))

    def _read(self, path: FilePath) -> Checked:
        """Read and check a whole checkpoint; the problem is not changed. Collective."""
        bs, saved = self.problem.space.dofmap.index_map_bs, self.integrator.saved_names()
        gdim = self.problem.space.mesh.geometry.dim
        sides = [(f"contact{k}_{j}", s) for k, c in enumerate(self.problem.contact) for j, s in enumerate(c.sides())]
        results = {f"results{k}": contact.save_results()[0].shape[1] for k, contact in enumerate(self.problem.contact)}
        totals = [f"contact{k}" for k in range(len(self.problem.contact))]
        columns = {name: values.shape[1] for name, values in self._material_history().items()}
        watched = self.stepper.watch is not None
        file = checkpoint.Reader(
            path,
            self.problem,
            arrays={name: bs for name in [*saved["arrays"], *(["watch"] if watched else [])]},
            nodal={**{name: sum(_widths(side.history()).values()) for name, side in sides}, **results},
            cellwise=columns | (dict.fromkeys([f"watch {name}" for name in WATCH], 1) if watched else {}),
            ranks={**{table: len(saved[table]) for table in TABLES}, **{name: len(ENERGY) + gdim for name, _ in sides}},
            attributes=[*NUMBERS, "schedule", "functions of time", *TABLES, *totals],
        )
        self._check_supports(path, file)
        stored = Stored(
            file=file,
            names={table: list(saved[table]) for table in TABLES},
            tables={"works": file.rank("works", True), "common": file.rank("common", False)},
            sides=[side for _, side in sides],
            histories=[file.all_at(name, side.nodes) for name, side in sides],
            sums=[file.rank(name, True) for name, _ in sides],
            results=[file.all_at(f"results{k}", contact.nodes) for k, contact in enumerate(self.problem.contact)],
        )
        checked, error = attempt(self._check, path, stored)
        agree(self.comm, error, "restore")
        return checked

    def _check(self, path: FilePath, stored: Stored) -> Checked:
        """Check the values on this rank and convert them."""
        a = stored.file.attributes

        def want(right: bool | np.bool_, what: str) -> None:
            if not right:
                raise ValueError(f"{path} is of no run: {what}")

        for name in NUMBERS:
            value = a[name]
            want(np.ndim(value) == 0 and np.issubdtype(np.asarray(value).dtype, np.number), f"{name} is {value!r}")
            want(not math.isnan(value), f"{name} is {value!r}")
        time, beyond, step = float(a["time"]), float(a["next_time"]), int(a["step"])
        want(0.0 <= time <= beyond < math.inf, f"time is {time}, the next one {beyond}")
        want(step == a["step"] and 0 <= step < 2**53 and (step > 0) == (time > 0.0), f"step is {a['step']}")
        want(a["safe_step"] > 0.0 and a["nominal_step"] > 0.0, f"steps are {a['safe_step']} and {a['nominal_step']}")
        checks = a["check_step"], a["check_interval"]
        want(all(0 < c < 2**53 and int(c) == c for c in checks), f"checks of the stable step are {checks}")
        want(0.0 <= a["largest"] < math.inf and abs(a["total_start"]) < math.inf, "energies are no numbers")
        want(a["deformed"] in (0, 1) and a["allowed_change"] > 0.0, "changes of the stable step")
        want(a["sensitivity"] > 0.0 or self.stepper.watch is None, f"sensitivity is {a['sensitivity']}")
        if self.stepper.watch is not None:
            rows = [stored.file.cellwise[f"watch {name}"] for name in WATCH] + [stored.file.arrays["watch"]]
            want(
                all(np.all(np.isfinite(r)) for r in rows), "the watch of the stable step has values that are no numbers"
            )
            want(all(np.all(r >= 0.0) for r in rows[:-1]), "the watch of the stable step has negative values")
        schedule = _schedule(a["schedule"], want, time, step)
        tables = {}
        for table in TABLES:
            names = stored.names[table]
            want(str(a[table]) == short(", ".join(names)), f"{table} are {a[table]!r}")
            tables[table] = dict(zip(names, (float(value) for value in stored.tables[table])))
        common = tables["common"]
        numbers = [value for name, value in common.items() if name != "contact_step"]  # infinite where nothing limits
        want(np.all(np.isfinite(numbers)), "the table ranks/common has values that are no numbers")
        want(common["reference"] >= 0.0 and common["largest"] >= 0.0, "energies of ranks/common")
        want(common["last_step"] >= 0.0 and common["contact_step"] > 0.0, "steps of ranks/common")
        want(0.0 <= common["release_share"] <= 1.0, "what releases give back is no part")
        facets = 8 * self.problem.space.mesh.topology.index_map(self.problem.space.mesh.topology.dim).size_global
        histories = [_unpack(rows, side.history(), facets, want) for rows, side in zip(stored.histories, stored.sides)]
        for k, contact in enumerate(self.problem.contact):
            totals, known = np.asarray(a[f"contact{k}"]), contact.save_results()[1]
            want(totals.shape == known.shape and np.all(np.isfinite(totals)), f"contact{k} is {totals!r}")
        self._check_functions(path, a["functions of time"], self.stepper.functions, time, beyond)
        return Checked(stored, schedule, tables, histories)

    def _apply(self, checked: Checked) -> None:
        """Set the problem to the state that was read; this raises no exceptions. Collective."""
        stored = checked.stored
        a = stored.file.attributes
        # The present constants, functions and loads are those of the state that was read.
        self.stepper.inputs.update_all()
        cellwise = dict(stored.file.cellwise)
        watch = self.stepper.watch
        watched = [] if watch is None else [cellwise.pop(f"watch {name}")[:, 0].copy() for name in WATCH]
        self._set_material_history(cellwise)
        for side, history, sums in zip(stored.sides, checked.histories, stored.sums):
            side.set_history(history)
            side.set_energy(*sums[: len(ENERGY)])
            side.set_force(sums[len(ENERGY) :])  # the next row of the history tells of it
        arrays = {name: np.ascontiguousarray(values).ravel() for name, values in stored.file.arrays.items()}
        changes, change = self.stepper.inputs.changes, float(a["input_change"])
        changes.stale, changes.total, changes.allowed = change >= 0.0, max(change, 0.0), float(a["allowed_change"])
        if watch is not None:
            squares, rates, since = watched
            watch.resume(squares, rates, since, arrays.pop("watch"), float(a["sensitivity"]))
        self.integrator.restore(arrays, checked.tables["works"], checked.tables["common"])
        step = int(a["step"])
        # `resume` gives the integrator loads and prescribed motion, which acceleration and velocity depend on.
        self.stepper.resume(
            float(a["time"]),
            step,
            float(a["next_time"]),
            float(a["safe_step"]),
            float(a["nominal_step"]),
            int(a["check_step"]),
            int(a["check_interval"]),
            checked.schedule,
            bool(a["deformed"]),
        )
        self.stepper.history.resume(float(a["total_start"]) if step else None, float(a["largest"]))
        self.stepper.state.update()
        for k, contact in enumerate(self.problem.contact):
            contact.restore_results(stored.results[k], np.asarray(a[f"contact{k}"]))


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


def _widths(history: Mapping[str, AnyArray]) -> dict[str, int]:
    """Number of columns of each array of a contact's history, by name."""
    return {name: math.prod(values.shape[1:]) for name, values in history.items()}


def _pack(history: Mapping[str, AnyArray]) -> FloatArray:
    """History of a contact's nodes as one table with the columns of all arrays, in their order."""
    widths = _widths(history)
    return np.hstack([values.astype(float).reshape(len(values), widths[name]) for name, values in history.items()])


def _unpack(rows: FloatArray, like: Mapping[str, AnyArray], facets: int, want: Want) -> NodeHistory:
    """Check a table of `_pack` and split it into arrays.

    Args:
        rows: table, rows by node.
        like: history of the contact, with the names, shapes and types of the arrays.
        facets: upper bound of the numbers of facets [1].
        want: raises ValueError unless a condition holds.

    Returns:
        Arrays by name.
    """
    ends = np.cumsum(list(_widths(like).values()))
    columns = dict(zip(like, np.split(rows, ends[:-1], axis=1)))
    closed, facet, xi = (columns[name] for name in ("closed", "facet", "xi"))
    want(np.all(np.isin(closed, (-1.0, 0.0, 1.0))), "a contact's nodes have a state that does not exist")
    want(
        np.all((facet % 1 == 0) & (facet >= -1) & (facet < facets)), "a contact's nodes are on facets that do not exist"
    )
    want(np.all((xi >= -XI_MARGIN) & (xi <= 1.0 + XI_MARGIN)), "a contact's nodes are beside their facets")
    want(np.all(np.isfinite(rows)), "forces, energies or impulses of a contact's nodes are no numbers")
    return {
        name: np.ascontiguousarray(columns[name].reshape(values.shape).astype(values.dtype))
        for name, values in like.items()
    }
