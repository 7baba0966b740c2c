# SPDX-License-Identifier: MIT
"""Derivative along the flow of material at the nodes of contact surfaces, taken on the facets upstream."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import rules
from .array_types import FloatArray, IntArray
from .discretisation import Discretisation
from .sparse import Csr

TIE = 1e-6  # scores that differ by less count as the same


def corner_neighbours(model: Discretisation, facets: IntArray) -> list[list[tuple[int, list[int]]]]:
    """Corners of facets, and the one or two corners at the ends of the edges that meet in each.

    Args:
        model: bodies of degree 1.
        facets: points of every facet, shape (num_facets, nodes per facet).

    Returns:
        For each facet a list of pairs (corner, neighbours).

    Raises:
        ValueError: the bodies are not of degree 1, or a facet belongs to no cell.
    """
    if model.degree != 1 or model.geometry_degree != 1:
        raise ValueError("the derivative along the flow is written for bodies of degree 1")
    if model.cell_type != "hexahedron":
        rows = [[int(p) for p in facet] for facet in facets]
        return [[(a, [b for b in facet if b != a]) for a in facet] for facet in rows]
    # Two corners of a hexahedron share an edge if one reference coordinate differs.
    places = rules.reference_nodes(model.cell_type, 1)
    edge = np.count_nonzero(np.abs(places[:, None] - places[None]) > 1e-12, axis=2) == 1
    cells_at: dict[int, list[int]] = {}
    for c, cell in enumerate(model.cells):
        for p in cell:
            cells_at.setdefault(int(p), []).append(c)
    result = []
    for facet in facets:
        points = [int(p) for p in facet]
        cells = set.intersection(*(set(cells_at[p]) for p in points))
        if len(cells) != 1:
            raise ValueError(f"facet {points} belongs to {len(cells)} cells: contact surfaces are on the boundary")
        cell = [int(p) for p in model.cells[cells.pop()]]
        local = {p: cell.index(p) for p in points}
        result.append([(a, [b for b in points if edge[local[a], local[b]]]) for a in points])
    return result


def upstream_score(coefficients: FloatArray) -> float:
    """How well a direction points into a facet from its corner.

    Args:
        coefficients: of the flow along the edges that meet in the corner, shape (1) or (2) [1/T].

    Returns:
        Positive if the direction against the flow points into the facet [1].
    """
    against = -coefficients
    size = float(np.sum(np.abs(against)))
    return float(np.min(against)) / size if size > 0.0 else 0.0


@dataclass
class Backward:
    """What one facet, or the mean of several, tells of the way that leads to a node.

    Attributes:
        slope: rate of change of nodal values over the way, factors by node [1/T].
        origin: weights by node of the values where the way begins, on the far side of the facet [1].
        duration: of the way; zero if it does not lie in the facet [T].
    """

    slope: dict[int, float]
    origin: dict[int, float]
    duration: float


def way_over_facet(a: int, others: list[int], far: int | None, c: FloatArray) -> Backward:
    """Follow the flow back from a corner, straight in the coordinates of the edges, to the far side of a facet.

    Args:
        a: the corner.
        others: corners at the ends of the edges that meet in it.
        far: the corner opposite to it; None if the facet has none.
        c: coefficients of the flow along these edges, shape (1) or (2) [1/T].

    Returns:
        The way.
    """
    slope = {b: float(value) for b, value in zip(others, c)}
    slope[a] = -float(np.sum(c))
    back = -c
    if upstream_score(c) < -TIE or not np.any(back > 0.0):
        return Backward(slope, {}, 0.0)
    if far is None:  # the far side of a triangle: both coordinates together make one
        duration = 1.0 / float(np.sum(back))
        return Backward(slope, {b: duration * float(value) for b, value in zip(others, back)}, duration)
    first = int(np.argmax(back))  # this coordinate reaches one before the other does
    duration = 1.0 / float(back[first])
    other = duration * float(back[1 - first])
    return Backward(slope, {others[first]: 1.0 - other, far: other}, duration)


def mean_way(ways: list[Backward]) -> Backward:
    """Mean of the ways over several facets."""
    n = len(ways)
    slope: dict[int, float] = {}
    origin: dict[int, float] = {}
    for way in ways:
        for total, part in ((slope, way.slope), (origin, way.origin)):
            for node, value in part.items():
                total[node] = total.get(node, 0.0) + value / n
    return Backward(slope, origin, sum(way.duration for way in ways) / n)


def derivative(model: Discretisation, facets: IntArray, w: FloatArray) -> Csr:
    """Matrix B of (Grad u w) at the nodes of a surface: the same for every component of u.

    Values along a streamline are those at the node, where it enters the facet upstream, and before that one facet
    more. B differentiates the parabola through them (Newton's divided differences); without a second facet, the line.

    Args:
        model: bodies of degree 1.
        facets: points of every facet, shape (num_facets, nodes per facet).
        w: flow at all nodes, shape (num_nodes, gdim) [L/T].

    Returns:
        Matrix, shape (num_nodes, num_nodes), with rows of zeros off the surface [1/T].
    """
    found: dict[int, list[tuple[float, Backward]]] = {}
    for k, corners in enumerate(corner_neighbours(model, facets)):
        for a, others in corners:
            edges = (model.points[others] - model.points[a]).T
            c = np.linalg.lstsq(edges, w[a], rcond=None)[0]
            if not np.any(c):
                continue
            opposite = [p for p in facets[k].tolist() if p != a and p not in others]
            # An interval is left at its other end, as a triangle without the second edge.
            way = way_over_facet(a, others, opposite[0] if opposite else None, c)
            found.setdefault(a, []).append((upstream_score(c), way))
    ways: dict[int, Backward] = {}
    for node, candidates in found.items():
        best = max(score for score, _ in candidates)
        ways[node] = mean_way([way for score, way in candidates if score >= best - TIE])
    indptr, indices, data = [0], [], []
    for node in range(len(model.points)):
        row: dict[int, float] = {}
        if node in ways:
            way = ways[node]
            row = dict(way.slope)
            earlier = sum(weight * ways[b].duration for b, weight in way.origin.items() if b in ways)
            if way.duration > 0.0 and earlier > 0.0:
                bend = way.duration / (way.duration + earlier)
                for b, value in way.slope.items():
                    row[b] += bend * value
                for b, weight in way.origin.items():
                    for k, value in ways[b].slope.items() if b in ways else ():
                        row[k] = row.get(k, 0.0) - bend * weight * value
        for column in sorted(row):
            indices.append(column)
            data.append(row[column])
        indptr.append(len(indices))
    return Csr(indptr, indices, data)


def add(A: Csr, B: Csr, factor: float = 1.0) -> Csr:
    """Sum of matrices of which each row is zero in one of them, times a factor.

    Args:
        A: matrix, shape (n, n).
        B: matrix, shape (n, n).
        factor: factor of the sum.

    Returns:
        factor (A + B), shape (n, n).

    Raises:
        ValueError: a row that neither leaves empty, as of surfaces that share a node.
    """
    lengths = np.diff(A.indptr), np.diff(B.indptr)
    if np.any((lengths[0] > 0) & (lengths[1] > 0)):
        raise ValueError("slave and master share a node")
    rows = np.concatenate([np.repeat(np.arange(len(n)), n) for n in lengths])
    order = np.argsort(rows, kind="stable")
    indices, data = (np.concatenate(pair)[order] for pair in ((A.indices, B.indices), (A.data, B.data)))
    return Csr(np.concatenate([[0], np.cumsum(sum(lengths))]), indices, factor * data)
