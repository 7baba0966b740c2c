# SPDX-License-Identifier: MIT
"""What happens between the steps of an explicit problem: callbacks, recorders, history, progress, messages."""

from __future__ import annotations

import contextlib
import warnings
import zlib
from collections.abc import Callable

import numpy as np
from dolfinx.mesh import Mesh

from .. import _cpp
from ..assembly.large_rotation import RotationWarning
from ..common.collective import agree, attempt, common, is_common
from ..common.interrupts import Interrupts
from ..common.arguments import number
from ..common.types import FloatArray
from .current_state import CurrentState
from .functions_of_time import FunctionsOfTime
from .inputs import Inputs
from .progress import StepProgress
from .recorder import Recorder
from .step_schedule import StepSchedule

SAFETY: float = _cpp.problems.SafeStep.safety  # fraction of the stable step that dt="auto" takes
MANY = 2**62  # steps: the problem looks after itself now and then
ERRORS: dict[str, type[Exception]] = {"value": ValueError, "failure": RuntimeError}


class TimeStepper:
    """Looks after a C++ ExplicitProblem, which steps in time: it is what the problem tells and asks between its steps.

    Args:
        problem: C++ ExplicitProblem.
        mesh: mesh of the bodies.
        functions: functions of time of loads, supports and obstacles.
        inputs: values that a user may change between steps.
        state: state that callbacks see.
        rotation: warning of turning bodies.
        unsolved: tells which local equations were not solved; an empty text if all were.

    Attributes:
        recorders: Recorders that write during the run.
        history: energies and contact forces of the steps.
        integrator: C++ CentralDifference of the problem.
    """

    def __init__(
        self,
        problem: _cpp.problems.ExplicitProblem,
        mesh: Mesh,
        functions: FunctionsOfTime,
        inputs: Inputs,
        state: CurrentState,
        rotation: RotationWarning,
        unsolved: Callable[[], str],
    ) -> None:
        self._cpp_object, self.integrator = problem, problem.integrator
        self._mesh, self.comm = mesh, mesh.comm
        self.functions, self.inputs, self.state, self.history = functions, inputs, state, state.history
        self.recorders: list[Recorder] = []
        self.unsolved = unsolved
        self._rotation = rotation
        self._mesh_fingerprint = self._fingerprint()
        self._callback: Callable[[], object] | None = None
        self._pause = 1  # steps between calls of the callback
        self._interrupts: Interrupts | None = None
        self._progress, self._bar = False, contextlib.ExitStack()
        self._shown: StepProgress | None = None

    # --- the state of the steps ------------------------------------------------------------------------------------

    @property
    def next_time(self) -> float:
        """Time of the next step; the integrator knows the functions of time up to it [T]."""
        return float(self._cpp_object.next_time)

    @property
    def schedule(self) -> StepSchedule | None:
        """Steps of the present `advance`; None outside one that was left."""
        return self._cpp_object.schedule

    @property
    def safe_step(self) -> float:
        """Largest stable step, as last computed [T]."""
        return float(self._cpp_object.safe_step.value)

    @property
    def nominal_step(self) -> float:
        """Upper bound of the steps of the present schedule [T]."""
        return float(self._cpp_object.nominal_step)

    @property
    def check_step(self) -> int:
        """Step at which the stable step of a deforming body is computed again [1]."""
        return int(self._cpp_object.safe_step.check_step)

    @property
    def check_interval(self) -> int:
        """Number of steps from the last check to that one [1]."""
        return int(self._cpp_object.safe_step.check_interval)

    @property
    def deformed(self) -> bool:
        """Whether a cell has deformed so far that the stable step is to be found anew; the same on all ranks."""
        return bool(self._cpp_object.safe_step.deformed)

    @property
    def watch(self) -> _cpp.problems.StableStepWatch | None:
        """Frequencies of the cells of bodies whose stiffness depends on the displacement; None: it does not."""
        return self._cpp_object.safe_step.watch

    def start(self, equilibrium: _cpp.solve.EquilibriumProblem | None = None) -> None:
        """Compute the forces of the start, from the functions of displacement and velocity. Collective.

        Args:
            equilibrium: what materials and springs begin with; see ExplicitProblem.restart_forces.

        Raises:
            ValueError: bodies overlap too much; on all ranks.
            RuntimeError: springs do not bear the static force; on all ranks.
        """
        self.state.share.begin_anew()
        self.state.hourglass.begin_anew()
        if equilibrium is None:
            self._raise(self._cpp_object.start(self))
        else:
            self._raise(_cpp.problems.start_from_equilibrium(self._cpp_object, equilibrium, self))
        self.state.update()

    def resume(self, saved: _cpp.state.State, schedule: StepSchedule | None) -> None:
        """Go on from a checkpoint. Collective.

        Args:
            saved: what the C++ problem has saved.
            schedule: steps of an `advance` that was interrupted; None: there was none.
        """
        self.state.share.begin_anew()
        self.state.hourglass.begin_anew()
        self._cpp_object.resume(saved, schedule, self)

    def check_unchanged(self) -> None:
        """Refuse supports, rigid masters and meshes that were changed, on this rank.

        Raises:
            ValueError: one has been changed.
        """
        self.state.read.check()
        if self._fingerprint() != self._mesh_fingerprint:
            raise ValueError("the mesh was changed after the problem was set up: make a new problem")

    def refresh(self) -> None:
        """Copy constants, functions and loads that have changed to the integrator. Collective."""
        self.inputs.update_changed()

    # --- the loop --------------------------------------------------------------------------------------------------

    def advance(
        self,
        until: float,
        dt: float | str,
        first: Callable[[], object] | None,
        callback: Callable[[], object] | None,
        pause: int,
        progress: bool,
        unsafe: bool,
        energy_limits: tuple[float, float],
    ) -> None:
        """Advance to a time; the arguments must have been checked. Collective.

        Args:
            until: time to advance to [T].
            dt: largest step [T], or "auto".
            first: function that is called at the present time, or None.
            callback: function that is called after steps, or None.
            pause: steps between calls of `callback` [1].
            progress: whether a progress bar is shown.
            unsafe: whether a step beyond the stable step is accepted.
            energy_limits: gains of energy at which the run warns and stops [1].

        Raises:
            KeyboardInterrupt: a rank was interrupted.
            RuntimeError: the run failed, or a recorder has no room.
            TypeError: `dt` is no number.
            ValueError: `dt` does not fit.
        """
        with Interrupts(self.comm) as interrupts:
            self.refresh()
            if first:
                interrupts.check(self._call(first))
            if isinstance(dt, str) and dt != "auto":
                raise ValueError(f"dt is {dt!r}: give a step in units of time, or 'auto'")
            step = None if isinstance(dt, str) else number("dt", dt, 0.0, " [T]")
            self._callback, self._interrupts, self._progress = callback, interrupts, progress
            self._pause = pause
            try:
                with contextlib.ExitStack() as self._bar:
                    self._raise(self._cpp_object.advance(until, step, unsafe, *energy_limits, self))
            except BaseException as error:
                if is_common(self.comm, error):
                    self.state.update()
                    self._flush_recorders()
                raise
            finally:
                self._callback = self._interrupts = self._shown = None
            self.state.update()
            self.state.share.warn()
            self.state.hourglass.warn()
            self._rotation.look(self.state.functions[0], stacklevel=3)
            interrupts.check()

    @staticmethod
    def _raise(thrown: tuple[str, str] | None) -> None:
        """Raise what all ranks of the C++ side have thrown together."""
        if thrown is not None:
            raise common(ERRORS[thrown[0]](thrown[1]))

    def _call(self, callback: Callable[[], object]) -> BaseException | None:
        """Call the callback with the present state, then copy what it has changed. Collective.

        Returns:
            The callback's exception on this rank, or None.
        """
        self.state.update()
        error: BaseException | None = attempt(callback)[1]
        error = error or attempt(self.state.check_not_written)[1]
        self.refresh()
        return error

    def _flush_recorders(self) -> None:
        for recorder in self.recorders:
            with contextlib.suppress(RuntimeError):  # the recorder keeps rows for which a full disk has no room
                recorder.flush()

    def _fingerprint(self) -> tuple[int, int]:
        return zlib.crc32(self._mesh.geometry.x), self._mesh.topology.index_map(self._mesh.topology.dim).size_global

    # --- what the C++ problem tells and asks -----------------------------------------------------------------------

    def asked(self, error: BaseException | None) -> bool:
        """Whether this rank shall stop after the step.

        Args:
            error: exception that the handler of a signal has raised, or None.
        """
        return self._interrupts is not None and self._interrupts.asked(error)

    def begins(self, schedule: StepSchedule) -> None:
        """Show progress of steps that begin.

        Args:
            schedule: the steps.
        """
        self._shown = self._bar.enter_context(StepProgress(self.comm, schedule, self._progress))

    def room(self) -> int:
        """Number of steps until a recorder or the callback is due."""
        waits = [recorder.steps_left() for recorder in self.recorders]
        if self._callback:
            waits.append(self._pause - self._cpp_object.step % self._pause)
        return min([self.state.hourglass.steps_left(MANY), *waits])

    def table(self, times: FloatArray) -> FloatArray:
        """Sample the functions of time. Collective.

        Args:
            times: times, (n) [T].

        Returns:
            Values, n rows one after the other.
        """
        found, error = attempt(self.functions.table, times)
        agree(self.comm, error, "functions of time")
        return np.ascontiguousarray(found).ravel()

    def add_rows(self, times: FloatArray, steps: FloatArray) -> None:
        """Take note of steps that were made.

        Args:
            times: times before them, (n) [T].
            steps: n rows of RunHistory.step_type, one after the other.
        """
        if not len(times):
            return
        rows = self.history.rows(times, steps.view(self.history.step_type))
        self.state.share.add(rows)
        self.state.hourglass.add(float(np.max(rows["internal"])), len(rows))
        for recorder in self.recorders:
            recorder.add(rows)

    def after_steps(self) -> None:
        """Run recorders and callback after steps. An exception is raised on all ranks. Collective."""
        assert self._interrupts is not None  # steps are made inside `advance`
        for recorder in self.recorders:
            recorder.after()
        called = self._callback is not None and self._cpp_object.step % self._pause == 0
        error = self._call(self._callback) if called and self._callback else None
        if self.state.hourglass.due:
            self.state.update_functions()
            self.state.hourglass.entry()
        self._interrupts.check(error or attempt(self._show)[1])

    def _show(self) -> None:
        last, schedule = self.history.last, self.schedule
        if last is not None and self._shown is not None and schedule is not None:
            self._shown.show_step(self._cpp_object.step, self._cpp_object.time, schedule.dt, self.history.drift(last))

    def warn(self, text: str) -> None:
        """Warn of what the run has found.

        Args:
            text: the warning.
        """
        warnings.warn(text, stacklevel=4)

    def failed(self) -> None:
        """Write what there is before the run goes back to its last good state."""
        self._flush_recorders()
        self.state.share.begin_anew()
        self.state.hourglass.begin_anew()
