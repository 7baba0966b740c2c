# SPDX-License-Identifier: MIT
"""Cells to ranks by recursive coordinate bisection: equal costs, where some cells cost more than others.

Berger and Bokhari (1987), A partitioning strategy for nonuniform problems on multiprocessors, IEEE Trans. Comput. C-36.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from mpi4py import MPI

from .. import compat
from ..common.types import FloatArray, IntArray

# Coordinates that differ by less than this share of the box are the same: those of a plane of midpoints differ by
# round-off, some 1e-16, and cells are larger than a millionth of a body.
SAME = 1e-9

Cost = Callable[[FloatArray], FloatArray]  # of the midpoints of cells, (n, 3) -> (n)


def bisect(points: FloatArray, weights: FloatArray, num_parts: int) -> IntArray:
    """Part of each point: cut across the longest side of the box around them until there are enough parts.

    Of points in one plane across that side, those that the cut divides are next to each other as well.

    Args:
        points: any points, (n, dim).
        weights: of the points, not negative, (n).
        num_parts: of any number, not only powers of two.

    Returns:
        Parts, 0 to num_parts - 1, (n); each has a point, if there are enough of them.
    """
    part = np.zeros(len(points), dtype=np.int32)
    pieces: list[tuple[IntArray, int, int]] = [(np.arange(len(points)), 0, num_parts)]
    while pieces:
        chosen, first, count = pieces.pop()
        if count == 1:
            part[chosen] = first
            continue
        fewer = count // 2
        if len(chosen):
            chosen = chosen[_along_box(points[chosen])]
        sums = np.concatenate([[0.0], np.cumsum(weights[chosen])])
        cut = int(np.searchsorted(sums, sums[-1] * fewer / count))
        if cut > 0 and sums[cut] + sums[cut - 1] > 2 * sums[-1] * fewer / count:
            cut -= 1  # which is nearer to the share
        # Every part needs a point, whatever the weights are.
        cut = min(max(cut, min(fewer, len(chosen))), max(len(chosen) - (count - fewer), 0))
        pieces += [(chosen[:cut], first, fewer), (chosen[cut:], first + fewer, count - fewer)]
    return part


def _along_box(points: FloatArray) -> IntArray:
    """Order of points along the longest side of the box around them, in planes across it along the next one."""
    lengths = np.ptp(points, axis=0)
    unit = SAME * max(float(lengths.max()), np.finfo(float).tiny)
    steps = np.rint((points - points.min(axis=0)) / unit).astype(np.int64)
    return np.lexsort([steps[:, axis] for axis in np.argsort(lengths, kind="stable")])


def partitioner(x: FloatArray, cost: Cost) -> Callable[..., Any]:
    """Partitioner for dolfinx.mesh.create_mesh, for meshes whose cells are all on one rank. No ghost cells.

    Args:
        x: nodes on that rank, (n, 3) [L].
        cost: of cells, by their midpoints.
    """

    def part(comm: MPI.Comm, num_parts: int, cell_types: Any, cells: Any) -> Any:
        corners = {"triangle": 3, "quadrilateral": 4, "tetrahedron": 4, "hexahedron": 8}[cell_types[0].name]
        middles = x[np.asarray(cells[0]).reshape(-1, corners)].mean(axis=1).reshape(-1, 3)
        return one_rank_each(bisect(middles, np.asarray(cost(middles), dtype=float), num_parts))

    return part


def one_rank_each(ranks: IntArray) -> Any:
    """What a partitioner returns for cells that go to one rank each, without ghosts.

    Args:
        ranks: of the cells, (n).
    """
    return compat.adjacencylist(ranks, np.arange(len(ranks) + 1, dtype=np.int32))
