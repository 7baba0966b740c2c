# SPDX-License-Identifier: MIT
"""Saving and restoring implicit runs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ... import _cpp
from ...common.collective import agree, attempt
from ...common.types import FilePath
from ...contact.saved_contacts import add_contacts, resume_contacts
from ...io import checkpoints
from ...io.checkpoint import Attribute
from ...io.checkpoints import Checkpoints, Place, number, refuse
from ...io.signature import functions_of_time
from ..subject import check_nodal, in_time

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

    more = ("functions of time",)

    def __init__(self, problem: NewmarkProblem) -> None:
        super().__init__(in_time(problem))
        self.problem = problem

    def _recorders(self) -> Sequence[Recorder]:
        return self.problem.stepper.recorders

    def _check_kind(self, call: str) -> None:
        check_nodal(self.problem.space, call)

    def _state(self) -> _cpp.state.State:
        p = self.problem
        stepper, account, history = p.stepper, p.stepper.account, p.run_history
        bs = p.space.dofmap.index_map_bs
        out = checkpoints.State("implicit problem")
        vectors = {name: getattr(stepper.motion, name) for name in MOTION}
        vectors |= {f"force {name}": getattr(account.forces, name) for name in FORCES}
        vectors["start"] = p._cpp_object.start_displacement
        for name, values in vectors.items():
            out.add(name, Place.node, np.ascontiguousarray(values).reshape(-1, bs))
        checkpoints.add_history(out, p)
        control = {name: getattr(stepper.control, name, None) for name in CONTROL}
        checkpoints.add_numbers(
            out, time=stepper.time, step=stepper.step, largest=history.largest,
            total_start=0.0 if history.total_start is None else history.total_start,
            largest_displacement=p._cpp_object.largest_displacement,
            **{f"work {name}": getattr(account.works, name) for name in WORKS},
            **{f"step {name}": math.nan if value is None else value for name, value in control.items()},
        )  # fmt: skip
        out.add("obstacles", Place.all, np.ascontiguousarray(account.forces.obstacles).ravel())
        add_contacts(out, p.contact)
        return out

    def _attributes(self) -> dict[str, Attribute]:
        p = self.problem
        table, error = attempt(functions_of_time, p.functions, p.stepper.time, p.stepper.time)
        agree(self.comm, error, "functions of time")
        return {"functions of time": table}

    def _check(self, path: FilePath, saved: _cpp.state.State, attributes: Mapping[str, Any]) -> None:
        for name in (*NUMBERS, *(f"work {w}" for w in WORKS)):
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
        p, stepper = self.problem, self.problem.stepper
        cpp = p._cpp_object
        cpp.start_displacement = saved.array("start").flatten()
        p.u.x.array[: p.num_owned] = saved.array("displacement").ravel()
        p.u.x.scatter_forward()
        checkpoints.set_history(saved, p)
        cpp.motion = _cpp.integrators.Motion(*(saved.array(name).flatten() for name in MOTION))
        cpp.set_time(number(saved, "time"), int(number(saved, "step")))
        cpp.largest_displacement = number(saved, "largest_displacement")
        control = {name: number(saved, f"step {name}") for name in CONTROL}
        tolerance = None if math.isnan(control["tolerance"]) else control["tolerance"]
        stepper.set_control(control["length"], control["largest"], control["smallest"], control["last"], tolerance)
        resume_contacts(saved, p.contact, p.u.x.array)
        cpp.account.works = _cpp.integrators.Works(*(number(saved, f"work {name}") for name in WORKS))
        forces = (saved.array(f"force {name}").flatten() for name in FORCES)
        cpp.account.forces = _cpp.integrators.Forces(*forces, saved.array("obstacles").copy())
        p.run_history.resume(number(saved, "total_start"), number(saved, "largest"))
        p.resume()

    def _forget(self) -> None:
        """Factors, start vectors, candidates of the search."""
        p = self.problem
        p.linear_solver.reset()
        p.stepper.forget()
        for contact in p.contact:
            contact.forget()
