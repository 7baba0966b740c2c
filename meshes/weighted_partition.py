# SPDX-License-Identifier: MIT
"""Cells to ranks by recursive bisection: equal weights, where some cells cost more than others."""

import numpy as np

from dolfinx_impact import compat


def bisect(points, weights, num_parts):
    """Part of each point: cut across the longest side of the box around them until there are enough parts.

    points: (n, dim); weights: (n), not negative; num_parts: of any number, not only powers of two.
    """
    part = np.zeros(len(points), dtype=np.int32)
    pieces = [(np.arange(len(points)), 0, num_parts)]
    while pieces:
        chosen, first, count = pieces.pop()
        if count == 1:
            part[chosen] = first
            continue
        fewer = count // 2
        axis = int(np.argmax(np.ptp(points[chosen], axis=0))) if len(chosen) else 0
        chosen = chosen[np.argsort(points[chosen, axis], kind="stable")]
        sums = np.cumsum(weights[chosen])
        # Every part needs a cell, whatever the weights are.
        cut = int(np.searchsorted(sums, sums[-1] * fewer / count)) if len(chosen) else 0
        cut = min(max(cut, min(fewer, len(chosen))), max(len(chosen) - (count - fewer), 0))
        pieces += [(chosen[:cut], first, fewer), (chosen[cut:], first + fewer, count - fewer)]
    return part


def partitioner(x, weight):
    """Partitioner for dolfinx.mesh.create_mesh, for meshes whose cells are all on one rank.

    x: nodes on that rank, (n, 3); weight: function of the midpoints of cells, (n, 3) -> (n). No ghost cells.
    """

    def part(comm, num_parts, cell_types, cells):
        corners = {"triangle": 3, "quadrilateral": 4, "tetrahedron": 4, "hexahedron": 8}[cell_types[0].name]
        middles = x[np.asarray(cells[0]).reshape(-1, corners)].mean(axis=1).reshape(-1, 3)
        found = bisect(middles, np.asarray(weight(middles), dtype=float), num_parts)
        return compat.adjacencylist(found, np.arange(len(found) + 1, dtype=np.int32))

    return part
