# SPDX-License-Identifier: MIT
"""Progress of a passage on the terminal."""

from __future__ import annotations

import time
from types import TracebackType
from typing import TYPE_CHECKING, Any

from mpi4py import MPI

from .parameters import RailJoint

if TYPE_CHECKING:
    import rich.progress

PAUSE = 0.2  # between updates [s]


class WayBar:
    """Progress bar with the place of the wheel, the step and the remaining time, on rank 0 only.

    Use it as a context manager around the steps, and give it to `ExplicitProblem.advance` as callback.

    Args:
        comm: communicator of the run.
        data: the joint.
        wanted: whether a bar is shown at all.
    """

    def __init__(self, comm: MPI.Intracomm, data: RailJoint, wanted: bool) -> None:
        self._bar: rich.progress.Progress | None = None
        self._data, self._shown = data, 0.0
        if wanted and comm.rank == 0:
            from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

            text = TextColumn("axle at {task.fields[place]:+6.1f} mm  step {task.fields[step]}")
            self._bar = Progress(text, BarColumn(), TimeRemainingColumn())
            self._task = self._bar.add_task("", total=data.duration, place=1e3 * data.begin, step=0)

    def __enter__(self) -> WayBar:
        if self._bar:
            self._bar.start()
        return self

    def __call__(self, run: Any) -> None:
        """Update the bar.

        Args:
            run: explicit problem.
        """
        if self._bar and time.perf_counter() - self._shown > PAUSE:
            self._shown = time.perf_counter()
            place = 1e3 * (self._data.begin + self._data.speed * run.time)
            self._bar.update(self._task, completed=run.time, place=place, step=run.step)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._bar:
            self._bar.stop()
