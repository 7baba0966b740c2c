# SPDX-License-Identifier: MIT
"""Saving and restoring explicit runs."""

import math

import numpy as np

from ..common import arguments
from ..io import checkpoint
from ..common.collective import agree, attempt, guard
from ..common.interrupts import Interrupts
from .step_schedule import StepSchedule
from ..io.signature import functions_of_time, short, supports

ENERGY = ("stored", "friction", "normal", "later_friction", "later_normal")
TABLES = ("works", "common")  # of numbers that the integrator saves by name: adding up over ranks, the same on all
NUMBERS = ("time", "next_time", "step", "safe_step", "nominal_step", "largest", "total_start")
SAME = 1e-12  # of the values of functions of time: other libraries may round otherwise
XI_MARGIN = 0.5  # reference coordinates on facets [0, 1]: nodes are held a little beside them


class Restart:
    """Saves and restores an explicit problem; see ExplicitProblem.save and restore.

    Args:
        problem: ExplicitProblem.
        stepper: its TimeStepper.
    """

    def __init__(self, problem, stepper) -> None:
        self.problem, self.stepper = problem, stepper
        self.comm, self.integrator = problem.comm, problem._cpp_object

    def save(self, path) -> None:
        """Write a checkpoint. Collective."""
        with guard(self.comm, "save", path=path):
            arguments.path("path", path)
        with Interrupts(self.comm) as interrupts:
            self.stepper.refresh()
            self._save(path)
            for recorder in self.stepper.recorders:
                recorder.flush()
            interrupts.check()

    def restore(self, path) -> None:
        """Become what a checkpoint holds. Collective."""
        with guard(self.comm, "restore", path=path):
            arguments.path("path", path)
        with Interrupts(self.comm) as interrupts:
            self._take(self._read(path))
            interrupts.check()

    def _save(self, path):
        state = self.integrator.save()
        bs = self.problem.space.dofmap.index_map_bs
        arrays = {name: values.reshape(-1, bs) for name, values in state["arrays"].items()}
        nodal, ranks = {}, {table: np.array(list(state[table].values())) for table in TABLES}
        for k, contact in enumerate(self.problem.contact):
            for j, side in enumerate(contact.sides()):
                nodal[f"contact{k}_{j}"] = (side.nodes, _pack(side.history()))
                ranks[f"contact{k}_{j}"] = np.array([side.own_energy()[name] for name in ENERGY])
        schedule, totals, stepper = self.stepper.schedule, {}, self.stepper
        for k, contact in enumerate(self.problem.contact):
            rows, totals[f"contact{k}"] = contact.save_results()
            nodal[f"results{k}"] = (contact.nodes, rows)
        s = schedule
        steps = [s.begin, s.until, s.first, s.last, s.auto] if s else []
        history = stepper.history
        started = history.total_start is not None
        table, error = attempt(functions_of_time, stepper.functions, stepper.time, stepper.next_time)
        agree(self.comm, error, "functions of time")
        attributes = {
            **totals,
            "time": stepper.time, "next_time": stepper.next_time, "step": stepper.step, "safe_step": stepper.safe_step,
            "nominal_step": stepper.nominal_step, "largest": history.largest,
            "total_start": history.total_start if started else 0.0, "schedule": np.array(steps, dtype=float),
            "functions of time": table, **{table: short(", ".join(state[table])) for table in TABLES},
        }  # fmt: skip
        checkpoint.write(path, self.problem, arrays, nodal, ranks, attributes)

    def _read(self, path):
        """All of a checkpoint, looked at; nothing is changed. Collective."""
        bs, saved = self.problem.space.dofmap.index_map_bs, self.integrator.saved_names()
        sides = [(f"contact{k}_{j}", s) for k, c in enumerate(self.problem.contact) for j, s in enumerate(c.sides())]
        results = {f"results{k}": contact.save_results()[0].shape[1] for k, contact in enumerate(self.problem.contact)}
        totals = [f"contact{k}" for k in range(len(self.problem.contact))]
        file = checkpoint.Reader(
            path,
            self.problem,
            arrays={name: bs for name in saved["arrays"]},
            nodal={**{name: sum(_widths(side.history()).values()) for name, side in sides}, **results},
            ranks={**{table: len(saved[table]) for table in TABLES}, **{name: len(ENERGY) for name, _ in sides}},
            attributes=[*NUMBERS, "schedule", "functions of time", *TABLES, *totals],
        )
        nodes, wanted = supports(self.problem)
        found = file.all_at("supports", nodes)
        other = np.flatnonzero(np.any(found != wanted, axis=1))
        error = None
        if len(other):
            place = checkpoint.places(self.problem.space)[nodes[other[0]]].tolist()
            error = ValueError(f"{path} is of another problem: supports differ, the first at {place}")
        agree(self.comm, error, "restore")
        read = {
            "file": file,
            "names": {table: list(saved[table]) for table in TABLES},
            "works": file.rank("works", True),
            "common": file.rank("common", False),
            "histories": [file.all_at(name, side.nodes) for name, side in sides],
            "energies": [file.rank(name, True) for name, _ in sides],
            "results": [file.all_at(f"results{k}", contact.nodes) for k, contact in enumerate(self.problem.contact)],
            "sides": [side for _, side in sides],
        }
        agree(self.comm, attempt(self._check, path, read)[1], "restore")
        return read

    def _check(self, path, read):
        """Look at what was read on this rank, and bring it into form."""
        a = read["file"].attributes

        def want(right, what):
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
        want(0.0 <= a["largest"] < math.inf and abs(a["total_start"]) < math.inf, "energies are no numbers")
        read["schedule"] = _schedule(a["schedule"], want, time, step)
        for table in TABLES:
            names = read["names"][table]
            want(str(a[table]) == short(", ".join(names)), f"{table} are {a[table]!r}")
            read[table] = dict(zip(names, read[table].tolist()))
        common = read["common"]
        numbers = [value for name, value in common.items() if name != "contact_step"]  # infinite where nothing limits
        want(np.all(np.isfinite(numbers)), "the table ranks/common has values that are no numbers")
        want(common["reference"] >= 0.0 and common["largest"] >= 0.0, "energies of ranks/common")
        want(common["last_step"] >= 0.0 and common["contact_step"] > 0.0, "steps of ranks/common")
        want(0.0 <= common["release_share"] <= 1.0, "what releases give back is no part")
        facets = 8 * self.problem.space.mesh.topology.index_map(self.problem.space.mesh.topology.dim).size_global
        read["histories"] = [
            _unpack(rows, side.history(), facets, want) for rows, side in zip(read["histories"], read["sides"])
        ]
        for k, contact in enumerate(self.problem.contact):
            totals, known = np.asarray(a[f"contact{k}"]), contact.save_results()[1]
            want(totals.shape == known.shape and np.all(np.isfinite(totals)), f"contact{k} is {totals!r}")
        here, there = functions_of_time(self.stepper.functions, time, beyond), np.asarray(a["functions of time"])
        scale = np.abs(here).max(initial=0.0)
        if there.shape != here.shape or not np.all(np.abs(here - there) <= SAME * scale):
            raise ValueError(
                f"{path} is of another problem: functions of time (of loads, supports, obstacles) have other values up "
                f"to the time {time:g}"
            )

    def _take(self, read):
        """Become what was read; nothing of this can fail. Collective."""
        file = read["file"]
        a = file.attributes
        # Constants, functions and loads as they are now are those of the state that is read.
        self.stepper.inputs.take_all()
        for side, history, energy in zip(read["sides"], read["histories"], read["energies"]):
            side.set_history(history)
            side.set_energy(*energy)
        arrays = {name: np.ascontiguousarray(values).ravel() for name, values in file.arrays.items()}
        self.integrator.restore(arrays, read["works"], read["common"])
        step = int(a["step"])
        # Loads and prescribed motion of the present time are needed: acceleration and velocity have them in.
        self.stepper.resume(
            float(a["time"]),
            step,
            float(a["next_time"]),
            float(a["safe_step"]),
            float(a["nominal_step"]),
            read["schedule"],
        )
        self.stepper.history.resume(float(a["total_start"]) if step else None, float(a["largest"]))
        self.stepper.state.update()
        for k, contact in enumerate(self.problem.contact):
            contact.restore_results(read["results"][k], np.asarray(a[f"contact{k}"]))


def _schedule(values, want, time, step):
    """The steps that were still to be taken, or None."""
    values = np.asarray(values, dtype=float).ravel()
    want(len(values) in (0, 5) and np.all(np.isfinite(values)), f"schedule is {values.tolist()}")
    if not len(values):
        return None
    begin, until, first, last, auto = values.tolist()
    schedule = StepSchedule(begin, until, int(first), int(last), bool(auto))
    right = 0.0 <= begin < until and 0 <= first < last and auto in (0.0, 1.0) and first % 1 == last % 1 == 0.0
    right = right and first <= step <= last and abs(schedule.times(np.array(step)) - time) <= SAME * until
    want(right, f"schedule is {values.tolist()} at the time {time} and step {step}")
    return schedule


def _widths(history):
    """Columns of each array of a contact's history, by name."""
    return {name: math.prod(values.shape[1:]) for name, values in history.items()}


def _pack(history):
    """History of a contact's nodes as one table: its arrays side by side, in their order."""
    widths = _widths(history)
    return np.hstack([values.astype(float).reshape(len(values), widths[name]) for name, values in history.items()])


def _unpack(rows, like, facets, want):
    """Back from `_pack`, looked at.

    Args:
        like: a history of the contact, with the names, shapes and types. facets: numbers of facets are less than this.
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
