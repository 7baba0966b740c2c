# SPDX-License-Identifier: MIT
"""Progress of static solves that take long."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

from mpi4py import MPI

from ..common.messages import progress_is_shown
from ..common.progress_lines import ProgressLines


class SolveProgress:
    """Writes how far a solve is, in lines on the error output of rank 0: the first after some seconds, later ones less
    and less often. There are none where the level of DOLFINx's log is ERROR or higher.

    Args:
        comm: communicator of the problem.
        wanted: whether there are lines at all.
        now: clock [s].
    """

    def __init__(self, comm: MPI.Comm, wanted: bool, now: Callable[[], float] = time.monotonic) -> None:
        self._lines = ProgressLines(now) if wanted and comm.rank == 0 and progress_is_shown() else None
        self._where = ""

    def begin(self, increment: int, done: float, fraction: float) -> None:
        """Begin an increment.

        Args:
            increment: its number [1].
            done: fraction of the load step at its start [1].
            fraction: fraction at its end [1].
        """
        self._where = f"{done:.0%} of the way, increment {increment} to {fraction:.0%}"
        self.show("begins")

    def show(self, text: str) -> None:
        """Write a line if it is time for one.

        Args:
            text: what is being done.
        """
        seconds = self._lines.due() if self._lines else None
        if seconds is not None:
            print(f"static solve, {seconds:.0f} s: {self._where}, {text}", file=sys.stderr, flush=True)
