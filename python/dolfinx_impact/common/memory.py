# SPDX-License-Identifier: MIT
"""Memory that problems leave behind."""

import gc

from mpi4py import MPI
from petsc4py import PETSc

# From this number of unknowns a collection, 0.1 to 0.2 s, is short beside the set-up of a problem.
MANY = 50_000


def free_garbage(comm: MPI.Intracomm, unknowns: int) -> None:
    """Free what problems of this mesh that are no longer used have left. Collective.

    A problem and its contacts know each other, so that only Python's collector finds out that nobody else does; it
    counts objects, not their bytes, and may let gigabytes of factors wait. On several ranks PETSc's objects that Python
    has let go of wait for a call that all ranks make.

    Args:
        comm: communicator of the mesh.
        unknowns: of the problem that needs memory, on all ranks [1].
    """
    if unknowns >= MANY:
        gc.collect()
    PETSc.garbage_cleanup(comm)
