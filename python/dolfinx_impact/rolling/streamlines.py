# SPDX-License-Identifier: MIT
"""Derivative of nodal values along the flow of the material on a surface; docs/rolling.md."""

from __future__ import annotations

from typing import Any

import numpy as np
from dolfinx.fem import FunctionSpace
from petsc4py import PETSc

from .. import _cpp
from ..common.types import AnyArray, FloatArray, IntArray

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


class StreamlineDerivative:
    """The map u -> (Grad u) w at the nodes of surfaces, a matrix over the nodes of a space.

    The derivative at a node is taken on the facet from which the material comes (upwind), so that what a node feels
    depends on what lies upstream only, and sticking, a first-order equation along the streamline, has one solution. On
    meshes of degree 1 whose edges follow the flow it is the backward difference of the nodal values.

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
        index_map = self._V.dofmap.index_map
        parts = [part for facets in self._surfaces for part in _candidates(facets, w)]
        at = np.concatenate([np.zeros(0, dtype=np.int64), *(index_map.local_to_global(rows) for rows, *_ in parts)])
        scores = np.concatenate([np.zeros(0), *(score for _, score, *_ in parts)])
        share = self._shares(at, scores)
        rows, cols, values, start = [], [], [], 0
        for local, _, nodes, coefficients in parts:
            end = start + len(local)
            chosen = share[start:end] > 0.0
            rows.append(np.repeat(at[start:end][chosen], nodes.shape[1]))
            cols.append(index_map.local_to_global(np.ascontiguousarray(nodes[chosen].ravel())))
            values.append((coefficients[chosen] * share[start:end][chosen, None]).ravel())
            start = end
        return node_matrix(self._V, np.concatenate([at[:0], *rows]), np.concatenate([at[:0], *cols]),
                           np.concatenate([scores[:0], *values]))  # fmt: skip

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


def _candidates(facets: Any, w: FloatArray) -> list[tuple[AnyArray, FloatArray, IntArray, FloatArray]]:
    """For each local node of the facets: nodes, scores, nodes of the facet, coefficients of the derivative."""
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
        on_rim = normals @ xi - bounds < 1e-12
        rates = -along @ normals[on_rim].T
        total = np.abs(rates).sum(axis=1)
        moves = np.any(along != 0.0, axis=1)
        inward = rates.min(axis=1) / np.where(total > 0.0, total, 1.0) if on_rim.any() else np.ones(len(nodes))
        coefficients = along @ element.tabulate(*xi)[1 : 1 + tdim]
        found.append((nodes[:, i], np.where(moves, inward, -np.inf), nodes, np.where(moves[:, None], coefficients, 0.0)))
    return [(np.ascontiguousarray(a[np.isfinite(s)]), s[np.isfinite(s)], c[np.isfinite(s)], d[np.isfinite(s)])
            for a, s, c, d in found]  # fmt: skip
