# SPDX-License-Identifier: MIT
"""Time stepping of an implicit problem: one step after the other, repeated with half the length where one fails."""

from __future__ import annotations

import logging
import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ... import _cpp
from ...assembly.large_rotation import RotationWarning
from ...common.collective import agree, attempt, is_common
from ...common.described import Described
from ...common.interrupts import Interrupts
from ...common.types import FloatArray
from ...statics.load_steps import StepLog
from ...statics.snes import Solver
from ..advance_calls import AdvanceCalls, check_not_written
from ..progress import ProgressBar
from ..step_schedule import StepSchedule
from .motion import Prescribed, State, StepMotion, TimeValues
from .step_control import StepControl

if TYPE_CHECKING:
    from ..recorder import Recorder
    from .problem import NewmarkProblem

LOG = logging.getLogger("dolfinx_impact")
DIFFERENCE = 0.01  # of a step: half the distance at which functions of time are differentiated
MOST_STEPS = 10**8  # in one call


@dataclass
class Before:
    """State of this rank before a step, ghosts included.

    Attributes:
        displacement: displacement [L].
        contacts: states of the contacts.
        motion: velocity [L/T] and acceleration [L/T^2].
    """

    displacement: FloatArray
    contacts: list[dict[str, Any]]
    motion: tuple[FloatArray, FloatArray]


class ImplicitStepper(Described):
    """Steps an implicit problem in time.

    Args:
        problem: NewmarkProblem.

    Attributes:
        time: present time [T].
        step: number of the present step [1].
        state: motion at the present time; the problem sets that at the start.
        control: lengths of steps; None before the first `advance`.
        calls: calls of `advance`.
        recorders: Recorders that write during the run.
        iterations: Newton iterations of the last step [1].
        cut_backs: number of steps so far that were repeated with half the length [1].
        rejected: number of steps so far that were repeated because of their error [1].
    """

    state: State
    time: float
    step: int
    largest_displacement: float

    def __init__(self, problem: NewmarkProblem) -> None:
        self.problem, self.comm = problem, problem.comm
        self.time, self.step = 0.0, 0
        self.control: StepControl | None = None
        self.recorders: list[Recorder] = []
        self.iterations, self.cut_backs, self.rejected = 0, 0, 0
        self.largest_displacement = 0.0
        self.calls = AdvanceCalls()
        self._rotation_warning = RotationWarning(problem.material)
        self._solver: Solver | None = None  # of the present `advance`
        self._warned = False  # of values that came late

    def set_control(self, length: float, largest: float, smallest: float, last: float, tolerance: float | None) -> None:
        """Set the lengths of steps from a checkpoint.

        Args:
            length: wanted length of the next step; not a number: there was no step [T].
            largest: largest step [T].
            smallest: smallest step [T].
            last: length of the last step [T].
            tolerance: local error, or None [1].
        """
        self.control = None if math.isnan(length) else StepControl(largest, smallest, tolerance, length, last)

    def forget(self) -> None:
        """Forget what the solver of the present `advance` keeps from one step to the next. Collective."""
        if self._solver is not None:
            self._solver.forget()

    def advance(
        self,
        until: float,
        control: StepControl,
        solver_arguments: dict[str, Any],
        callback: Callable[[NewmarkProblem], object] | None,
        update: Callable[[NewmarkProblem, float], object] | None,
        progress: bool,
        verbose: bool,
    ) -> None:
        """Advance to a time; the arguments must have been checked. Collective.

        Args:
            until: time to advance to [T].
            control: lengths of steps.
            solver_arguments: tolerances and limits of Newton's method by the names of statics.snes.Solver.
            callback: function that is called after each step, or None.
            update: function that sets values for a time, or None.
            progress: whether a progress bar is shown.
            verbose: whether iterations are printed on the terminal.

        Raises:
            KeyboardInterrupt: a rank was interrupted.
            RuntimeError: a step did not converge; the problem is in its last converged state.
        """
        self.control = control
        log = StepLog(self.comm, verbose)
        with self.calls.running(), Interrupts(self.comm) as interrupts:
            with Solver(self.problem.equations, interrupts=interrupts, **solver_arguments) as solver:
                self._solver = solver
                try:
                    self._advance(until, control, solver, callback, update, progress, log, interrupts)
                finally:
                    self._solver = None
            interrupts.check()

    def _advance(
        self,
        until: float,
        control: StepControl,
        solver: Solver,
        callback: Callable[[NewmarkProblem], object] | None,
        update: Callable[[NewmarkProblem, float], object] | None,
        progress: bool,
        log: StepLog,
        interrupts: Interrupts,
    ) -> None:
        if callback and self.step == 0:
            interrupts.check(self._called(callback, self.problem))
        expected = max(1, math.ceil((until - self.time) / control.length))
        schedule = StepSchedule(self.time, until, self.step, self.step + expected)
        with ProgressBar(self.comm, schedule, progress) as bar:
            while self.time < until:
                goal = min([until, *(r.next_time for r in self.recorders if r.next_time > self.time)])
                step, end = control.next(self.time, goal)
                self._take(step, end, control, solver, log, update)
                for recorder in self.recorders:
                    recorder.after()
                error = self._called(callback, self.problem) if callback else None
                # Where a filter makes an error of the warning, it is that of one rank.
                error = error or attempt(self._warn_of_late_values, callback is not None)[1]
                history = self.problem.run_history
                assert history.last is not None  # the step has added its row
                bar.show(self.step, self.time, step, history.drift(history.last))
                interrupts.check(error)
        self._rotation_warning.look(self.problem.u, stacklevel=4)

    def _take(
        self,
        step: float,
        end: float,
        control: StepControl,
        solver: Solver,
        log: StepLog,
        update: Callable[[NewmarkProblem, float], object] | None,
    ) -> None:
        """Take one step; the control decides about its repetition. Collective.

        Raises:
            RuntimeError: it did not converge.
        """
        log(f"step {self.step + 1}: to the time {end:.6g}, length {step:.3e}")
        p, u = self.problem, self.problem.u.x
        # What others wrote into the displacement function since the last step does not count.
        u.array[: p.num_owned] = self.state.displacement
        u.scatter_forward()
        before = Before(u.array.copy(), [c.state().copy() for c in p.contact], p.motion.save())
        error: float | None = None
        self.update(update, end)
        values = self.sample(step, end)
        try:
            increment, motion = self._attempt(step, values, solver, log)
            if not increment.fault:
                overlaps = [text for text in [c.prescribed_overlap() for c in p.contact] if text]
                if overlaps:
                    increment.failed("; ".join(overlaps), hopeless=True)
        except BaseException as raised:  # Ctrl-C, a user's function: return to the last converged state
            self._back(before)
            if is_common(self.comm, raised):
                self._update_gaps(before)
            raise
        self.iterations = increment.iterations
        if not increment.fault:
            state = motion.end(u.array[: p.num_owned])
            error = self._error(state, step)
            if control.accepts(step, error):
                self._accept(state, values, step, control, error)
                return
            self.rejected += 1
            log(f"  the local error is {error:.1e}: repeated with a step of {control.length:.3e}")
            self._back(before)
            self._update_gaps(before)
            return self._again(end, control, solver, log, update)
        self._back(before)
        self._update_gaps(before)
        if increment.hopeless:
            self.update(update, self.time)
            raise RuntimeError(f"{increment.fault} (at the time {end:.6g})")
        if not control.failed(step):
            self.update(update, self.time)
            raise RuntimeError(
                f"{increment.fault} in the step to the time {end:.6g}, of length {step:.3e}; the problem is at the "
                f"time {self.time:.6g}. Take a smaller step, or pass more iterations"
            )
        self.cut_backs += 1
        log(f"  cut back to a step of {control.length:.3e}: {increment.fault}")
        self._again(end, control, solver, log, update)

    def _again(
        self,
        goal: float,
        control: StepControl,
        solver: Solver,
        log: StepLog,
        update: Callable[[NewmarkProblem, float], object] | None,
    ) -> None:
        """Take a shorter step on the way to the end of one that was given up. Collective."""
        step, end = control.next(self.time, goal)
        self._take(step, end, control, solver, log, update)

    def _called(self, function: Callable[..., object], *given: object) -> BaseException | None:
        """Call a user's function, which must not write to the motion.

        Returns:
            Exception on this rank, or None.
        """
        error = attempt(function, *given)[1]
        return error or attempt(self._check_not_written)[1]

    def _check_not_written(self) -> None:
        shown = self.problem.u.x.array[: self.problem.num_owned]
        u, v = np.array_equal(shown, self.state.displacement), self.problem.motion.shows_velocity(self.state)
        shown[:] = self.state.displacement
        check_not_written(u, v)
        self.problem.read.check()

    def update(self, update: Callable[[NewmarkProblem, float], object] | None, time: float) -> None:
        """Let a user set the values of a time; an error on one rank is raised on all. Collective.

        Args:
            update: function of problem and time, or None.
            time: time [T].
        """
        if update is not None:
            agree(self.comm, self._called(update, self.problem, time), "update")
        self.problem.inputs.store()

    def _warn_of_late_values(self, called: bool) -> None:
        """Warn, once and on rank 0, of values that a callback has set for the present time.

        Args:
            called: whether there is a callback.
        """
        if called and self.comm.rank == 0 and not self._warned and self.problem.inputs.changed():
            self._warned = True
            warnings.warn(
                f"the callback has changed what residual or loads read, at the time {self.time:.6g}: it acts in the "
                "step that ends later. Values that are functions of time come a step late so; set them in "
                "advance(..., update=function of problem and time)",
                stacklevel=6,
            )

    def sample(self, step: float | None, time: float) -> TimeValues:
        """Sample all functions of time; an error on one rank is raised on all. Collective.

        Args:
            step: length of the step that ends or begins then; None: not known, velocities and accelerations are not
                computed [T].
            time: time [T].

        Returns:
            What they prescribe.
        """
        p = self.problem

        def values() -> TimeValues:
            factors, places = p.loads_in_time.factors(time), p.obstacles.places(time)
            return TimeValues(time, self.prescribed(step, time), factors, places)

        found, error = attempt(values)
        agree(self.comm, error, "functions of time")
        return found

    def _attempt(
        self, step: float, values: TimeValues, solver: Solver, log: StepLog
    ) -> tuple[_cpp.solve.Increment, StepMotion]:
        """Solve the equations of one step. Collective."""
        p, prescribed = self.problem, values.prescribed
        motion = StepMotion(p.scheme, step, self.state, p.inertia.massless, prescribed)
        target = p.u.x.array.copy()
        target[: p.num_owned] = np.where(prescribed.mask, prescribed.displacement, target[: p.num_owned])
        target = p.motion.with_ghosts(target)
        with p.loads_in_time.scaled(values.factors):
            for k, contact in enumerate(p.contact):
                contact.begin_step(p.u.x.array, values.places[k] if contact.pair.rigid else None, target)
            p.moving_body.begin_step(motion)
            if not p.contact:  # bodies that may touch begin where they are: contact is searched for from there
                guess = np.where(prescribed.mask, p.u.x.array[: p.num_owned], motion.predictor())
                p.u.x.array[: p.num_owned] = guess
                p.u.x.scatter_forward()
            increment = solver.run(target, log)
        return increment, motion

    def prescribed(self, step: float | None, time: float) -> Prescribed:
        """Prescribed motion at a time; derivatives by central differences over a small part of a step.

        Args:
            step: length of the step that ends or begins then; None: not known, the derivatives are zero [T].
            time: time [T].

        Returns:
            Displacement, velocity and acceleration of the prescribed degrees of freedom.
        """
        p, small = self.problem, DIFFERENCE * (step or 0.0)
        middle = max(time, small)  # there is no time before the start
        table = p.functions.table(np.array([middle - small, middle, middle + small, time]))
        mask = np.zeros(p.num_owned, dtype=bool)
        u, v, a = np.zeros(p.num_owned), np.zeros(p.num_owned), np.zeros(p.num_owned)
        for dofs, values, column in p.supports:
            mask[dofs] = True
            u[dofs] = values
            if column >= 0:
                before, now, after, exact = table[:, column]
                u[dofs] = values * exact
                if small > 0.0:
                    v[dofs] = values * (after - before) / (2.0 * small)
                    a[dofs] = values * (after - 2.0 * now + before) / small**2
        return Prescribed(mask, u, v, a)

    def _error(self, state: State, step: float) -> float | None:
        """Estimate of the local error of the displacement, relative to the largest displacement so far [1]; None
        without a tolerance. Collective."""
        assert self.control is not None  # advance has set it
        if self.control.tolerance is None:
            return None
        p = self.problem
        change = p.scheme.error_constant * step**2 * (state.mean - self.state.mean)
        moved = state.displacement - p.start_displacement
        sizes = [self._size(values) for values in (change, moved, step * state.velocity)]
        self.largest_displacement = max(self.largest_displacement, *sizes[1:])
        return sizes[0] / self.largest_displacement if self.largest_displacement > 0.0 else 0.0

    def _size(self, values: FloatArray) -> float:
        """Root of the mass-weighted mean square. Collective."""
        mass = self.problem.inertia.total.array[: self.problem.num_owned]
        sums = self.comm.allreduce(np.array([float(mass @ values**2), float(mass.sum())]))
        return math.sqrt(sums[0] / sums[1])

    def _accept(self, state: State, values: TimeValues, step: float, control: StepControl, error: float | None) -> None:
        """Take over a converged step. Collective."""
        self.problem.accept_step(state, values)
        if self.problem.evaluates:
            self.problem.inputs.store()
        self.state, self.time, self.step = state, values.time, self.step + 1
        self.problem.add_row()
        control.done(step, self.iterations, error)
        self.problem.check_growth()

    def _back(self, before: Before) -> None:
        """Return to the state before a step that is given up. It does not communicate: an exception may have come on
        one rank alone."""
        p = self.problem
        p.u.x.array[:] = before.displacement
        for contact, state in zip(p.contact, before.contacts):
            contact.state().assign(state)
        p.motion.bring_back(before.motion)

    def _update_gaps(self, before: Before) -> None:
        """Compute the gaps of the state before a step anew. Collective."""
        for contact in self.problem.contact:
            contact.update_gap(before.displacement)
