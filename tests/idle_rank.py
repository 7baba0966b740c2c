# SPDX-License-Identifier: MIT
"""Meshes of which one rank owns no cell, as with more ranks than cells: for a whole run of the checks on ranks.

`IMPACT_IDLE_RANK=N pytest ...` gives the cells of rank N (-1: the last one) to the next rank, whatever mesh a check
makes on several ranks and whatever partitioner it names.
"""

import os

import numpy as np
from dolfinx import cpp

VARIABLE = "IMPACT_IDLE_RANK"
MAKERS = ("create_mesh", "create_interval_float64", "create_rectangle_float64", "create_box_float64")


def without(idle, partitioner):
    """A partitioner whose parts are those of another one, but that of the idle rank goes to the next rank."""

    from dolfinx_impact import compat

    def partition(comm, num_ranks, cell_types, cells):
        found = partitioner(comm, num_ranks, cell_types, cells)
        if num_ranks == 1:
            return found
        array, offsets = np.asarray(found.array), np.asarray(found.offsets)
        rank = idle % num_ranks
        array = np.where(array == rank, (rank + 1) % num_ranks, array).astype(np.int32)
        rows = [list(dict.fromkeys(row.tolist())) for row in np.split(array, offsets[1:-1])] if len(offsets) > 1 else []
        ends = np.cumsum([0, *map(len, rows)], dtype=np.int32)
        return compat.adjacencylist(np.array([r for row in rows for r in row], dtype=np.int32), ends)

    return partition


def keep_idle(rank):
    """From now on this process makes meshes of which a rank has no cell."""
    for name in MAKERS:
        make = getattr(cpp.mesh, name)

        def made(comm, *given, make=make):
            return make(comm, *(without(rank, a) if callable(a) else a for a in given))

        setattr(cpp.mesh, name, made)


def working_ranks(comm):
    """How many ranks have cells, as far as the environment has a say."""
    return max(comm.size - bool(os.environ.get(VARIABLE)), 1)


def keep_idle_as_asked():
    """As the environment says; nothing without the variable."""
    if os.environ.get(VARIABLE):
        keep_idle(int(os.environ[VARIABLE]))
