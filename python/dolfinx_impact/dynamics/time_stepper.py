# SPDX-License-Identifier: MIT
"""Taking the steps of an explicit problem: schedules, checks of the stable step, runs that fail."""

import contextlib
import math
import warnings
import zlib
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..common.collective import agree, attempt
from ..common.interrupts import Interrupts
from ..common.arguments import number
from . import energy_gain
from .failed_run import FailedRun
from .progress import ProgressBar
from .step_schedule import StepSchedule

SAFETY = 0.9  # of the stable step that dt="auto" takes; contact stiffness needs the rest
CHUNK = 1000  # steps between which nothing but C++ runs
RECHECK = 500  # steps after which the stable step of a body that deforms is found again
SNAPSHOT = 100  # steps between states that a run that goes unstable falls back on
MOST_STEPS = 10**9  # of one call: the energies of as many steps take a hundred gigabytes


@dataclass
class GoodState:
    """A state that a run that fails goes back to: owned entries of displacement [L] and velocity [L/T]."""

    step: int
    time: float
    displacement: np.ndarray
    velocity: np.ndarray


class TimeStepper:
    """Takes steps of an explicit problem. The C++ integrator does the steps; this class decides how many, how long, and
    what happens between them.

    Args:
        problem: ExplicitProblem: its communicator, space, integrator, contacts and `stable_step`.
        functions: FunctionsOfTime of loads, supports and obstacles.
        inputs: Inputs that a user may change between steps.
        state: CurrentState that callbacks see.
        history: RunHistory of energies and contact forces.
        deforms: whether the stable step depends on the displacement or the velocity.

    Attributes:
        time: time reached [T].
        step: number of steps taken.
        next_time: time of the next step, to which functions of time are known [T].
        schedule: the steps that are left of an `advance`, or None.
        safe_step: largest stable step, when it was last found [T].
        nominal_step: longest step of the present schedule [T].
        recorders: Recorders that write while the run goes on.
    """

    def __init__(self, problem, functions, inputs, state, history, deforms: bool) -> None:
        self.problem, self.comm = problem, problem.comm
        self.functions, self.inputs, self.state, self.history = functions, inputs, state, history
        self.integrator, self.deforms = problem._cpp_object, deforms
        self.time, self.step, self.next_time = 0.0, 0, 0.0
        self.schedule: StepSchedule | None = None
        self.recorders: list = []
        self._mesh_fingerprint = self._fingerprint()
        self._good: GoodState | None = None
        self._warn_at, self._warned, self._advancing = math.inf, False, False
        self.safe_step, self._stale = problem.stable_step(), False
        self.nominal_step = SAFETY * self.safe_step

    def start(self, displacement: np.ndarray, velocity: np.ndarray) -> None:
        """Set the state at time zero and compute its forces. Collective.

        Args:
            displacement: owned entries [L].
            velocity: owned entries [L/T].
        """
        self.integrator.set_contact_step(self.nominal_step)
        self.integrator.start(displacement, velocity)
        self._run(0)
        for contact in self.problem.contact:
            contact.check_start()
        self.state.update()

    def resume(self, time, step, next_time, safe_step, nominal_step, schedule) -> None:
        """Go on from what a checkpoint tells; the integrator has been restored. Times are as the attributes.
        Collective."""
        self.time, self.step, self.next_time = time, step, next_time
        table = np.ascontiguousarray(self.functions.table(np.array([time, next_time])))
        self.integrator.run(np.zeros(0), table.ravel(), table.shape[1], np.zeros(0))
        self.safe_step, self.nominal_step, self._stale = safe_step, nominal_step, False
        self.schedule, self._good = schedule, None

    def check_arguments(self, until: float, callback: Callable | None) -> float:
        """Arguments of `advance`, on this rank.

        Returns:
            The time to reach [T].

        Raises:
            RuntimeError, TypeError, ValueError: as `ExplicitProblem.advance`.
        """
        if self._advancing:
            raise RuntimeError(
                "advance was called while it runs, by a callback: let the callback return, and call advance again after"
            )
        until = number("until", until, unit=" [T]")
        if until < self.time:
            raise ValueError(f"until is {until:g}, but the time is {self.time:g} already")
        if callback is not None and not callable(callback):
            raise TypeError(f"callback must be a function of the problem, found {type(callback).__name__}")
        if self._fingerprint() != self._mesh_fingerprint:
            raise ValueError("the mesh was changed after the problem was set up: make a new problem")
        return until

    def advance(self, until, dt, callback, progress, unsafe, energy_limits) -> None:
        """Take steps to a time; arguments have been checked. Collective."""
        self._warn_at, self.integrator.gain_limit = energy_limits
        self._advancing = True
        try:
            with Interrupts(self.comm) as interrupts:
                self._advance(until, dt, callback, progress, unsafe, interrupts)
                interrupts.check()
        finally:
            self._advancing = False

    def refresh(self) -> None:
        """Take over constants, functions and loads that were changed since the last time. Collective."""
        if self.inputs.take_changes():
            self._stale = True

    # --- the loop --------------------------------------------------------------------------------------------------

    def _advance(self, until, dt, callback, progress, unsafe, interrupts):
        self.refresh()
        if callback and self.step == 0:
            interrupts.check(self._call(callback))
        if self._stale:
            self._find_stable_step()
        self._choose_schedule(until, dt, unsafe)
        with ProgressBar(self.comm, self.schedule, progress) as bar:
            try:
                while self.step < self.schedule.last:
                    self._take_steps(until, dt, callback, unsafe, bar, interrupts)
            except BaseException:  # the same on all ranks
                self.state.update()
                self._flush_recorders()
                raise
        self.schedule = None
        self.state.update()

    def _take_steps(self, until, dt, callback, unsafe, bar, interrupts):
        """Steps between which nothing but C++ runs, then what follows them. Exceptions are those of all ranks; the
        state is that after a step. Collective."""
        if (self.deforms or self._stale) and self.step > 0 and self.step % RECHECK == 0:
            self._recheck(until, dt, unsafe)
        first = self.step == 0
        self._run(1 if callback or first else self._chunk(), interrupts)
        if first:  # kinematic contact finds gaps in steps
            for contact in self.problem.contact:
                contact.check_start()
        for recorder in self.recorders:
            recorder.after()
        error = self._call(callback) if callback else None
        interrupts.check(error or attempt(self._show, bar)[1])

    def _show(self, bar):
        last = self.history.last
        if last is not None:
            bar.show(self.step, self.time, self.schedule.dt, self.history.drift(last))

    def _call(self, callback):
        """Show the present state to a callback and take over what it has changed; its error on this rank, or None.
        Collective."""
        self.state.update()
        error = attempt(callback, self.problem)[1]
        self.refresh()
        return error

    def _chunk(self):
        rest = self.schedule.last - self.step
        waits = [recorder.steps_left() for recorder in self.recorders]
        return min(CHUNK, rest, RECHECK - self.step % RECHECK if self.deforms else rest, *waits)

    def _run(self, count, interrupts=None):
        """Take steps, fewer if a rank is interrupted. Collective."""
        steps = np.arange(self.step, self.step + count + 2)  # and one beyond
        times = self.schedule.times(steps) if self.schedule else np.full(2, self.time)
        table, error = attempt(self.functions.table, times)
        agree(self.comm, error, "functions of time")
        if self.step - (self._good.step if self._good else -SNAPSHOT) >= SNAPSHOT or count > SNAPSHOT:
            u, v, _ = self.state.motion()
            self._good = GoodState(self.step, self.time, u, v)
        rows = np.zeros(count, dtype=self.history.step_type)
        lengths = np.full(count, self.schedule.dt if count else 1.0)
        table, columns = np.ascontiguousarray(table).ravel(), table.shape[1]
        done = self.integrator.run(lengths, table, columns, rows.view(float), interrupts and interrupts.asked)
        self._keep(times[:done], rows[:done])
        if done < count and not self.integrator.stopped:
            self._fail(times[done])
        self.step, self.time, self.next_time = self.step + done, float(times[done]), float(times[done + 1])
        self._warn_of_gain()

    def _keep(self, times, steps):
        rows = self.history.add(times, steps)
        if len(rows):
            for recorder in self.recorders:
                recorder.take(rows)

    def _warn_of_gain(self):
        if self.integrator.most_gained > self._warn_at and not self._warned:
            self._warned = True
            if self.comm.rank == 0:
                text = energy_gain.told(self.integrator.most_gained)
                warnings.warn(f"the run gains energy: by the time {self.time:.6g} {text}", stacklevel=7)

    def _fail(self, time):
        """Go back to the last good state; raises RuntimeError, on all ranks."""
        failed = FailedRun(self.problem, time, self.nominal_step, self.safe_step)
        self.schedule = None
        self._flush_recorders()
        self.step, self.time = self._good.step, self._good.time
        for contact in self.problem.contact:
            contact.reset_history()
        self.history.begin_anew()
        self.integrator.start(self._good.displacement, self._good.velocity)
        self._run(0)
        self.state.update()
        raise RuntimeError(failed.message(self.time))

    def _flush_recorders(self):
        for recorder in self.recorders:
            with contextlib.suppress(RuntimeError):  # rows that a full disk has no room for are kept
                recorder.flush()

    # --- the length of the steps -----------------------------------------------------------------------------------

    def _find_stable_step(self):
        self.safe_step, self._stale = self.problem.stable_step(), False

    def _choose_schedule(self, until, dt, unsafe):
        """Schedule the steps to `until`."""
        if isinstance(dt, str):
            if dt != "auto":
                raise ValueError(f"dt is {dt!r}: give a step in units of time, or 'auto'")
            nominal = SAFETY * self.safe_step
            known = self.schedule is not None and self.schedule.auto and not self.nominal_step > nominal
        else:
            nominal = number("dt", dt, 0.0, " [T]")
            known = self.schedule is not None and nominal == self.nominal_step
            if nominal > self.safe_step * (1 + 1e-12):
                text = f"dt = {nominal:.6g} is beyond the stable step {self.safe_step:.6g}"
                if not unsafe:
                    raise ValueError(f"{text}: take a smaller one, or pass unsafe=True to try it")
                if self.comm.rank == 0:
                    warnings.warn(f"{text}: the run may go unstable", stacklevel=6)
        if known and self.schedule.until == until:
            return  # a run that was restored or interrupted goes on with the very steps it had
        if not math.isfinite(nominal):
            raise ValueError("nothing limits the step: give dt")
        needed = (until - self.time) / nominal * (1 - 1e-12)
        if needed > MOST_STEPS or nominal < np.spacing(until):
            why = ": the stable step is that small; check the mesh for tiny cells and the contacts for a large penalty"
            raise ValueError(
                f"a step of {nominal:g} takes {needed:.3g} steps to the time {until:g}, more than {MOST_STEPS:g}"
                f"{why if isinstance(dt, str) else '; take a larger dt'}"
            )
        count = max(1, math.ceil(needed))
        self.nominal_step = nominal
        self.schedule = StepSchedule(self.time, until, self.step, self.step + count, dt == "auto")
        self.integrator.set_contact_step(nominal)

    def _recheck(self, until, dt, unsafe):
        """A body that has deformed has another stable step. Collective."""
        self.state.update_functions()
        self._find_stable_step()
        if self.nominal_step > (SAFETY if dt == "auto" else 1.0) * self.safe_step:
            self.schedule = None
            self._choose_schedule(until, dt, unsafe)

    def _fingerprint(self):
        mesh = self.problem.space.mesh
        return zlib.crc32(mesh.geometry.x), mesh.topology.index_map(mesh.topology.dim).size_global
