# SPDX-License-Identifier: MIT
"""Folders of checks on ranks."""

import contextlib
import tempfile
from pathlib import Path

from mpi4py import MPI


@contextlib.contextmanager
def shared_folder(comm=MPI.COMM_WORLD):
    """A folder that all ranks see, and that vanishes when all are done with it.

    When one rank raises, rank 0 removes it without waiting: the others may never come.
    """
    made = tempfile.TemporaryDirectory() if comm.rank == 0 else None
    try:
        yield Path(comm.bcast(made.name if made else None))
        comm.barrier()
    finally:
        if made:
            made.cleanup()
