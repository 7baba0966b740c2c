# SPDX-License-Identifier: MIT
"""Largest and smallest numbers of all ranks, of which some may have none."""

import numpy as np
from mpi4py import MPI


def largest(values, comm=MPI.COMM_WORLD):
    """Largest of the numbers of all ranks, -inf if there are none. Collective."""
    return comm.allreduce(float(np.max(values, initial=-np.inf)), MPI.MAX)


def smallest(values, comm=MPI.COMM_WORLD):
    """Smallest of the numbers of all ranks, inf if there are none. Collective."""
    return comm.allreduce(float(np.min(values, initial=np.inf)), MPI.MIN)
