# SPDX-License-Identifier: MIT
"""Points that pass through their master within an increment: gaps along the straight path from its start."""

from collections.abc import Callable

import numpy as np
from mpi4py import MPI

from .. import _cpp
from ..common.types import BoolArray, FloatArray


def through_obstacle(
    obstacle: _cpp.gap.Rigid, start: FloatArray, end: FloatArray, offset: FloatArray, tolerance: float
) -> BoolArray:
    """Points that are open on the far side of a rigid obstacle, through which their paths lead.

    Args:
        obstacle: the obstacle at the end of the increment.
        start: positions at the start, less the obstacle's motion since then, (n, gdim) [L].
        end: positions at the end, (n, gdim) [L].
        offset: added to gaps, (n) [L].
        tolerance: gaps below it are none [L].

    Returns:
        Mask, (n).
    """
    passed = _cpp.gap.through_obstacle(obstacle, np.ravel(start), np.ravel(end), offset, tolerance)
    return np.asarray(passed != 0)


def through_master(
    comm: MPI.Comm, suspects: BoolArray, sizes: FloatArray, gap_at: Callable[[float], FloatArray]
) -> BoolArray:
    """Points without master at the end of an increment that have passed through it. Collective.

    Args:
        comm: communicator of the mesh.
        suspects: points that had a master at the start and have none at the end, mask (n).
        sizes: sizes of the points' facets, (n) [L].
        gap_at: gaps at a fraction of the increment, infinite without master, (n) [L]. Collective.

    Returns:
        Mask, (n).
    """
    return np.asarray(_cpp.gap.through_master(comm, suspects.astype(np.int8), sizes, gap_at) != 0)


def describe(name: str, comm: MPI.Comm, x: FloatArray, passed: BoolArray) -> str:
    """Describe points that have passed through their master. Collective.

    Args:
        name: name of the pair.
        comm: communicator of the mesh.
        x: positions of the points, (n, gdim) [L].
        passed: mask of those that have passed, (n).

    Returns:
        A sentence; empty without such points.
    """
    return str(_cpp.gap.describe_crossing(name, comm, x.shape[1], np.ravel(x), passed.astype(np.int8)))
