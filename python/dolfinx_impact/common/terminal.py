# SPDX-License-Identifier: MIT
"""Whether a person sees a stream on a terminal, also under mpirun."""

from __future__ import annotations

import os
import stat
import sys
from pathlib import Path
from typing import IO, TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

#: Variables that Open MPI sets for its ranks.
OPEN_MPI = ("OMPI_COMM_WORLD_RANK", "PMIX_RANK")


def is_terminal(stream: IO[str]) -> bool:
    """Whether a stream goes to a terminal.

    Open MPI gives rank 0 a pseudo-terminal and copies what is written there to its own output, which may be a file. So
    under Open MPI the output of the process that holds the other end is asked: mpirun, which has started the rank. On
    another machine than mpirun's, that process is a daemon without a terminal.

    Args:
        stream: standard output or standard error of this process, or another stream.

    Returns:
        Whether it is a terminal; False where that cannot be found out.
    """
    try:
        number = stream.fileno()
        if not os.isatty(number):
            return False
        if not any(name in os.environ for name in OPEN_MPI):
            return True
        return _goes_to_terminal(os.getppid(), number, os.fstat(number))
    except (AttributeError, OSError, ValueError):  # no file behind it, closed, or no /proc
        return False


def _goes_to_terminal(process: int, number: int, ours: os.stat_result) -> bool:
    """Whether the nearest ancestor with another output than ours, from a process on, has a terminal there."""
    while process > 0:
        output = Path(f"/proc/{process}/fd/{number}")
        theirs = output.stat()
        if (theirs.st_dev, theirs.st_ino) != (ours.st_dev, ours.st_ino):
            return stat.S_ISCHR(theirs.st_mode) and _is_terminal_device(output)
        # The name of the program, in parentheses, may have spaces and parentheses itself.
        process = int(Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[1])
    return False


def _is_terminal_device(path: Path) -> bool:
    """Whether a character device is a terminal."""
    descriptor = os.open(path, os.O_RDONLY | os.O_NOCTTY | os.O_NONBLOCK)
    try:
        return os.isatty(descriptor)
    finally:
        os.close(descriptor)


def console(stderr: bool = False) -> Console:
    """Console of rich that rewrites lines only on a terminal that a person sees, and in a notebook.

    Args:
        stderr: write to standard error, not to standard output.
    """
    from rich.console import Console

    return Console(stderr=stderr, force_terminal=None if is_terminal(sys.stderr if stderr else sys.stdout) else False)
