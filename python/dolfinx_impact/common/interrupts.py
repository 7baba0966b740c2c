# SPDX-License-Identifier: MIT
"""Ctrl-C where the state is whole: the signal is noted when it comes and raised between steps, on all ranks together.

    with Interrupts(comm) as interrupts:
        while ...:
            ...                  # a step: what comes now is noted
            interrupts.check()   # KeyboardInterrupt on all ranks if any rank was interrupted

Python lets handlers of signals run in the main thread only: in other threads nothing is installed. A handler of the
user's own is called at the check; if it returns, the work goes on. Where SIGINT is ignored or left to the system it
stays so. A second signal does no more than the first.
"""

import signal
import threading
import time

from mpi4py import MPI

from .collective import agree, attempt

LATE = 0.25  # s in which the signal that one rank has got reaches the others as well


class Interrupts:
    """Takes SIGINT inside a `with` block and gives it back at the end.

    Args:
        comm: communicator whose ranks stop together.
    """

    def __init__(self, comm):
        self.comm, self._count, self._error, self._previous = comm, 0, None, None

    def __enter__(self):
        if threading.current_thread() is threading.main_thread():
            previous = signal.getsignal(signal.SIGINT)
            if callable(previous):
                self._previous = previous
                signal.signal(signal.SIGINT, self._note)
        return self

    def __exit__(self, kind, error, trace):
        if self._previous is not None and signal.getsignal(signal.SIGINT) == self._note:
            signal.signal(signal.SIGINT, self._previous)
            if self._count and kind is not KeyboardInterrupt:  # it came after the last check
                signal.raise_signal(signal.SIGINT)
        return False

    def _note(self, number, frame):
        self._count += 1

    def asked(self, error=None):
        """Is this rank to stop? Loops in C++ ask it: see CentralDifference.run.

        Args:
            error: what the handler of another signal has raised meanwhile, or None; `check` raises it.
        """
        self._error = self._error or error
        return self._count > 0 or self._error is not None

    def check(self, error=None):
        """Raise on all ranks if any was interrupted, or has an error. Collective, one reduction.

        Args:
            error: exception of this rank, or None.

        Raises:
            KeyboardInterrupt: SIGINT came to any of the ranks. Other errors: as collective.agree.
        """
        self._error = self._error or error
        found = 2 if self._error is not None else int(self._count > 0)
        if self.comm.size > 1:
            found = self.comm.allreduce(found, MPI.MAX)
        if not found:
            return
        if found == 1 and self.comm.size > 1:
            # mpirun tells all ranks, one after the other: a rank must not hear of it when it believes that is over.
            end = time.monotonic() + LATE
            while not self._count and self._previous is not None and time.monotonic() < end:
                time.sleep(0.005)
        error, self._error = self._error, None
        if error is None and self._count:
            error = self._deliver()
        self._count = 0
        agree(self.comm, error, "interrupt")

    def _deliver(self):
        """What the handler that was there before makes of the signal: an exception, or None."""
        outer = isinstance(getattr(self._previous, "__self__", None), Interrupts)
        if outer or self._previous is signal.default_int_handler:
            return KeyboardInterrupt()
        return attempt(self._previous, signal.SIGINT, None)[1]
