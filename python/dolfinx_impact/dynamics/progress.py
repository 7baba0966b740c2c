# SPDX-License-Identifier: MIT
"""Progress of an explicit run, on the terminal."""

from __future__ import annotations

from types import TracebackType
from typing import TYPE_CHECKING

from mpi4py import MPI

from .step_schedule import StepSchedule

if TYPE_CHECKING:
    import rich.progress


class ProgressBar:
    """Progress bar with step, time, dt, energy drift and remaining time, on rank 0 only.

    Use it as a context manager around the steps.

    Args:
        comm: communicator of the run.
        schedule: steps that the bar shows.
        wanted: whether a bar is shown at all.
    """

    def __init__(self, comm: MPI.Comm, schedule: StepSchedule, wanted: bool) -> None:
        self._bar: rich.progress.Progress | None = None
        self._begin = schedule.begin
        if wanted and comm.rank == 0:
            from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

            columns = TextColumn("step {task.fields[step]}  t = {task.fields[time]:.4g}  dt = {task.fields[dt]:.3g}")
            drift = TextColumn("drift {task.fields[drift]:+.1e}")
            self._bar = Progress(columns, BarColumn(), drift, TimeRemainingColumn())
            total = schedule.until - schedule.begin
            self._task = self._bar.add_task(
                "", total=total, step=schedule.first, time=schedule.begin, dt=schedule.dt, drift=0.0
            )

    def __enter__(self) -> ProgressBar:
        if self._bar:
            self._bar.start()
        return self

    def show(self, step: int, time: float, dt: float, drift: float) -> None:
        """Update the bar.

        Args:
            step: number of the present step [1].
            time: present time [T].
            dt: present length of the steps [T].
            drift: relative change of the total energy [1].
        """
        if self._bar:
            self._bar.update(self._task, completed=time - self._begin, step=step, time=time, dt=dt, drift=drift)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._bar:
            self._bar.stop()
