# SPDX-License-Identifier: MIT
"""Slave nodes that multipliers cannot push out of the master, because their displacement is prescribed."""

from typing import Any

import numpy as np
from mpi4py import MPI

from ...common.types import BoolArray

LEAST = 1e-9  # of the bodies' size: overlaps below it are round-off of prescribed displacements


def prescribed_overlap(name: str, comm: MPI.Comm, geometry: Any, prescribed: BoolArray, depth: float) -> str:
    """A sentence about nodes that are prescribed along the normal and lie in the master, deeper than any point did
    before anything was loaded (that is told when a problem is made); empty without any. Collective.

    Args:
        name: of the pair.
        comm: communicator of the mesh.
        geometry: at a converged state.
        prescribed: mask of its nodes, (n).
        depth: of the initial penetration [L].
    """
    gap = np.where(prescribed & np.isfinite(geometry.gap), geometry.gap, 0.0)
    deepest = int(np.argmin(gap)) if len(gap) else None
    mine = (0, 0.0, None)
    if deepest is not None:
        number = int(np.count_nonzero(gap < -LEAST * geometry.size - depth))
        mine = number, float(gap[deepest]), geometry.points[deepest].round(9).tolist()
    counts, gaps, places = zip(*comm.allgather(mine))
    if not sum(counts):
        return ""
    worst = int(np.argmin(gaps))
    return (
        f"{name}: {sum(counts)} slave nodes are prescribed along the normal and lie in the master, the deepest by "
        f"{-gaps[worst]:.3e} at {places[worst]}: contact cannot move them. Where the master is free to give way, "
        "exchange slave and master; where it is prescribed too, the prescribed displacements of the two bodies "
        "overlap: change them"
    )
