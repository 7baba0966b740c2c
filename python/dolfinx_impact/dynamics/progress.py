# SPDX-License-Identifier: MIT
"""Progress of an explicit run, on the terminal."""

from .step_schedule import StepSchedule


class ProgressBar:
    """Bar with step, time, dt, energy drift and time left, on rank 0 only.

    Args:
        comm: communicator of the run.
        schedule: the steps that the bar is for.
        wanted: whether there is a bar at all.
    """

    def __init__(self, comm, schedule: StepSchedule, wanted: bool) -> None:
        self._bar, self._begin = None, schedule.begin
        if wanted and comm.rank == 0:
            from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

            columns = TextColumn("step {task.fields[step]}  t = {task.fields[time]:.4g}  dt = {task.fields[dt]:.3g}")
            drift = TextColumn("drift {task.fields[drift]:+.1e}")
            self._bar = Progress(columns, BarColumn(), drift, TimeRemainingColumn())
            fields = {"step": schedule.first, "time": schedule.begin, "dt": schedule.dt, "drift": 0.0}
            self._task = self._bar.add_task("", total=schedule.until - schedule.begin, **fields)

    def __enter__(self):
        if self._bar:
            self._bar.start()
        return self

    def show(self, step: int, time: float, dt: float, drift: float) -> None:
        """Bring the bar up to date.

        Args:
            step: number of the step that was reached.
            time: time that was reached [T].
            dt: length of the steps now [T].
            drift: relative change of the total energy [1].
        """
        if self._bar:
            self._bar.update(self._task, completed=time - self._begin, step=step, time=time, dt=dt, drift=drift)

    def __exit__(self, *_):
        if self._bar:
            self._bar.stop()
        return False
