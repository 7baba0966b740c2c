# SPDX-License-Identifier: MIT
"""One random cell at the quadrature points of a form: places, weights, gradients of shape functions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import basix
import basix.cell
import basix.ufl
import numpy as np

from dolfinx_impact.common.types import FloatArray

# Stress from the displacement gradient, both of shape (num_points, 3, 3); complex values are differentiated through.
Stress = Callable[[Any], Any]
STEP = 1e-30  # of complex differentiation, which has no cancellation


@dataclass
class Sample:
    """A cell, or a facet of it, at the points of a rule.

    Args:
        N: shape functions of the field, shape (num_points, num_nodes) [1].
        dN: their gradients, shape (num_points, num_nodes, 3); the third is zero in the plane [1/L].
        weights: weights times area or volume elements, shape (num_points) [L^dim].
        x: places, shape (num_points, gdim) [L].
        normal: outward normals on facets, shape (num_points, 3); zero in cells [1].
        dim: dimension of space.
    """

    N: FloatArray
    dN: FloatArray
    weights: FloatArray
    x: FloatArray
    normal: FloatArray
    dim: int

    def gradient(self, u: FloatArray, hoop: bool) -> FloatArray:
        """Displacement gradient in three dimensions.

        Args:
            u: displacement at the nodes, the component the fastest, shape (num_dofs) [L].
            hoop: whether u_r/r is its third diagonal entry.

        Returns:
            Gradients, shape (num_points, 3, 3) [1].
        """
        nodal = u.reshape(-1, self.dim)
        H = np.zeros((len(self.weights), 3, 3))
        H[:, : self.dim] = np.einsum("qnj,ni->qij", self.dN, nodal)
        if hoop:
            H[:, 2, 2] = self.N @ nodal[:, 0] / self.x[:, 0]
        return H

    def forces(self, P: Any, hoop: bool, weight: FloatArray) -> FloatArray:
        """Nodal forces of a stress.

        Args:
            P: stress, shape (num_points, 3, 3) [F/L^2].
            hoop: whether the test function has a hoop strain.
            weight: factor of the measure, shape (num_points).

        Returns:
            Forces, the component the fastest, shape (num_dofs).
        """
        w = self.weights * weight
        out = np.einsum("q,qij,qnj->ni", w, P[:, : self.dim], self.dN)
        if hoop:
            out[:, 0] += np.einsum("q,q,qn->n", w, P[:, 2, 2], self.N / self.x[:, :1])
        return out.ravel()

    def loads(self, t: FloatArray, weight: FloatArray) -> FloatArray:
        """Nodal forces of a load.

        Args:
            t: load, shape (num_points, 3).
            weight: factor of the measure, shape (num_points).

        Returns:
            Forces, the component the fastest, shape (num_dofs).
        """
        return np.asarray(np.einsum("q,qi,qn->ni", self.weights * weight, t[:, : self.dim], self.N)).ravel()


def sample(cell: str, degree: int, geometry_degree: int, X: FloatArray, rule: Any, facet: int | None = None) -> Sample:
    """A cell at the points of a rule of the compiler of forms.

    Args:
        cell: cell.
        degree: degree of the field.
        geometry_degree: degree of the geometry.
        X: nodes of the cell, shape (num_nodes, gdim) [L].
        rule: object with `points` and `weights` on the reference cell, or the reference facet.
        facet: local number of the facet; None: the cell.
    """
    points, weights = np.asarray(rule.points), np.asarray(rule.weights)
    dim, kind = X.shape[1], getattr(basix.CellType, cell)
    normal: FloatArray = np.zeros(dim)
    surface: FloatArray | None = None
    if facet is not None:
        corners = np.asarray(basix.geometry(kind))[basix.topology(kind)[-2][facet]]
        edges: FloatArray = corners[1:dim] - corners[0]
        points, surface = corners[0] + points @ edges, edges.T
        normal = np.asarray(basix.cell.facet_outward_normals(kind))[facet]
    geometry = basix.ufl.element("Lagrange", cell, geometry_degree).basix_element.tabulate(1, points)[..., 0]
    field = basix.ufl.element("Lagrange", cell, degree).basix_element.tabulate(1, points)[..., 0]
    J = np.einsum("jqn,ni->qij", geometry[1:], X)
    inverse = np.linalg.inv(J)
    dN = np.zeros((*field[0].shape, 3))
    dN[..., :dim] = np.einsum("jqn,qjk->qnk", field[1:], inverse)
    x = geometry[0] @ X
    outward = np.zeros((len(points), 3))
    if surface is None:
        size = np.abs(np.linalg.det(J))
    else:
        tangents = J @ surface
        size = np.sqrt(np.linalg.det(np.swapaxes(tangents, 1, 2) @ tangents))
        turned = np.einsum("qji,j->qi", inverse, normal)
        outward[:, :dim] = turned / np.linalg.norm(turned, axis=1)[:, None]
    return Sample(field[0], dN, weights * size, x, outward, dim)


def derivative(stress: Stress, H: FloatArray, direction: FloatArray) -> FloatArray:
    """Derivative of a stress in a direction, by a complex step.

    Args:
        stress: the law.
        H: displacement gradient, shape (num_points, 3, 3) [1].
        direction: change of it [1].
    """
    return np.asarray(np.imag(stress(H + 1j * STEP * direction)) / STEP)
