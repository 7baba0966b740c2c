# SPDX-License-Identifier: MIT
"""Time stepping of an implicit problem: one step after the other, repeated with half the length where one fails."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from dolfinx import fem
from mpi4py import MPI

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
from ..progress import StepProgress
from ..read_once import ReadOnce
from ..step_schedule import StepSchedule

if TYPE_CHECKING:
    from ..recorder import Recorder

MOST_STEPS = 10**8  # in one call


@dataclass(frozen=True)
class StepLimits:
    """Lengths of steps and tolerances of an `advance`, checked.

    Attributes:
        dt: largest step [T].
        tolerance: local error of a step's displacement, or None [1].
        smallest: smallest step [T].
        rtol: relative tolerance of the residual [1].
        atol: absolute tolerance of the residual [F].
        max_iterations: largest number of Newton iterations per step [1].
    """

    dt: float
    tolerance: float | None
    smallest: float
    rtol: float
    atol: float
    max_iterations: int


class ImplicitStepper(Described):
    """Callbacks, recorders and display around the steps that an implicit problem takes in C++; see
    cpp/dolfinx_impact/integrators/newmark/ImplicitStepper.h.

    Args:
        problem: the problem (C++).
        comm: communicator of the mesh.
        u: displacement at the present time [L].
        velocity: velocity at the present time [L/T].
        material: material of the bodies, which may not know large rotations; None for a residual of a user's own.
        inputs: constants and functions that residual and loads read.
        read: values of supports and rigid masters that the problem goes on with.
        evaluates: whether a function of the user sets what the residual reads, at every displacement.

    Attributes:
        calls: calls of `advance`.
        recorders: Recorders that write during the run.
    """

    def __init__(
        self,
        problem: _cpp.problems.NewmarkProblem,
        comm: MPI.Intracomm,
        u: fem.Function,
        velocity: fem.Function,
        material: _Material | MaterialMap | None,
        inputs: Inputs,
        read: ReadOnce,
        evaluates: bool,
    ) -> None:
        self._problem, self._cpp_object = problem, problem.stepper
        self.comm, self.u, self.velocity = comm, u, velocity
        self.inputs, self.read, self._evaluates = inputs, read, evaluates
        self.recorders: list[Recorder] = []
        self.calls = AdvanceCalls()
        self._rotation_warning = RotationWarning(material)
        self._warned = False  # of values that came late
        self._in_step = False  # whether C++ takes a step: it has not been accepted
        self._before = 0.0  # time at its start [T]

    @property
    def motion(self) -> _cpp.integrators.Motion:
        """Motion at the present time (C++): displacement [L], velocity [L/T], acceleration and mean [L/T^2]."""
        return self._cpp_object.motion

    @property
    def energy_balance(self) -> _cpp.integrators.ImplicitEnergyBalance:
        """Forces at the present time, and works so far (C++)."""
        return self._cpp_object.energy_balance

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

    def advance(
        self,
        until: float,
        limits: StepLimits,
        callback: Callable[[], object] | None,
        callback_every: int,
        update: Callable[[float], object] | None,
        table: Callable[[FloatArray], FloatArray],
        started: Callable[[], None],
        accepted: Callable[[], float],
        progress: bool,
        verbose: bool,
    ) -> None:
        """Advance to a time; the arguments must have been checked. Collective.

        Args:
            until: time to advance to [T].
            limits: lengths of steps and tolerances.
            callback: function that is called after each step, or some of them; None: there is none.
            callback_every: steps between its calls, which come after steps with multiples of it [1].
            update: function that sets values for a time, or None.
            table: function that samples all functions of time.
            started: function that is called when accelerations of the start were computed anew.
            accepted: function that is called when a step is in the history, and returns the drift of the energy [1].
            progress: whether a progress bar is shown.
            verbose: whether iterations are printed on the terminal.

        Raises:
            KeyboardInterrupt: a rank was interrupted.
            RuntimeError: a step did not converge; the problem is in its last converged state.
        """
        log = StepLog(self.comm, verbose)
        known, length = self._problem.control, limits.dt
        if known is not None and (known.largest, known.tolerance) == (limits.dt, limits.tolerance):
            length = known.length
        expected = max(1, math.ceil((until - self._cpp_object.time) / length))
        schedule = StepSchedule(self._cpp_object.time, until, self._cpp_object.step, self._cpp_object.step + expected)
        with (
            self.calls.running(),
            Interrupts(self.comm) as interrupts,
            StepProgress(self.comm, schedule, progress) as bar,
        ):

            def iteration(i: int, norm: float, scale: float, size: int, changes: int) -> None:
                log.iteration(i, norm, scale, size, changes)
                interrupts.check()

            def begins() -> None:
                if callback and self._cpp_object.step == 0:
                    interrupts.check(self._called(callback))

            def goal() -> float:
                self._before, self._in_step = self._cpp_object.time, True
                self.inputs.store()
                return min([until, *(r.next_time for r in self.recorders if r.next_time > self._cpp_object.time)])

            def after_step() -> None:
                self._in_step = False
                if self._evaluates:
                    self.inputs.store()
                drift = accepted()
                for recorder in self.recorders:
                    recorder.after()
                due = callback if self._cpp_object.step % callback_every == 0 else None
                error = self._called(due) if due else None
                # Where a filter makes an error of the warning, it is that of one rank.
                error = error or attempt(self._warn_of_late_values, due is not None)[1]
                bar.show_step(self._cpp_object.step, self._cpp_object.time, self._cpp_object.time - self._before, drift)
                interrupts.check(error)

            try:
                self._problem.advance(
                    until, limits.dt, limits.tolerance, limits.smallest, limits.rtol, limits.atol,
                    limits.max_iterations, log=log, progress=log.progress.show, iteration=iteration,
                    update=None if update is None else lambda time: self.update(update, time),
                    started=started, begins=begins, goal=goal, accepted=after_step, table=table,
                )  # fmt: skip
            except BaseException as raised:
                if self._in_step and is_common(self.comm, raised):
                    self._cpp_object.update_gaps()
                raise
            finally:
                self._in_step = False
            interrupts.check()
        self._rotation_warning.look(self.u, stacklevel=4)

    def _called(self, function: Callable[..., object], *given: object) -> BaseException | None:
        """Call a user's function, which must not write to the motion.

        Returns:
            Exception on this rank, or None.
        """
        error = attempt(function, *given)[1]
        return error or attempt(self._check_not_written)[1]

    def _check_not_written(self) -> None:
        motion = self.motion
        n = len(motion.displacement)
        same = []
        for f, values in ((self.u, motion.displacement), (self.velocity, motion.velocity)):
            shown = f.x.array[:n]
            same.append(bool(np.array_equal(shown, values)))
            shown[:] = values
        check_not_written(*same)
        self.read.check()

    def update(self, update: Callable[[float], object], time: float) -> None:
        """Let a user set the values of a time; an error on one rank is raised on all. Collective.

        Args:
            update: function of time.
            time: time [T].
        """
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
                "the callback has changed what residual or loads read, at the time "
                f"{self._cpp_object.time:.6g}: it acts in the step that ends later. Values that are functions of time "
                "come a step late so; set them in advance(..., update=function of problem and time)",
                stacklevel=6,
            )
