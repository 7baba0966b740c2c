# SPDX-License-Identifier: MIT
"""Integrals of shape functions over the part of a flat facet outside a strip low < x < high: loads that end in facets.

Facets are given by their nodes' first coordinates (num_nodes, 1 or 2): intervals, triangles, or rectangles along axes.
"""

import itertools

import numpy as np
from scipy.spatial import ConvexHull


def _clipped(polygon, sign, offset):
    """Part of a convex polygon (or of an interval: two points) where sign * x <= offset, x the first coordinate."""
    kept = []
    for p, q in zip(polygon, np.roll(polygon, -1, axis=0)):
        a, b = (offset - sign * r[0] for r in (p, q))
        kept += [p] if a >= 0 else []
        kept += [p + (q - p) * a / (a - b)] if a * b < 0 else []
    return np.array(kept[:2] if len(polygon) == 2 else kept).reshape(-1, polygon.shape[1])


def _rule(polygon, num):
    """[(points, weights)] on a convex polygon (triangles of Gauss points that meet in a corner) or on an interval."""
    g, w = np.polynomial.legendre.leggauss(num)
    g, w = (g + 1) / 2, w / 2
    parts = []
    if polygon.shape[1] == 1:
        for a, b in [polygon] if len(polygon) == 2 else []:
            parts.append((a + np.outer(g, b - a), w * abs(b - a)))
    else:
        r, s = (a.ravel() for a in np.meshgrid(g, g, indexing="ij"))
        weights = np.outer(w * g, w).ravel()  # r is the distance from the corner, s goes across
        for i in range(1, len(polygon) - 1):
            a, b = polygon[i] - polygon[0], polygon[i + 1] - polygon[0]
            points = polygon[0] + np.outer(r * (1 - s), a) + np.outer(r * s, b)
            parts.append((points, weights * abs(a[0] * b[1] - a[1] * b[0])))
    return parts


class LoadedFacet:
    """Shape functions of one facet. nodes: (num_nodes, dim). degree: 1 or 2."""

    def __init__(self, nodes, degree):
        dim = nodes.shape[1]
        self.centre, self.size, self.num = nodes.mean(axis=0), np.ptp(nodes, axis=0), 2 * degree + 2
        powers = list(itertools.product(range(degree + 1), repeat=dim))
        if len(nodes) in (3, 6) and dim == 2:
            powers = [p for p in powers if sum(p) <= degree]
        self.powers = np.array(powers)
        self.coefficients = np.linalg.inv(self._monomials(nodes))
        self.corners = nodes[ConvexHull(nodes).vertices] if dim == 2 else np.array([nodes.min(0), nodes.max(0)])

    def _monomials(self, points):
        y = (points - self.centre) / self.size
        return np.prod(y[:, None, :] ** self.powers, axis=2)

    def _values(self, points):
        return self._monomials(points) @ self.coefficients

    def outside(self, low, high):
        """Integrals of the shape functions over the part outside the strip, (num_nodes)."""
        parts = _rule(_clipped(self.corners, 1, low), self.num) + _rule(_clipped(self.corners, -1, -high), self.num)
        return sum((self._values(x).T @ w for x, w in parts), np.zeros(len(self.coefficients)))

    def mass(self):
        """Integrals of products of the shape functions, (num_nodes, num_nodes)."""
        return sum((self._values(x).T * w) @ self._values(x) for x, w in _rule(self.corners, self.num))
