# SPDX-License-Identifier: MIT
"""Progress of a passage on the terminal."""

from __future__ import annotations

import time
from typing import Any

from mpi4py import MPI

from dolfinx_impact.common.progress_bar import ProgressBar

from .parameters import RailJoint

PAUSE = 0.2  # between updates [s]


class WayBar(ProgressBar):
    """Progress bar with the place of the wheel, the step and the remaining time, on rank 0 only.

    Use it as a context manager around the steps, and give it to `ExplicitProblem.advance` as callback.

    Args:
        comm: communicator of the run.
        data: the joint.
        wanted: whether a bar is shown at all.
    """

    def __init__(self, comm: MPI.Intracomm, data: RailJoint, wanted: bool) -> None:
        self._data, self._shown = data, 0.0
        super().__init__(comm, wanted, data.duration, self._text(0.0, 0))

    def _text(self, time: float, step: int) -> str:
        return f"axle at {1e3 * (self._data.begin + self._data.speed * time):+6.1f} mm  step {step}"

    def __call__(self, run: Any) -> None:
        """Update the bar.

        Args:
            run: explicit problem.
        """
        if time.perf_counter() - self._shown > PAUSE:
            self._shown = time.perf_counter()
            self.show(run.time, lambda: self._text(run.time, run.step))
