# SPDX-License-Identifier: MIT
"""Saving and restoring implicit runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from dolfinx import fem

from ... import _cpp
from ...common.collective import agree, attempt
from ...common.types import FilePath
from ...contact.saved_contacts import add_contacts, resume_contacts
from ...io import checkpoints
from ...io.checkpoint import Attribute, Subject
from ...io.checkpoints import Checkpoints, Place, number, refuse
from ...io.signature import functions_of_time
from ..functions_of_time import FunctionsOfTime
from ..run_history import RunHistory
from ..subject import check_nodal
from .stepper import ImplicitStepper

if TYPE_CHECKING:
    from ...contact.mortar.lagrange import LagrangeContact
    from ...contact.penalty.quadrature_penalty import QuadraturePenalty
    from ..recorder import Recorder

MOTION = ("displacement", "velocity", "acceleration", "mean")
FORCES = ("internal", "external", "damping", "support")
WORKS = ("internal", "external", "damping")
CONTROL = ("length", "largest", "smallest", "last", "tolerance")  # of steps; not a number where there is none
NUMBERS = ("time", "step", "largest", "total_start", "largest_displacement")


class ImplicitRestart(Checkpoints):
    """Saves and restores an implicit problem; see NewmarkProblem.save and restore.

    Args:
        subject: the problem as checkpoints see it.
        u: displacement at the present time [L].
        stepper: time stepping.
        contacts: contacts.
        functions: functions of time.
        run_history: energies and contact forces of all steps.
        bodies: who has the internal variables of the bodies, if there are any.
        resumed: function that computes what follows from a restored state.
    """

    more = ("functions of time",)

    def __init__(
        self,
        subject: Subject,
        u: fem.Function,
        stepper: ImplicitStepper,
        contacts: Sequence[LagrangeContact | QuadraturePenalty],
        functions: FunctionsOfTime,
        run_history: RunHistory,
        bodies: checkpoints.HasHistory,
        resumed: Callable[[], None],
    ) -> None:
        super().__init__(subject)
        self.u, self.stepper, self.contacts, self.functions = u, stepper, contacts, functions
        self.run_history, self.bodies, self._resumed = run_history, bodies, resumed

    def _recorders(self) -> Sequence[Recorder]:
        return self.stepper.recorders

    def _check_kind(self, call: str) -> None:
        check_nodal(self.u.function_space, call)

    def _state(self) -> _cpp.state.State:
        stepper, account, history = self.stepper, self.stepper.account, self.run_history
        bs = self.u.function_space.dofmap.index_map_bs
        out = checkpoints.State("implicit problem")
        vectors = {name: getattr(stepper.motion, name) for name in MOTION}
        vectors |= {f"force {name}": getattr(account.forces, name) for name in FORCES}
        vectors["start"] = stepper._cpp_object.start_displacement
        for name, values in vectors.items():
            out.add(name, Place.node, np.ascontiguousarray(values).reshape(-1, bs))
        checkpoints.add_history(out, self.bodies)
        control = {name: getattr(stepper.control, name, None) for name in CONTROL}
        checkpoints.add_numbers(
            out, time=stepper.time, step=stepper.step, largest=history.largest,
            total_start=0.0 if history.total_start is None else history.total_start,
            largest_displacement=stepper._cpp_object.largest_displacement,
            **{f"work {name}": getattr(account.works, name) for name in WORKS},
            **{f"step {name}": math.nan if value is None else value for name, value in control.items()},
        )  # fmt: skip
        out.add("obstacles", Place.all, np.ascontiguousarray(account.forces.obstacles).ravel())
        add_contacts(out, self.contacts)
        return out

    def _attributes(self) -> dict[str, Attribute]:
        table, error = attempt(functions_of_time, self.functions, self.stepper.time, self.stepper.time)
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
        checkpoints.check_functions(path, attributes["functions of time"], self.functions, time, time)

    def _apply(self, saved: _cpp.state.State, attributes: Mapping[str, Any], checked: Any) -> None:
        stepper, u = self.stepper, self.u.x
        cpp = stepper._cpp_object
        cpp.start_displacement = saved.array("start").flatten()
        displacement = saved.array("displacement").ravel()
        u.array[: len(displacement)] = displacement
        u.scatter_forward()
        checkpoints.set_history(saved, self.bodies)
        cpp.motion = _cpp.integrators.Motion(*(saved.array(name).flatten() for name in MOTION))
        cpp.set_time(number(saved, "time"), int(number(saved, "step")))
        cpp.largest_displacement = number(saved, "largest_displacement")
        control = {name: number(saved, f"step {name}") for name in CONTROL}
        tolerance = None if math.isnan(control["tolerance"]) else control["tolerance"]
        stepper.set_control(control["length"], control["largest"], control["smallest"], control["last"], tolerance)
        resume_contacts(saved, self.contacts, u.array)
        cpp.account.works = _cpp.integrators.Works(*(number(saved, f"work {name}") for name in WORKS))
        forces = (saved.array(f"force {name}").flatten() for name in FORCES)
        cpp.account.forces = _cpp.integrators.Forces(*forces, saved.array("obstacles").copy())
        self.run_history.resume(number(saved, "total_start"), number(saved, "largest"))
        self._resumed()

    def _forget(self) -> None:
        """Factors, start vectors, candidates of the search."""
        self.stepper.equations.linear_solver.reset()
        self.stepper.forget()
        for contact in self.contacts:
            contact.forget()
