# SPDX-License-Identifier: MIT
"""Interrupts (Ctrl-C) between steps: a signal is recorded when it arrives and raised at the next check on all ranks.

    with Interrupts(comm) as interrupts:
        while ...:
            ...                  # a step: signals that arrive now are recorded
            interrupts.check()   # KeyboardInterrupt on all ranks if any rank was interrupted

Python runs signal handlers in the main thread only: in other threads no handler is installed. A handler of the user's
own is called at the check; if it returns, the computation continues. Where SIGINT is ignored or has the system's
default action, nothing is changed. A second signal has no further effect.
"""

import signal
import threading
import time
from collections.abc import Callable
from types import FrameType, TracebackType
from typing import Any, Literal

from mpi4py import MPI

from .collective import agree, attempt

LATE = 0.25  # s within which the signal that one rank has received reaches the other ranks


class Interrupts:
    """Handles SIGINT inside a `with` block and restores the previous handler at its end.

    Args:
        comm: communicator whose ranks stop together.
    """

    def __init__(self, comm: MPI.Comm) -> None:
        self.comm, self._count = comm, 0
        self._error: BaseException | None = None
        self._previous: Callable[[int, FrameType | None], Any] | None = None

    def __enter__(self) -> "Interrupts":
        if threading.current_thread() is threading.main_thread():
            previous = signal.getsignal(signal.SIGINT)
            if callable(previous):
                self._previous = previous
                signal.signal(signal.SIGINT, self._note)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> Literal[False]:
        if self._previous is not None and signal.getsignal(signal.SIGINT) == self._note:
            signal.signal(signal.SIGINT, self._previous)
            if self._count and kind is not KeyboardInterrupt:  # the signal arrived after the last check
                signal.raise_signal(signal.SIGINT)
        return False

    def _note(self, number: int, frame: FrameType | None) -> None:
        self._count += 1

    def asked(self, error: BaseException | None = None) -> bool:
        """Whether this rank shall stop; CentralDifference.run calls this inside its loop in C++.

        Args:
            error: exception that the handler of another signal has raised meanwhile, or None; `check` raises it.

        Returns:
            True after a signal or an error.
        """
        self._error = self._error or error
        return self._count > 0 or self._error is not None

    def check(self, error: BaseException | None = None) -> None:
        """Raise on all ranks if any of them was interrupted or has an error. Collective, one reduction.

        Args:
            error: exception of this rank, or None.

        Raises:
            KeyboardInterrupt: a rank has received SIGINT.
            Exception: a rank has an error; as collective.agree.
        """
        self._error = self._error or error
        found = 2 if self._error is not None else int(self._count > 0)
        if self.comm.size > 1:
            found = self.comm.allreduce(found, MPI.MAX)
        if not found:
            return
        if found == 1 and self.comm.size > 1:
            # mpirun sends the signal to one rank after the other. Wait for this rank's: a signal that arrives after
            # this check would interrupt the rank once more.
            end = time.monotonic() + LATE
            while not self._count and self._previous is not None and time.monotonic() < end:
                time.sleep(0.005)
        error, self._error = self._error, None
        if error is None and self._count:
            error = self._deliver()
        self._count = 0
        agree(self.comm, error, "interrupt")

    def _deliver(self) -> BaseException | None:
        """Call the previous handler of the signal; returns the exception that it raises, or None."""
        outer = isinstance(getattr(self._previous, "__self__", None), Interrupts)
        if outer or self._previous is None or self._previous is signal.default_int_handler:
            return KeyboardInterrupt()
        return attempt(self._previous, signal.SIGINT, None)[1]
