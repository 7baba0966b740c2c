# SPDX-License-Identifier: MIT
"""Progress of static solves that take long."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

from mpi4py import MPI

FIRST = 5.0  # time after which a solve says how far it is [s]
LATER, LONGEST = 1.3, 60.0  # from one line to the next the time grows by this factor, up to this time [s]


class SolveProgress:
    """Writes how far a solve is, in lines on the error output of rank 0: the first after some seconds, later ones less
    and less often.

    Lines are not rewritten: under mpirun the output of rank 0 is a terminal to the program also where it goes to a
    file, which a line that is rewritten would fill. A solve of an hour writes some seventy lines.

    Args:
        comm: communicator of the problem.
        wanted: whether there are lines at all.
        now: clock [s].
    """

    def __init__(self, comm: MPI.Comm, wanted: bool, now: Callable[[], float] = time.monotonic) -> None:
        self._wanted, self._now = wanted and comm.rank == 0, now
        self._start, self._wait = now(), FIRST
        self._next = self._start + FIRST
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
        if not self._wanted:
            return
        now = self._now()
        if now < self._next:
            return
        print(f"static solve, {now - self._start:.0f} s: {self._where}, {text}", file=sys.stderr, flush=True)
        self._wait = min(LATER * self._wait, LONGEST)
        self._next = now + self._wait
