# SPDX-License-Identifier: MIT
"""The end of a run in which one rank has raised an exception that the others do not know of.

The interpreter of that rank ends, and the others wait for it in an exchange. `python3 -m mpi4py` aborts all ranks then,
but only after the functions of `atexit`. One of these ends PETSc, for which the ranks wait for each other: none ends.
Here the ranks are aborted before.
"""

import atexit
import sys

import petsc4py.PETSc  # noqa: F401  registers its function of atexit: the last one registered is called first
from mpi4py import MPI

from .collective import is_common


def _abort() -> None:
    """Abort all ranks if this one ends by an exception, unless all have raised it together."""
    error: BaseException | None = getattr(sys, "last_value", None)  # the one that nothing has caught
    interactive = hasattr(sys, "ps1")  # the last one of a session, which has gone on
    if error is None or interactive or MPI.Is_finalized() or is_common(MPI.COMM_WORLD, error):
        return
    sys.stdout.flush()
    sys.stderr.flush()
    MPI.COMM_WORLD.Abort(1)


def abort_at_exit() -> None:
    """Abort all ranks at the exit of one that ends by an exception of its own."""
    atexit.register(_abort)
