# SPDX-License-Identifier: MIT
"""Saving and restoring explicit runs."""

import math

import numpy as np

from ..common import arguments
from ..io import checkpoint
from ..common.collective import agree, attempt, guard
from ..common.interrupts import Interrupts
from .time_stepping import Plan
from ..io.signature import functions_of_time, short, supports

ENERGY = ("stored", "friction", "normal", "later_friction", "later_normal")
TABLES = ("works", "common")  # of numbers that the integrator saves by name: adding up over ranks, the same on all
NUMBERS = ("time", "beyond", "step", "safe", "nominal", "largest", "total_start")
SAME = 1e-12  # of the values of functions of time: other libraries may round otherwise
XI_MARGIN = 0.5  # reference coordinates on facets [0, 1]: nodes are held a little beside them


class Restart:
    """The part of ExplicitProblem that saves and restores."""

    def save(self, path):
        """Write a checkpoint, HDF5: all that a run needs to go on as if it had not stopped. Collective.

        It is written as PATH.part and then renamed: if anything goes wrong with it an earlier file at `path` is as it
        was. Recorders write their histories up to now after it. Ctrl-C waits until that is done.

        Raises:
            RuntimeError: the folder cannot be written, no space is left; on all ranks.
        """
        with guard(self.comm, "save", path=path):
            arguments.path("path", path)
        with Interrupts(self.comm) as interrupts:
            self._refresh()
            self._save(path)
            for recorder in self._recorders:
                recorder.flush()
            interrupts.check()

    def _save(self, path):
        state = self._cpp.save()
        bs = self.space.dofmap.index_map_bs
        arrays = {name: values.reshape(-1, bs) for name, values in state["arrays"].items()}
        nodal, ranks = {}, {table: np.array(list(state[table].values())) for table in TABLES}
        for k, contact in enumerate(self.contact):
            for j, side in enumerate(contact.sides()):
                nodal[f"contact{k}_{j}"] = (side.nodes, _pack(side.history()))
                ranks[f"contact{k}_{j}"] = np.array([side.own_energy()[name] for name in ENERGY])
        plan, totals = self._plan, {}
        for k, contact in enumerate(self.contact):
            rows, totals[f"contact{k}"] = contact.save_results()
            nodal[f"results{k}"] = (contact.nodes, rows)
        plan = [plan.begin, plan.until, plan.first, plan.last, plan.auto] if plan else []
        table, error = attempt(functions_of_time, self, self.time, self._beyond)
        agree(self.comm, error, "functions of time")
        attributes = {
            **totals,
            "time": self.time, "beyond": self._beyond, "step": self.step, "safe": self._safe, "nominal": self._nominal,
            "largest": self._largest, "total_start": self._total_start, "plan": np.array(plan, dtype=float),
            "functions of time": table, **{table: short(", ".join(state[table])) for table in TABLES},
        }  # fmt: skip
        checkpoint.write(path, self, arrays, nodal, ranks, attributes)

    def restore(self, path):
        """Go on from a checkpoint of the same problem, written on any number of ranks. Collective.

        The same are mesh, materials, damping, scheme, supports, loads, contacts, and their functions of time up to the
        time of the checkpoint, to the last digit. Values of loads (`constant.value`) must be those that they had when
        it was written; afterwards they may be changed, as between any two calls of `advance`.

        On as many ranks as wrote it the run goes on bit for bit (if DOLFINx numbers the mesh as it did then, which it
        does not always on three ranks and more), on others to round-off. `advance` with the time that
        the interrupted call had continues with its very steps. Constants, functions and loads that were changed in the
        course of the run are not in the file: set them before.

        Raises:
            RuntimeError: the file cannot be read, or is damaged. ValueError: it is of another mesh, material, ...; on
            all ranks. The problem is then as it was.
        """
        with guard(self.comm, "restore", path=path):
            arguments.path("path", path)
        with Interrupts(self.comm) as interrupts:
            self._take(self._read(path))
            interrupts.check()

    def _read(self, path):
        """All of a checkpoint, looked at; nothing is changed. Collective."""
        bs, saved = self.space.dofmap.index_map_bs, self._cpp.saved_names()
        sides = [(f"contact{k}_{j}", s) for k, c in enumerate(self.contact) for j, s in enumerate(c.sides())]
        results = {f"results{k}": contact.save_results()[0].shape[1] for k, contact in enumerate(self.contact)}
        file = checkpoint.Reader(
            path,
            self,
            arrays={name: bs for name in saved["arrays"]},
            nodal={**{name: sum(_widths(side.history()).values()) for name, side in sides}, **results},
            ranks={**{table: len(saved[table]) for table in TABLES}, **{name: len(ENERGY) for name, _ in sides}},
            attributes=[
                *NUMBERS, "plan", "functions of time", *TABLES, *(f"contact{k}" for k in range(len(self.contact))),
            ],  # fmt: skip
        )
        nodes, wanted = supports(self)
        found = file.all_at("supports", nodes)
        other = np.flatnonzero(np.any(found != wanted, axis=1))
        error = None
        if len(other):
            place = checkpoint.places(self.space)[nodes[other[0]]].tolist()
            error = ValueError(f"{path} is of another problem: supports differ, the first at {place}")
        agree(self.comm, error, "restore")
        read = {
            "file": file,
            "names": {table: list(saved[table]) for table in TABLES},
            "works": file.rank("works", True),
            "common": file.rank("common", False),
            "histories": [file.all_at(name, side.nodes) for name, side in sides],
            "energies": [file.rank(name, True) for name, _ in sides],
            "results": [file.all_at(f"results{k}", contact.nodes) for k, contact in enumerate(self.contact)],
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
        time, beyond, step = float(a["time"]), float(a["beyond"]), int(a["step"])
        want(0.0 <= time <= beyond < math.inf, f"time is {time}, the next one {beyond}")
        want(step == a["step"] and 0 <= step < 2**53 and (step > 0) == (time > 0.0), f"step is {a['step']}")
        want(a["safe"] > 0.0 and a["nominal"] > 0.0, f"steps are {a['safe']} and {a['nominal']}")
        want(0.0 <= a["largest"] < math.inf and abs(a["total_start"]) < math.inf, "energies are no numbers")
        read["plan"] = _plan(a["plan"], want, time, step)
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
        facets = 8 * self.space.mesh.topology.index_map(self.space.mesh.topology.dim).size_global
        read["histories"] = [
            _unpack(rows, side.history(), facets, want) for rows, side in zip(read["histories"], read["sides"])
        ]
        for k, contact in enumerate(self.contact):
            totals, known = np.asarray(a[f"contact{k}"]), contact.save_results()[1]
            want(totals.shape == known.shape and np.all(np.isfinite(totals)), f"contact{k} is {totals!r}")
        here, there = functions_of_time(self, time, beyond), np.asarray(a["functions of time"])
        scale = np.abs(here).max(initial=0.0)
        if there.shape != here.shape or not np.all(np.abs(here - there) <= SAME * scale):
            raise ValueError(
                f"{path} is of another problem: functions of time (of loads, supports, obstacles) have other values up "
                f"to the time {time:g}"
            )
        # Loads and prescribed motion of the present time: acceleration and velocity have them in.
        read["table"] = self._table(np.array([time, beyond]))

    def _take(self, read):
        """Become what was read; nothing of this can fail. Collective."""
        file, table = read["file"], read["table"]
        a = file.attributes
        # Constants, functions and loads as they are now are those of the state that is read.
        for term in self._terms:
            term.update()
        for k, load in enumerate(self._loads):
            self._cpp.set_load(k, load.values())
        self._frequencies.take()
        for side, history, energy in zip(read["sides"], read["histories"], read["energies"]):
            side.set_history(history)
            side.set_energy(*energy)
        arrays = {name: np.ascontiguousarray(values).ravel() for name, values in file.arrays.items()}
        self._cpp.restore(arrays, read["works"], read["common"])
        self.time, self.step, self._beyond = float(a["time"]), int(a["step"]), float(a["beyond"])
        self._cpp.run(np.zeros(0), np.ascontiguousarray(table).ravel(), table.shape[1], np.zeros(0))
        self._safe, self._nominal = float(a["safe"]), float(a["nominal"])
        self._largest, self._total_start = float(a["largest"]), float(a["total_start"])
        self._plan = read["plan"]
        self._good, self._known_start, self._stale = None, self.step > 0, False
        self._history.clear()
        self._look()
        for k, contact in enumerate(self.contact):
            contact.restore_results(read["results"][k], np.asarray(a[f"contact{k}"]))


def _plan(values, want, time, step):
    """The steps that were still to be taken, or None."""
    values = np.asarray(values, dtype=float).ravel()
    want(len(values) in (0, 5) and np.all(np.isfinite(values)), f"plan is {values.tolist()}")
    if not len(values):
        return None
    begin, until, first, last, auto = values.tolist()
    plan = Plan(begin, until, int(first), int(last), bool(auto))
    right = 0.0 <= begin < until and 0 <= first < last and auto in (0.0, 1.0) and first % 1 == last % 1 == 0.0
    right = right and first <= step <= last and abs(plan.times(np.array(step)) - time) <= SAME * until
    want(right, f"plan is {values.tolist()} at the time {time} and step {step}")
    return plan


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
