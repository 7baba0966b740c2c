# SPDX-License-Identifier: MIT
"""Saving and restoring implicit runs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ... import _cpp
from ...common.collective import agree, attempt
from ...common.types import FilePath, FloatArray, IntArray
from ...contact.saved_history import SavedHistory
from ...io import checkpoint
from ...io.signature import functions_of_time
from ..checkpoints import Checkpoints

if TYPE_CHECKING:
    from ..recorder import Recorder
    from .problem import NewmarkProblem

MOTION = ("displacement", "velocity", "acceleration", "mean")
FORCES = ("internal", "external", "damping", "support")
WORKS = ("internal", "external", "damping")
CONTROL = ("length", "largest", "smallest", "last", "tolerance")  # of steps; not a number where there is none
NUMBERS = ("time", "step", "largest", "total_start", "largest_displacement")


class ImplicitRestart(Checkpoints):
    """Saves and restores an implicit problem; see NewmarkProblem.save and restore.

    Args:
        problem: NewmarkProblem.
    """

    def __init__(self, problem: NewmarkProblem) -> None:
        super().__init__(problem)
        self.problem = problem

    def _recorders(self) -> Sequence[Recorder]:
        return self.problem.stepper.recorders

    def _save(self, path: FilePath) -> None:
        p = self.problem
        stepper, account, bs = p.stepper, p.stepper.account, p.space.dofmap.index_map_bs
        values = {name: getattr(stepper.motion, name) for name in MOTION}
        values |= {f"force {name}": getattr(account.forces, name) for name in FORCES}
        values["start"] = p._cpp_object.start_displacement
        arrays = {name: v.reshape(-1, bs) for name, v in values.items()}
        nodal: dict[str, tuple[IntArray, FloatArray]] = {}
        facets: dict[str, tuple[IntArray, FloatArray]] = {}
        totals: dict[str, FloatArray] = {}
        for k, contact in enumerate(p.contact):
            saved = contact.save_history()
            (facets if saved.on_facets else nodal)[f"contact{k}"] = (saved.keys, saved.table())
            totals[f"contact{k}"] = saved.flat_totals()
            if saved.corners is not None:
                arrays[f"corners{k}"] = saved.corners
        table, error = attempt(functions_of_time, p.functions, stepper.time, stepper.time)
        agree(self.comm, error, "functions of time")
        history = p.run_history
        control = {name: getattr(stepper.control, name, None) for name in CONTROL}
        attributes: dict[str, checkpoint.Attribute] = {
            **totals,
            "time": stepper.time, "step": stepper.step, "largest": history.largest,
            "total_start": 0.0 if history.total_start is None else history.total_start,
            "largest_displacement": p._cpp_object.largest_displacement,
            **{f"work {name}": getattr(account.works, name) for name in WORKS},
            **{f"step {name}": math.nan if value is None else value for name, value in control.items()},
            "obstacles": account.forces.obstacles.ravel(),
            "functions of time": table,
        }  # fmt: skip
        checkpoint.write(path, p, arrays, nodal, self._material_history(), {}, attributes, facets)
        self._forget()

    def _restore(self, path: FilePath) -> None:
        p = self.problem
        bs = p.space.dofmap.index_map_bs
        known = [contact.save_history() for contact in p.contact]
        names = {f"contact{k}": saved for k, saved in enumerate(known)}
        vectors = [*MOTION, *(f"force {name}" for name in FORCES), "start"]
        file = checkpoint.Reader(
            path,
            p,
            arrays={name: bs for name in vectors}
            | {f"corners{k}": 1 for k, saved in enumerate(known) if saved.corners is not None},
            nodal={name: saved.width() for name, saved in names.items() if not saved.on_facets},
            cellwise={name: values.shape[1] for name, values in self._material_history().items()},
            ranks={},
            attributes=[
                *NUMBERS,
                *(f"work {name}" for name in WORKS),
                *(f"step {name}" for name in CONTROL),
                "obstacles",
                "functions of time",
                *names,
            ],
            facets={name: saved.width() for name, saved in names.items() if saved.on_facets},
        )
        self._check_supports(path, file)
        rows = [
            file.at_facets(name, saved.keys) if saved.on_facets else file.all_at(name, saved.keys)
            for name, saved in names.items()
        ]
        _, error = attempt(self._check, path, file)
        agree(self.comm, error, "restore")
        self._apply(file, known, rows)

    def _check(self, path: FilePath, file: checkpoint.Reader) -> None:
        """Raise ValueError unless the attributes are those of a run of this problem."""
        p, a = self.problem, file.attributes

        def want(right: bool | np.bool_, what: str) -> None:
            if not right:
                raise ValueError(f"{path} is of no run: {what}")

        for name in (*NUMBERS, *(f"work {w}" for w in WORKS), *(f"step {c}" for c in CONTROL)):
            value = a[name]
            want(np.ndim(value) == 0 and np.issubdtype(np.asarray(value).dtype, np.number), f"{name} is {value!r}")
            want(name.startswith("step ") or bool(np.isfinite(value)), f"{name} is {value!r}")
        time, step = float(a["time"]), int(a["step"])
        want(time >= 0.0 and step == a["step"] and 0 <= step < 2**53 and (step > 0) == (time > 0.0),
             f"time is {time}, step {a['step']}")  # fmt: skip
        want(a["largest"] >= 0.0 and a["largest_displacement"] >= 0.0, "largest values are negative")
        sizes = {"obstacles": 3 * len(p.contact)}
        for k, contact in enumerate(p.contact):
            sizes[f"contact{k}"] = len(contact.save_history().flat_totals())
        for name, size in sizes.items():
            values = np.asarray(a[name])
            want(values.shape == (size,) and values.dtype == float, f"{name} is {a[name]!r}")
            want(name != "obstacles" or bool(np.all(np.isfinite(values))), f"{name} is {a[name]!r}")
        self._check_functions(path, a["functions of time"], p.functions, time, time)

    def _apply(self, file: checkpoint.Reader, known: list[SavedHistory], rows: list[FloatArray]) -> None:
        """Set the problem to the state that was read. Collective."""
        p, a = self.problem, file.attributes
        arrays = {name: np.ascontiguousarray(values).ravel() for name, values in file.arrays.items()}
        cpp = p._cpp_object
        cpp.start_displacement = arrays["start"]
        p.u.x.array[: p.num_owned] = arrays["displacement"]
        p.u.x.scatter_forward()
        self._set_material_history(file.cellwise)
        stepper = p.stepper
        cpp.motion = _cpp.integrators.Motion(*(arrays[name] for name in MOTION))
        cpp.set_time(float(a["time"]), int(a["step"]))
        cpp.largest_displacement = float(a["largest_displacement"])
        control = {name: float(a[f"step {name}"]) for name in CONTROL}
        tolerance = None if math.isnan(control["tolerance"]) else control["tolerance"]
        stepper.set_control(control["length"], control["largest"], control["smallest"], control["last"], tolerance)
        for k, (contact, saved, table) in enumerate(zip(p.contact, known, rows)):
            saved.columns = saved.split(table)
            saved.totals = saved.split_totals(np.asarray(a[f"contact{k}"]))
            saved.corners = file.arrays.get(f"corners{k}")
            contact.restore_history(saved, p.u.x.array)
        cpp.account.works = _cpp.integrators.Works(*(float(a[f"work {name}"]) for name in WORKS))
        forces = (arrays[f"force {name}"] for name in FORCES)
        cpp.account.forces = _cpp.integrators.Forces(*forces, np.asarray(a["obstacles"]))
        p.run_history.resume(float(a["total_start"]), float(a["largest"]))
        p.resume()
        self._forget()

    def _forget(self) -> None:
        """Forget what a checkpoint does not have, so that a run that was saved and one that was restored go on alike,
        to the last digit: factors, start vectors, candidates of the search. Collective."""
        p = self.problem
        p.linear_solver.reset()
        p.stepper.forget()
        for contact in p.contact:
            contact.forget()
