# SPDX-License-Identifier: MIT
"""Time stepping of an explicit problem: schedules, checks of the stable step, runs that fail."""

from __future__ import annotations

import contextlib
import math
import warnings
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, NoReturn

import numpy as np
import numpy.typing as npt

from ..assembly.large_rotation import RotationWarning
from ..common.collective import agree, attempt, common, is_common
from ..common.interrupts import Interrupts
from ..common.arguments import number
from ..common.types import FloatArray
from . import energy_gain
from .advance_calls import AdvanceCalls
from .current_state import CurrentState
from .failed_run import FailedRun
from .functions_of_time import FunctionsOfTime
from .inputs import Inputs
from .progress import ProgressBar
from .run_history import RunHistory
from .stable_step_watch import StableStepWatch
from .step_schedule import StepSchedule

if TYPE_CHECKING:
    from .explicit import ExplicitProblem
    from .recorder import Recorder

SAFETY = 0.9  # fraction of the stable step that dt="auto" takes; contact stiffness needs the rest
CHUNK = 1000  # steps that the C++ integrator takes in one call
RECHECK = 500  # steps after which a stable step that changes is computed again, at most
FIRST_CHECK = 2  # steps after which it is for the first time
CHANGE = 0.03  # wanted relative change of the stable step from one check to the next; SAFETY leaves 0.1
SNAPSHOT = 100  # steps between the states that an unstable run returns to
MOST_STEPS = 10**9  # in one call: what a recorder writes of as many steps takes a hundred gigabytes


@dataclass
class GoodState:
    """State that a failed run returns to.

    Attributes:
        step: number of the step [1].
        time: time of the step [T].
        displacement: displacement over owned degrees of freedom [L].
        velocity: velocity over owned degrees of freedom [L/T].
    """

    step: int
    time: float
    displacement: FloatArray
    velocity: FloatArray


class TimeStepper:
    """Steps an explicit problem in time.

    The C++ integrator computes the steps. This class decides how many steps it takes and how long they are, and runs
    what happens between them: callbacks, recorders, checks of the stable step.

    Args:
        problem: ExplicitProblem with communicator, space, integrator, contacts and `stable_step`.
        functions: functions of time of loads, supports and obstacles.
        inputs: values that a user may change between steps.
        state: state that callbacks see.
        history: energies and contact forces of the steps.
        watch: stable step of a body whose stiffness depends on the displacement; None: it does not.
        periodic: whether the stable step changes with the velocity or internal variables.

    Attributes:
        time: present time [T].
        step: number of the present step [1].
        next_time: time of the next step; the integrator knows the functions of time up to it [T].
        schedule: steps of the present `advance`; None outside one that was interrupted.
        safe_step: largest stable step, as last computed [T].
        nominal_step: upper bound of the steps of the present schedule [T].
        check_step: step at which the stable step of a deforming body is computed again [1].
        check_interval: number of steps from the last check to that one [1].
        recorders: Recorders that write during the run.
    """

    time: float
    step: int
    next_time: float
    safe_step: float
    nominal_step: float
    check_step: int
    check_interval: int
    functions: FunctionsOfTime
    inputs: Inputs
    state: CurrentState
    history: RunHistory

    def __init__(
        self,
        problem: ExplicitProblem,
        functions: FunctionsOfTime,
        inputs: Inputs,
        state: CurrentState,
        history: RunHistory,
        watch: StableStepWatch | None,
        periodic: bool,
    ) -> None:
        self.problem, self.comm = problem, problem.comm
        self.functions, self.inputs, self.state, self.history = functions, inputs, state, history
        self.integrator, self.watch, self.periodic = problem._cpp_object, watch, periodic
        self.time, self.step, self.next_time = 0.0, 0, 0.0
        self.schedule: StepSchedule | None = None
        self.recorders: list[Recorder] = []
        self._mesh_fingerprint = self._fingerprint()
        self._good: GoodState | None = None
        self._warn_at, self._warned = math.inf, False
        self._rotation_warning = RotationWarning(problem.material)
        self._calls = AdvanceCalls()
        self._periodic = periodic
        self._deformed = False  # a cell did, before the checkpoint from which the run goes on
        self.safe_step = problem.stable_step() if watch is None else watch.find_all()
        self.nominal_step = SAFETY * self.safe_step
        # Plastic flow may change the stable step by a third within 100 steps, elastic deformation does not.
        self.flows = problem.has_history
        self.check_step = self.check_interval = FIRST_CHECK if self.flows else RECHECK

    def start(self, displacement: FloatArray, velocity: FloatArray) -> None:
        """Set the state at time zero and compute its forces. Collective.

        Args:
            displacement: displacement over owned degrees of freedom [L].
            velocity: velocity over owned degrees of freedom [L/T].

        Raises:
            ValueError: bodies overlap too much; on all ranks.
        """
        self.integrator.set_contact_step(self.nominal_step)
        self.state.share.begin_anew()
        self.integrator.start(displacement, velocity)
        self._run(0)
        for contact in self.problem.contact:
            contact.check_start()
        self.state.update()

    def restart(self) -> None:
        """Compute the forces of the start once more: contacts have got a history, or other springs. Collective."""
        u, v = (f.x.array[: self.problem.num_owned] for f in (self.problem.u, self.problem.velocity))
        self.start(u, v)

    def resume(
        self,
        time: float,
        step: int,
        next_time: float,
        safe_step: float,
        nominal_step: float,
        check_step: int,
        check_interval: int,
        schedule: StepSchedule | None,
        deformed: bool,
    ) -> None:
        """Set the attributes from a checkpoint; the integrator must have been restored before. Collective.

        Args:
            time: present time [T].
            step: number of the present step [1].
            next_time: time of the next step [T].
            safe_step: largest stable step [T].
            nominal_step: upper bound of the steps of the schedule [T].
            check_step: step at which the stable step of a deforming body is computed again [1].
            check_interval: number of steps from the last check to that one [1].
            schedule: steps of an `advance` that was interrupted; None: there was none.
            deformed: whether a cell has deformed so far that the stable step is to be found anew.
        """
        self.time, self.step, self.next_time = time, step, next_time
        table = np.ascontiguousarray(self.functions.table(np.array([time, next_time])))
        self.integrator.run(np.zeros(0), table.ravel(), table.shape[1], np.zeros(0))
        self.safe_step, self.nominal_step, self._deformed = safe_step, nominal_step, deformed
        self.check_step, self.check_interval = check_step, check_interval
        self.schedule, self._good = schedule, None
        self.state.share.begin_anew()
        if self.watch is not None:
            self.watch.begin(nominal_step)

    @property
    def deformed(self) -> bool:
        """Whether a cell has deformed so far that the stable step is to be found anew; the same on all ranks."""
        return bool(self._deformed or self.integrator.deformed)

    def check_arguments(
        self,
        until: float,
        callback: Callable[[ExplicitProblem], object] | None,
        update: Callable[[ExplicitProblem, float], object] | None,
    ) -> float:
        """Check arguments of `advance` on this rank.

        Args:
            until: time to advance to [T].
            callback: function of the problem, or None.
            update: function of problem and time, or None.

        Returns:
            `until` as a number [T].

        Raises:
            RuntimeError: `advance` was called by a callback of `advance`.
            TypeError: `until` is no number, `callback` or `update` no function.
            ValueError: `until` has passed, or the mesh has changed.
        """
        until = self._calls.check(self.time, until, callback, update)
        self.state.read.check()
        if self._fingerprint() != self._mesh_fingerprint:
            raise ValueError("the mesh was changed after the problem was set up: make a new problem")
        return until

    def advance(
        self,
        until: float,
        dt: float | str,
        callback: Callable[[ExplicitProblem], object] | None,
        update: Callable[[ExplicitProblem, float], object] | None,
        progress: bool,
        unsafe: bool,
        energy_limits: tuple[float, float],
    ) -> None:
        """Advance to a time; the arguments must have been checked. Collective.

        Args:
            until: time to advance to [T].
            dt: largest step [T], or "auto".
            callback: function that is called after each step, or None.
            update: function that sets values for a time, or None.
            progress: whether a progress bar is shown.
            unsafe: whether a step beyond the stable step is accepted.
            energy_limits: gains of energy at which the run warns and stops [1].

        Raises:
            KeyboardInterrupt: a rank was interrupted.
            RuntimeError: the run failed, or a recorder has no room.
            TypeError: `dt` is no number.
            ValueError: `dt` does not fit.
        """
        self._warn_at, self.integrator.gain_limit = energy_limits
        with self._calls.running(), Interrupts(self.comm) as interrupts:
            self._advance(until, dt, callback, update, progress, unsafe, interrupts)
            interrupts.check()

    def refresh(self) -> None:
        """Copy constants, functions and loads that have changed to the integrator. Collective."""
        self.inputs.update_changed()

    # --- the loop --------------------------------------------------------------------------------------------------

    def _advance(
        self,
        until: float,
        dt: float | str,
        callback: Callable[[ExplicitProblem], object] | None,
        update: Callable[[ExplicitProblem, float], object] | None,
        progress: bool,
        unsafe: bool,
        interrupts: Interrupts,
    ) -> None:
        self.refresh()
        now = self._calls.at_present(None if self.step > 0 else callback, update)
        if now:
            interrupts.check(self._call(now))
        callback = self._calls.at_present(callback, update)
        known = not self.inputs.changes.stale
        if not known:
            self._find_stable_step()
        self._choose_schedule(until, dt, unsafe)
        if self.watch is not None:
            self._deformed = known and self.deformed  # a call that was left did not look at what had deformed
            self._watch_steps(dt)
        # Steps that are given are compared with the stable step now and then; they are not chosen by it.
        self._periodic = self.periodic or (self.watch is not None and dt != "auto")
        with ProgressBar(self.comm, self._present_schedule, progress) as bar:
            try:
                while self.step < self._present_schedule.last:
                    self._take_steps(until, dt, callback, unsafe, bar, interrupts)
            except BaseException as error:
                if is_common(self.comm, error):
                    self.state.update()
                    self._flush_recorders()
                raise
        self.schedule = None
        self.state.update()
        self.state.share.warn()
        self._rotation_warning.look(self.problem.u, stacklevel=4)

    @property
    def _present_schedule(self) -> StepSchedule:
        """Schedule inside `advance`."""
        assert self.schedule is not None
        return self.schedule

    def _take_steps(
        self,
        until: float,
        dt: float | str,
        callback: Callable[[ExplicitProblem], object] | None,
        unsafe: bool,
        bar: ProgressBar,
        interrupts: Interrupts,
    ) -> None:
        """Take one call's steps of the C++ integrator, then run contacts' checks, recorders and callback.

        An exception is raised on all ranks, after a step. Collective.
        """
        changes = self.inputs.changes
        due = changes.due or (changes.stale and self.step > 0 and self.step % RECHECK == 0)
        if due or (self._periodic and self.step >= self.check_step) or self.deformed:
            self._recheck(until, dt, unsafe)
        first = self.step == 0
        self._run(1 if callback or first else self._chunk(), interrupts)
        if first:  # kinematic contact has gaps only after a step
            for contact in self.problem.contact:
                contact.check_start()
        for recorder in self.recorders:
            recorder.after()
        error = self._call(callback) if callback else None
        interrupts.check(error or attempt(self._show, bar)[1])

    def _show(self, bar: ProgressBar) -> None:
        last = self.history.last
        if last is not None:
            bar.show(self.step, self.time, self._present_schedule.dt, self.history.drift(last))

    def _call(self, callback: Callable[[ExplicitProblem], object]) -> BaseException | None:
        """Call the callback with the present state, then copy what it has changed. Collective.

        Returns:
            The callback's exception on this rank, or None.
        """
        self.state.update()
        error: BaseException | None = attempt(callback, self.problem)[1]
        error = error or attempt(self.state.check_not_written)[1]
        self.refresh()
        return error

    def _chunk(self) -> int:
        """Number of steps until a recorder, a check of the stable step or the end is due."""
        rest = self._present_schedule.last - self.step
        waits = [recorder.steps_left() for recorder in self.recorders]
        return min(CHUNK, rest, self.check_step - self.step if self._periodic else rest, *waits)

    def _run(self, count: int, interrupts: Interrupts | None = None) -> None:
        """Take steps, fewer if a rank is interrupted. Collective.

        Args:
            count: number of steps; 0: compute the forces of the present state [1].
            interrupts: tells whether to stop early.
        """
        steps = np.arange(self.step, self.step + count + 2)  # the integrator needs functions of time one step ahead
        times = self.schedule.times(steps) if self.schedule else np.full(2, self.time)
        found, error = attempt(self.functions.table, times)
        agree(self.comm, error, "functions of time")
        if self.step - (self._good.step if self._good else -SNAPSHOT) >= SNAPSHOT or count > SNAPSHOT:
            u, v, _ = self.state.motion()
            self._good = GoodState(self.step, self.time, u, v)
            self.problem.store_history()
        rows = np.zeros(count, dtype=self.history.step_type)
        lengths = np.full(count, self._present_schedule.dt if count else 1.0)
        table, columns = np.ascontiguousarray(found).ravel(), found.shape[1]
        done = self.integrator.run(lengths, table, columns, rows.view(float), interrupts and interrupts.asked)
        self._keep(times[:done], rows[:done])
        if done < count and not self.integrator.stopped:
            self._fail(times[done])
        self.step, self.time, self.next_time = self.step + done, float(times[done]), float(times[done + 1])
        self._warn_of_gain()

    def _keep(self, times: FloatArray, steps: npt.NDArray[np.void]) -> None:
        rows = self.history.add(times, steps)
        self.state.share.add(rows)
        if len(rows):
            for recorder in self.recorders:
                recorder.add(rows)

    def _warn_of_gain(self) -> None:
        if self.integrator.most_gained > self._warn_at and not self._warned:
            self._warned = True
            if self.comm.rank == 0:
                text = energy_gain.message(self.integrator.most_gained)
                warnings.warn(f"the run gains energy: by the time {self.time:.6g} {text}", stacklevel=7)

    def _fail(self, time: float, fault: str = "") -> NoReturn:
        """Return to the last good state and raise RuntimeError, on all ranks.

        Args:
            time: time of the step that failed [T].
            fault: what is wrong with the state then, if that is known.
        """
        failed, good = FailedRun(self.problem, time, self.nominal_step, self.safe_step), self._good
        assert good is not None
        self.schedule = None
        self._flush_recorders()
        self.step, self.time = good.step, good.time
        self._plan_check(FIRST_CHECK)
        self.inputs.changes.add(math.inf)  # the stable step was that of another state
        for contact in self.problem.contact:
            contact.reset_history()
        self.problem.restore_history()
        self.history.begin_anew()
        self.state.share.begin_anew()
        self.integrator.start(good.displacement, good.velocity)
        self._run(0)
        self.state.update()
        if fault:
            raise common(RuntimeError(failed.message_of(fault, self.time)))
        stable, error = attempt(self.problem.stable_step)  # of a state that is no number there is none
        raise common(RuntimeError(failed.message(self.time, self.safe_step if stable is None or error else stable)))

    def _flush_recorders(self) -> None:
        for recorder in self.recorders:
            with contextlib.suppress(RuntimeError):  # the recorder keeps rows for which a full disk has no room
                recorder.flush()

    # --- the length of the steps -----------------------------------------------------------------------------------

    def _find_stable_step(self) -> None:
        """Compute the stable step of the present state. Collective."""
        before, changes, watch = self.safe_step, self.inputs.changes, self.watch
        if watch is None:
            self.safe_step = self.problem.stable_step()
        elif changes.stale or self._periodic:  # frequencies of all cells may be others
            self.safe_step = watch.find_all()
        else:
            self.safe_step = watch.find_changed()
        changes.done(before, self.safe_step)
        self._deformed = False

    def _choose_schedule(self, until: float, dt: float | str, unsafe: bool) -> None:
        """Set the schedule of the steps to `until`; keep a schedule of an interrupted `advance` to the same time."""
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
                    raise common(ValueError(f"{text}: take a smaller one, or pass unsafe=True to try it"))
                if self.comm.rank == 0:
                    warnings.warn(f"{text}: the run may go unstable", stacklevel=6)
        if known and self._present_schedule.until == until:
            return  # a run that was restored or interrupted continues with the steps it had
        if not math.isfinite(nominal):
            raise common(ValueError("nothing limits the step: give dt"))
        needed = (until - self.time) / nominal * (1 - 1e-12)
        if needed > MOST_STEPS or nominal < np.spacing(until):
            why = ": the stable step is that small; check the mesh for tiny cells and the contacts for a large penalty"
            raise common(
                ValueError(
                    f"a step of {nominal:g} takes {needed:.3g} steps to the time {until:g}, more than {MOST_STEPS:g}"
                    f"{why if isinstance(dt, str) else '; take a larger dt'}"
                )
            )
        count = max(1, math.ceil(needed))
        self.nominal_step = nominal
        self.schedule = StepSchedule(self.time, until, self.step, self.step + count, dt == "auto")
        if nominal > self.integrator.contact_step or math.isinf(self.integrator.contact_step):
            # Springs by the step follow longer steps only, which do not bear them otherwise: under shorter ones a
            # stiffness that changes would change the forces of what is already pressed. (Where cells have no stiffness
            # at rest, nothing limits the step at the start.)
            self.integrator.set_contact_step(nominal)
            if self.step == 0:
                self.restart()

    def _recheck(self, until: float, dt: float | str, unsafe: bool) -> None:
        """Compute the stable step of the deformed body, and shorten the steps if they exceed it. Collective.

        With plastic flow the next check is due when the stable step will have changed by about CHANGE, if it goes on as
        since the last one; the time between two checks is at most doubled.
        """
        before = self.safe_step
        self.state.update_functions()
        try:
            self._find_stable_step()
        except ValueError as error:  # on all ranks: the deformation is beyond what the law is made for
            self._fail(self.time, str(error))
        changed = abs(self.safe_step / before - 1.0) if math.isfinite(before) else 0.0
        factor = min(2.0, CHANGE / changed) if changed > 0.0 else 2.0
        self._plan_check(min(max(int(factor * self.check_interval), 1), RECHECK))
        if self.nominal_step > (SAFETY if dt == "auto" else 1.0) * self.safe_step:
            self.schedule = None
            self._choose_schedule(until, dt, unsafe)
        if self.watch is not None:
            self._watch_steps(dt)

    def _watch_steps(self, dt: float | str) -> None:
        """Watch over what cells may deform under the present steps, where they are chosen by the stable step."""
        assert self.watch is not None
        self.watch.begin(self.nominal_step if dt == "auto" else 0.0)

    def _plan_check(self, interval: int) -> None:
        """Set the step of the next check of the stable step.

        Args:
            interval: number of steps until then, of bodies with plastic flow; others are checked every RECHECK steps.
        """
        if self.flows:
            self.check_interval, self.check_step = interval, self.step + interval
        else:
            self.check_interval, self.check_step = RECHECK, (self.step // RECHECK + 1) * RECHECK

    def _fingerprint(self) -> tuple[int, int]:
        mesh = self.problem.space.mesh
        return zlib.crc32(mesh.geometry.x), mesh.topology.index_map(mesh.topology.dim).size_global
