# SPDX-License-Identifier: MIT
"""Time stepping of an implicit problem: one step after the other, repeated with half the length where one fails."""

from __future__ import annotations

import logging
import math
import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from dolfinx import fem, la

from ... import _cpp
from ...assembly.large_rotation import RotationWarning
from ...assembly.operators import Inputs
from ...common.collective import agree, attempt, is_common
from ...common.described import Described
from ...common.interrupts import Interrupts
from ...common.types import FloatArray
from ...materials import MaterialMap, _Material
from ...statics.load_steps import StepLog
from ..advance_calls import AdvanceCalls, check_not_written
from ..progress import ProgressBar
from ..read_once import ReadOnce
from ..run_history import ENERGIES
from ..step_schedule import StepSchedule
from .excitation import Excitation
from .step_equations import StepEquations

if TYPE_CHECKING:
    from ..recorder import Recorder

LOG = logging.getLogger("dolfinx_impact")
MOST_STEPS = 10**8  # in one call


class ImplicitStepper(Described):
    """Steps an implicit problem in time: callbacks, recorders and display around the steps that C++ takes; see
    cpp/dolfinx_impact/integrators/newmark/ImplicitStepper.h.

    Args:
        equations: equations of a step.
        body: bodies with inertia (C++).
        scheme: parameters of the scheme (C++).
        excitation: loads, supports and rigid masters at a time.
        mass: lumped mass of the bodies, by which errors are weighted [M].
        velocity: velocity at the present time [L/T].
        acceleration: acceleration at the present time [L/T^2].
        material: material of the bodies, which may not know large rotations; None for a residual of a user's own.
        inputs: constants and functions that residual and loads read.
        read: values of supports and rigid masters that the problem goes on with.
        evaluates: whether a function of the user sets what the residual reads, at every displacement.

    Attributes:
        control: lengths of steps (C++); None before the first `advance`.
        calls: calls of `advance`.
        recorders: Recorders that write during the run.
    """

    def __init__(
        self,
        equations: StepEquations,
        body: Any,
        scheme: _cpp.integrators.ImplicitScheme,
        excitation: Excitation,
        mass: la.Vector,
        velocity: fem.Function,
        acceleration: fem.Function,
        material: _Material | MaterialMap | None,
        inputs: Inputs,
        read: ReadOnce,
        evaluates: bool,
    ) -> None:
        self.equations, self.comm, self.u, self.velocity = equations, equations.space.mesh.comm, equations.u, velocity
        self.inputs, self.read, self._evaluates = inputs, read, evaluates
        self._cpp_object = _cpp.integrators.ImplicitStepper(
            equations.equilibrium, body, scheme, _cpp.integrators.PythonExcitation(excitation),
            mass.array[: equations.num_owned], velocity._cpp_object, acceleration._cpp_object,
        )  # fmt: skip
        self.control: Any = None
        self.recorders: list[Recorder] = []
        self.calls = AdvanceCalls()
        self._rotation_warning = RotationWarning(material)
        self._solver: _cpp.solve.IncrementSolver | None = None  # of the present `advance`
        self._log: StepLog | None = None  # of it
        self._warned = False  # of values that came late

    @property
    def time(self) -> float:
        """Present time [T]."""
        return float(self._cpp_object.time)

    @property
    def step(self) -> int:
        """Number of the present step [1]."""
        return int(self._cpp_object.step)

    @property
    def motion(self) -> Any:
        """Motion at the present time (C++): displacement [L], velocity [L/T], acceleration and mean [L/T^2]."""
        return self._cpp_object.motion

    @property
    def account(self) -> Any:
        """Forces at the present time, and works so far (C++)."""
        return self._cpp_object.account

    @property
    def iterations(self) -> int:
        """Newton iterations of the last step [1]."""
        return int(self._cpp_object.iterations)

    @property
    def cut_backs(self) -> int:
        """Number of steps so far that were repeated with half the length [1]."""
        return int(self._cpp_object.cut_backs)

    @property
    def rejected(self) -> int:
        """Number of steps so far that were repeated because of their error [1]."""
        return int(self._cpp_object.rejected)

    def energies(self) -> dict[str, float]:
        """Energies at the present time by the names of ENERGIES [F L]. Collective."""
        return dict(zip(ENERGIES, self._cpp_object.energies().tolist()))

    def set_control(self, length: float, largest: float, smallest: float, last: float, tolerance: float | None) -> None:
        """Set the lengths of steps from a checkpoint.

        Args:
            length: wanted length of the next step; not a number: there was no step [T].
            largest: largest step [T].
            smallest: smallest step [T].
            last: length of the last step [T].
            tolerance: local error, or None [1].
        """
        new = None if math.isnan(length) else _cpp.integrators.StepControl(largest, smallest, tolerance, length, last)
        self.control = new

    def forget(self) -> None:
        """Forget what the solver of the present `advance` keeps from one step to the next. Collective."""
        if self._solver is not None:
            self._solver.forget()

    def advance(
        self,
        until: float,
        control: Any,
        solver_arguments: dict[str, Any],
        callback: Callable[[], object] | None,
        update: Callable[[float], object] | None,
        accepted: Callable[[], float],
        progress: bool,
        verbose: bool,
    ) -> None:
        """Advance to a time; the arguments must have been checked. Collective.

        Args:
            until: time to advance to [T].
            control: lengths of steps, StepControl (C++).
            solver_arguments: tolerances and limits of Newton's method by the names of IncrementSolver (C++).
            callback: function that is called after each step, or None.
            update: function that sets values for a time, or None.
            accepted: function that takes a step over into the histories, and returns the drift of the energy [1].
            progress: whether a progress bar is shown.
            verbose: whether iterations are printed on the terminal.

        Raises:
            KeyboardInterrupt: a rank was interrupted.
            RuntimeError: a step did not converge; the problem is in its last converged state.
        """
        self.control = control
        log = StepLog(self.comm, verbose)
        with self.calls.running(), Interrupts(self.comm) as interrupts:

            def iteration(i: int, norm: float, scale: float, size: int, changes: int) -> None:
                log.iteration(i, norm, scale, size, changes)
                interrupts.check()

            self._log, self._solver = log, _cpp.solve.IncrementSolver(
                self.equations.equilibrium, log=log, progress=log.progress.show, iteration=iteration, **solver_arguments
            )
            try:
                self._advance(until, control, callback, update, accepted, progress, interrupts)
                self._solver.free()
            finally:
                self._solver.tell_nobody()
                self._solver = self._log = None
            interrupts.check()

    def _advance(
        self,
        until: float,
        control: Any,
        callback: Callable[[], object] | None,
        update: Callable[[float], object] | None,
        accepted: Callable[[], float],
        progress: bool,
        interrupts: Interrupts,
    ) -> None:
        if callback and self.step == 0:
            interrupts.check(self._called(callback))
        expected = max(1, math.ceil((until - self.time) / control.length))
        schedule = StepSchedule(self.time, until, self.step, self.step + expected)
        with ProgressBar(self.comm, schedule, progress) as bar:
            while self.time < until:
                goal = min([until, *(r.next_time for r in self.recorders if r.next_time > self.time)])
                before = self.time
                self._take(goal, control, update)
                drift = accepted()
                for recorder in self.recorders:
                    recorder.after()
                error = self._called(callback) if callback else None
                # Where a filter makes an error of the warning, it is that of one rank.
                error = error or attempt(self._warn_of_late_values, callback is not None)[1]
                bar.show(self.step, self.time, self.time - before, drift)
                interrupts.check(error)
        self._rotation_warning.look(self.u, stacklevel=4)

    def _take(self, goal: float, control: Any, update: Callable[[float], object] | None) -> None:
        """Take one step on the way to a time. Collective.

        Raises:
            RuntimeError: it did not converge.
        """
        assert self._log is not None  # inside `advance`
        try:
            self._cpp_object.take_step(goal, control, self._solve, self._log, lambda time: self.update(update, time))
        except BaseException as raised:
            if is_common(self.comm, raised):
                self._cpp_object.update_gaps()
            raise
        if self._evaluates:
            self.inputs.store()

    def _solve(self, target: FloatArray) -> _cpp.solve.Increment:
        """Solve the equations of one step. Collective.

        Args:
            target: displacements, owned and ghosts, of which prescribed entries are read [L].

        Returns:
            Increment; its `fault` says why it did not converge.
        """
        assert self._solver is not None  # inside `advance`
        return self._solver.run(target)

    def _called(self, function: Callable[..., object], *given: object) -> BaseException | None:
        """Call a user's function, which must not write to the motion.

        Returns:
            Exception on this rank, or None.
        """
        error = attempt(function, *given)[1]
        return error or attempt(self._check_not_written)[1]

    def _check_not_written(self) -> None:
        n, motion = self.equations.num_owned, self.motion
        same = []
        for f, values in ((self.u, motion.displacement), (self.velocity, motion.velocity)):
            shown = f.x.array[:n]
            same.append(bool(np.array_equal(shown, values)))
            shown[:] = values
        check_not_written(*same)
        self.read.check()

    def update(self, update: Callable[[float], object] | None, time: float) -> None:
        """Let a user set the values of a time; an error on one rank is raised on all. Collective.

        Args:
            update: function of time, or None.
            time: time [T].
        """
        if update is not None:
            agree(self.comm, self._called(update, time), "update")
        self.inputs.store()

    def _warn_of_late_values(self, called: bool) -> None:
        """Warn, once and on rank 0, of values that a callback has set for the present time.

        Args:
            called: whether there is a callback.
        """
        if called and self.comm.rank == 0 and not self._warned and self.inputs.changed():
            self._warned = True
            warnings.warn(
                f"the callback has changed what residual or loads read, at the time {self.time:.6g}: it acts in the "
                "step that ends later. Values that are functions of time come a step late so; set them in "
                "advance(..., update=function of problem and time)",
                stacklevel=6,
            )
