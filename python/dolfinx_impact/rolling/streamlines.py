# SPDX-License-Identifier: MIT
"""Derivative of nodal values along the flow of the material on a surface; docs/rolling.md."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from dolfinx.fem import FunctionSpace
from petsc4py import PETSc

from .. import _cpp
from ..common.types import FloatArray, IntArray

TIE = 1e-6  # scores that differ by less are the same: the streamline runs along the edge between two facets
# Gradients of the inequalities a . xi >= b of a reference facet, and b.
SIDES = {
    "interval": (np.array([[1.0], [-1.0]]), np.array([0.0, -1.0])),
    "triangle": (np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, -1.0]]), np.array([0.0, 0.0, -1.0])),
    "quadrilateral": (
        np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]]),
        np.array([0.0, -1.0, 0.0, -1.0]),
    ),
}


@dataclass
class Candidates:
    """Nodes of facets, each with one facet on which its derivative may be taken.

    Attributes:
        node: local numbers, (n).
        score: positive if the flow comes out of the facet; the largest are chosen, (n).
        facet: nodes of the facet, local numbers, (n, m).
        derivative: coefficients of (Grad u) w at the node, (n, m) [1/T].
        entry: values of the shape functions where the streamline enters the facet, (n, m).
        time: that the material takes from there to the node, zero where the flow does not come out of the facet,
            (n) [T].
    """

    node: IntArray
    score: FloatArray
    facet: IntArray
    derivative: FloatArray
    entry: FloatArray
    time: FloatArray


class StreamlineDerivative:
    """The map u -> (Grad u) w at the nodes of surfaces, a matrix over the nodes of a space.

    The derivative at a node is taken from where the material comes (upwind), so that what a node feels depends on what
    lies upstream only, and sticking, a first-order equation along the streamline, has one solution. It is of second
    order: on cells of degree 2 that of the facet upstream; on cells of degree 1 that of the parabola through three
    points of the streamline, which for edges along the flow is the three-point backward difference. Where the material
    enters the surface it is the slope of the first facet.

    Args:
        V: displacement space.
        surfaces: facets of the surfaces on this rank (C++ Facets).
    """

    def __init__(self, V: FunctionSpace, surfaces: list[Any]) -> None:
        self._V, self._surfaces = V, surfaces

    def matrix(self, w: FloatArray) -> PETSc.Mat:
        """Matrix of the derivative along a flow, (nodes, nodes) [1/T]. Collective.

        Args:
            w: velocity of the undeformed material through the mesh, (nodes, gdim), owned and ghosts [L/T].

        Returns:
            Matrix that the caller destroys; rows of nodes off the surfaces, or without flow, are zero.
        """
        V, index_map = self._V, self._V.dofmap.index_map
        none, nothing = np.zeros(0, dtype=np.int64), np.zeros(0)
        parts = [part for facets in self._surfaces for part in _candidates(facets, w)]
        at = np.concatenate([none, *(index_map.local_to_global(part.node) for part in parts)])
        share = self._shares(at, np.concatenate([nothing, *(part.score for part in parts)]))
        rows: list[IntArray] = [none]
        cols: list[IntArray] = [none]
        slopes: list[FloatArray] = [nothing]
        entries: list[FloatArray] = [nothing]
        times: list[FloatArray] = [nothing]
        start = 0
        for part in parts:
            end = start + len(part.node)
            chosen = share[start:end] > 0.0
            weight = share[start:end][chosen]
            rows.append(np.repeat(at[start:end][chosen], part.facet.shape[1]))
            cols.append(index_map.local_to_global(np.ascontiguousarray(part.facet[chosen].ravel())))
            slopes.append((part.derivative[chosen] * weight[:, None]).ravel())
            entries.append((part.entry[chosen] * weight[:, None]).ravel())
            times.append(share[start:end] * part.time)
            start = end
        place = np.concatenate(rows), np.concatenate(cols)
        slope = node_matrix(V, *place, np.concatenate(slopes))
        if _degree(self._V) > 1:
            return slope
        entry = node_matrix(V, *place, np.concatenate(entries))
        time = node_matrix(V, at, at, np.concatenate(times))
        return _through_three_points(slope, entry, time)

    def _shares(self, at: IntArray, scores: FloatArray) -> FloatArray:
        """Weight of each candidate in the mean over the best facets of its node, over all ranks. Collective."""
        gathered = self._V.mesh.comm.allgather((at, scores))
        everywhere, values = (np.concatenate(column) for column in zip(*gathered))
        nodes, place = np.unique(everywhere, return_inverse=True)
        best = np.full(len(nodes), -np.inf)
        np.maximum.at(best, place, values)
        count = np.bincount(place, weights=values >= best[place] - TIE, minlength=len(nodes))
        here = np.searchsorted(nodes, at)
        return np.where(scores >= best[here] - TIE, 1.0 / np.maximum(count[here], 1.0), 0.0)


def _degree(V: FunctionSpace) -> int:
    return int(V.element.basix_element.degree)


def _through_three_points(slope: PETSc.Mat, entry: PETSc.Mat, time: PETSc.Mat) -> PETSc.Mat:
    """Derivative of the parabola through a node, the point where its streamline enters the facet, and one more facet
    upstream: d1 + (d1 - d2) t1/(t1 + t2), from the slopes d and times t over both. Takes its arguments. Collective.

    Args:
        slope: slopes over the facets upstream of the nodes [1/T].
        entry: from nodal values to those where the streamlines enter these facets [1].
        time: diagonal matrix of the times on these facets [T].
    """
    before = entry.matMult(slope)
    t1, t2 = time.getDiagonal(), entry.createVecLeft()
    entry.mult(t1, t2)
    both = (t1.array_r > 0.0) & (t2.array_r > 0.0)
    factor = t1.duplicate()
    factor.array[:] = np.where(both, t1.array_r / np.where(both, t1.array_r + t2.array_r, 1.0), 0.0)
    before.diagonalScale(L=factor)
    factor.shift(1.0)
    slope.diagonalScale(L=factor)
    slope.axpy(-1.0, before, PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
    for thing in (before, entry, time, t1, t2, factor):
        thing.destroy()
    return slope


def node_matrix(V: FunctionSpace, rows: IntArray, cols: IntArray, values: FloatArray) -> PETSc.Mat:
    """Matrix over the nodes of a space from entries, which add up. Collective.

    Args:
        V: displacement space.
        rows: global numbers of nodes.
        cols: global numbers of nodes.
        values: entries.
    """
    owned = V.dofmap.index_map.size_local
    return _cpp.multipliers.coo_matrix(V.mesh.comm, owned, owned, rows, cols, np.ascontiguousarray(values))


def _vertex_functions(element: Any, places: FloatArray) -> FloatArray:
    """Shape functions of degree 1 of a facet, zero at the nodes between vertices, (n, nodes of the facet).

    Args:
        element: of the facet.
        places: reference coordinates, (n, tdim of the facet).
    """
    values = np.zeros((len(places), element.num_nodes))
    for k in range(element.num_nodes):
        corner = np.array(element.node(k))[: places.shape[1]]
        if not np.all((corner == 0.0) | (corner == 1.0)):
            continue
        if element.shape == "triangle":
            values[:, k] = places @ corner if corner.any() else 1.0 - places.sum(axis=1)
        else:
            values[:, k] = np.prod(np.where(corner == 1.0, places, 1.0 - places), axis=1)
    return values


def _candidates(facets: Any, w: FloatArray) -> list[Candidates]:
    """Candidates for each of the nodes that a facet has."""
    element, geometry, nodes, X = facets.displacement, facets.geometry, facets.nodes, facets.X
    tdim = 1 if element.shape == "interval" else 2
    normals, bounds = SIDES[element.shape]
    found = []
    for i in range(nodes.shape[1]):
        xi = np.array(element.node(i))[:tdim]
        J = np.einsum("ak,fkc->fca", geometry.tabulate(*xi)[1 : 1 + tdim], X)
        # Coordinates of w in the tangent plane: least squares, as w and a flat facet of a round body differ slightly.
        metric = np.einsum("fca,fcb->fab", J, J)
        along = np.linalg.solve(metric, np.einsum("fca,fc->fa", J, w[nodes[:, i]])[..., None])[..., 0]
        moves = np.any(along != 0.0, axis=1)
        along, local, facet = along[moves], nodes[moves, i], nodes[moves]
        distance = normals @ xi - bounds
        on_rim = distance < 1e-12
        rates = -along @ normals.T  # of the distances from the sides, against the flow
        total = np.abs(rates[:, on_rim]).sum(axis=1)
        score = np.ones(len(local))
        if on_rim.any():
            score = rates[:, on_rim].min(axis=1) / np.where(total > 0.0, total, 1.0)
        nearing = (rates < 0.0) & ~on_rim
        reached = np.where(nearing, distance / np.where(nearing, -rates, 1.0), np.inf).min(axis=1)
        time = np.where((score >= -TIE) & np.isfinite(reached), reached, 0.0)
        entry = _vertex_functions(element, xi - time[:, None] * along)
        found.append(
            Candidates(
                np.ascontiguousarray(local), score, facet, along @ element.tabulate(*xi)[1 : 1 + tdim], entry, time
            )
        )
    return found
