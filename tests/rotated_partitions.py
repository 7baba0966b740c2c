# SPDX-License-Identifier: MIT
"""Partitions that differ from mesh to mesh, on the ranks that checks share.

DOLFINx may partition the same mesh otherwise when it is made once more: SCOTCH does so once in some hundred times. A
check that compares arrays of two meshes then fails. Here it fails always: the parts of each further mesh that DOLFINx's
own partitioner makes go to the next rank.
"""

import functools
import itertools
import types

from dolfinx import cpp
from idle_rank import MAKERS

WRITTEN_IN_PYTHON = (types.FunctionType, types.MethodType, functools.partial)  # partitioners of a check's own


def rotate_partitions():
    """From now on, in this process. Called by all ranks."""
    from dolfinx_impact import compat

    turns = itertools.count()

    def rotated(partitioner):
        def partition(comm, num_ranks, *cells):
            found, turn = partitioner(comm, num_ranks, *cells), comm.bcast(next(turns))
            return compat.adjacencylist((found.array + turn) % num_ranks, found.offsets)

        return partition

    for name in MAKERS:
        make = getattr(cpp.mesh, name)

        def made(comm, *given, make=make):
            own = (callable(a) and not isinstance(a, WRITTEN_IN_PYTHON) for a in given)
            return make(comm, *(rotated(a) if right else a for a, right in zip(given, own)))

        setattr(cpp.mesh, name, made)
