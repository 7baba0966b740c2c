# SPDX-License-Identifier: MIT
"""The program that starts ranks of the MPI that this Python uses."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

NAMES = "mpirun", "mpiexec"


def mpi_launcher() -> str | None:
    """Program that starts ranks: the one beside Python, where a virtual environment or conda has its own MPI, else the
    one on the PATH.

    A launcher of another MPI would start processes that do not know of each other.

    Returns:
        Its path, or None if there is none.
    """
    own = str(Path(sys.executable).parent)
    return next((found for path in (own, None) for name in NAMES if (found := shutil.which(name, path=path))), None)


def on_ranks(number: int) -> list[str]:
    """Beginning of a command that runs on several ranks.

    Args:
        number: of ranks [1].

    Returns:
        The launcher with its arguments; nothing for one rank.
    """
    return [mpi_launcher() or NAMES[0], "-n", str(number)] if number > 1 else []
