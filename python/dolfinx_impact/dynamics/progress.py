# SPDX-License-Identifier: MIT
"""Progress of a run in time."""

from __future__ import annotations

from mpi4py import MPI

from ..common.progress_bar import ProgressBar
from .step_schedule import StepSchedule


class StepProgress(ProgressBar):
    """Progress bar with step, time, dt, energy drift and remaining time.

    Args:
        comm: communicator of the run.
        schedule: steps that the bar shows.
        wanted: whether a bar is shown at all.
    """

    def __init__(self, comm: MPI.Comm, schedule: StepSchedule, wanted: bool) -> None:
        self._begin = schedule.begin
        begin = _text(schedule.first, schedule.begin, schedule.dt)
        super().__init__(comm, wanted, schedule.until - schedule.begin, begin)

    def show_step(self, step: int, time: float, dt: float, drift: float) -> None:
        """Show the present step.

        Args:
            step: number of the present step [1].
            time: present time [T].
            dt: present length of the steps [T].
            drift: relative change of the total energy [1].
        """
        self.show(time - self._begin, lambda: _text(step, time, dt), lambda: f"drift {drift:+.1e}")


def _text(step: int, time: float, dt: float) -> str:
    return f"step {step}  t = {time:.4g}  dt = {dt:.3g}"
