# SPDX-License-Identifier: MIT
"""Points that pass through their master within an increment: gaps along the straight path from its start."""

from collections.abc import Callable

import numpy as np
from mpi4py import MPI

from .. import _cpp
from ..common.types import BoolArray, FloatArray

# A path through an obstacle is followed in steps of the distance from it, which cannot miss it, but of no less than
# this part of the path where the distance is small.
LEAST_STEP = 1.0 / 1024
SAMPLES = 8  # states between start and end of an increment at which gaps against a deformable master are evaluated
# Depth, in slave facets, from which on a point that loses its master has passed through it: points that slide off the
# master's edge lie less deep, as contact holds them at its surface.
DEEP = 0.25


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

    def evaluate(x: FloatArray) -> tuple[FloatArray, FloatArray]:
        gap, normal, _ = obstacle.evaluate(np.ascontiguousarray(x).ravel())
        return gap, normal

    gap, normal = evaluate(end)
    passed = np.zeros(len(end), dtype=bool)
    length = np.linalg.norm(end - start, axis=1)
    # A distance changes by no more than the way: most points cannot have touched the obstacle on it.
    rows = np.flatnonzero((gap + offset > tolerance) & (length > gap))
    if len(rows) == 0:
        return passed
    before, normal_before = evaluate(start[rows])
    far = np.einsum("na,na->n", normal_before, normal[rows]) < 0.0
    rows, place = rows[far], np.zeros(int(np.count_nonzero(far)))
    while len(rows):
        x = start[rows] + place[:, None] * (end - start)[rows]
        here, out = evaluate(x)
        enters = np.einsum("na,na->n", out, (end - start)[rows]) < 0.0
        inside = here + offset[rows] < np.where(enters, tolerance, -tolerance)
        passed[rows[inside]] = True
        place = place + np.maximum(here / length[rows], LEAST_STEP)
        going = ~inside & (place < 1.0)
        rows, place = rows[going], place[going]
    return passed


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
    if not comm.allreduce(int(np.any(suspects))):
        return np.zeros(len(suspects), dtype=bool)
    last: FloatArray = np.zeros(len(suspects))  # the last gap that a point has on its way
    for k in range(1, SAMPLES):
        gap = gap_at(k / SAMPLES)
        last = np.where(np.isfinite(gap), gap, last)
    return np.asarray(suspects & (last < -DEEP * sizes))


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
    mine = int(np.count_nonzero(passed)), x[passed][:1].tolist()
    found = comm.allgather(mine)
    number = sum(count for count, _ in found)
    if number == 0:
        return ""
    place = next(place[0] for count, place in found if count)
    return (
        f"{name}: {number} points have passed through the master in this increment and are open on its far side, one "
        f"is at ({', '.join(f'{c:.4g}' for c in place)})"
    )
