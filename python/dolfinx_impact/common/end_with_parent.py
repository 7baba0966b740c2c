# SPDX-License-Identifier: MIT
"""Runs a command in a child that ends with its parent, however the parent ends (Linux; elsewhere: just runs it).

    python -I end_with_parent.py PID COMMAND...

asks the kernel for SIGTERM when the parent, process PID, dies, and becomes COMMAND: the request outlives `exec`. It is
a program of its own, as Python code between fork and exec may hang beside threads; it imports nothing of the package.
mpirun ends its ranks when it gets SIGTERM.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from collections.abc import Sequence

PR_SET_PDEATHSIG = 1


def command_of(command: Sequence[str]) -> list[str]:
    """Command that runs another one as a child that ends with this process.

    Args:
        command: to run.
    """
    return [sys.executable, "-I", os.path.abspath(__file__), str(os.getpid()), *command]


def main(argv: Sequence[str]) -> None:
    """Become the command.

    Args:
        argv: process number of the parent, then the command.
    """
    if sys.platform.startswith("linux"):
        ctypes.CDLL(None, use_errno=True).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)
        if os.getppid() != int(argv[0]):  # it has ended meanwhile
            sys.exit(128 + signal.SIGTERM)
    os.execvp(argv[1], list(argv[1:]))


if __name__ == "__main__":
    main(sys.argv[1:])
