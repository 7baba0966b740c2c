# SPDX-License-Identifier: MIT
"""Dilatation of inelastic parts, projected on constants or linear functions of each cell, as a field of its own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem import Function

from .ffcx_form import ffcx_form
from ..common.types import FloatArray
from ..forms.materials import weight
from .inelastic_part import InelasticPart


class ProjectedDilatation:
    """A space of projected dilatations, with an orthonormal basis in each cell.

    The basis is 1 and, where parts project on linear functions, L^-1 (x - centre) with L L^T the mean of
    (x - centre) (x - centre)^T. Means are those of the parts' quadrature rule and weight, so that a coefficient of the
    projection of f is the mean of f times its basis function.

    Args:
        parts: inelastic parts whose dilatation is projected; all have one displacement.

    Attributes:
        space: one coefficient per cell, or one and as many as dimensions.
        volumes: volume that belongs to each coefficient on this rank, 1 where there is none [L^dim].
    """

    def __init__(self, parts: Sequence[InelasticPart]) -> None:
        self._parts, mesh = list(parts), parts[0].mesh
        dim = mesh.geometry.dim
        self._linear = any(part.kinematics.linear for part in parts)
        self.space = fem.functionspace(mesh, ("DG", 0, (1 + dim,)) if self._linear else ("DG", 0))
        if self._linear:
            self._centre = Function(fem.functionspace(mesh, ("DG", 0, (dim,))), name="centre")
            self._inverse = Function(fem.functionspace(mesh, ("DG", 0, (dim, dim))), name="inverse_radius")
            self._find_basis()
        q = ufl.TestFunction(self.space)
        ones = [(part, self._used(part, q)) for part in parts]
        self.volumes = _integral(sum(weight(p.mesh, p.kinematics.hypothesis) * one * p.dx for p, one in ones))
        self.volumes[self.volumes == 0.0] = 1.0

    def _used(self, part: InelasticPart, q: Any) -> Any:
        """Sum of the coefficients that a part has."""
        if not self._linear:
            return q
        return sum(q[i] for i in range(len(q) if part.kinematics.linear else 1))

    def value(self, part: InelasticPart, coefficients: Any) -> Any:
        """Value of a projected dilatation in the cells of a part.

        Args:
            part: one of the parts.
            coefficients: function, test or trial function of the space.
        """
        if not self._linear:
            return coefficients
        if not part.kinematics.linear:
            return coefficients[0]
        basis = self._inverse * (ufl.SpatialCoordinate(part.mesh) - self._centre)
        return coefficients[0] + sum(coefficients[1 + i] * basis[i] for i in range(len(basis)))

    def _find_basis(self) -> None:
        """Centres of the cells and inverses of the Cholesky factors."""
        parts = [part for part in self._parts if part.kinematics.linear]
        mesh = parts[0].mesh
        dim, x = mesh.geometry.dim, ufl.SpatialCoordinate(mesh)

        def mean(value: Any, f: Function) -> FloatArray:
            q, r = ufl.TestFunction(f.function_space), [weight(mesh, p.kinematics.hypothesis) for p in parts]
            volume = _integral(sum(w * ufl.inner(_ones(q), q) * p.dx for w, p in zip(r, parts)))
            volume[volume == 0.0] = 1.0
            return _integral(sum(w * ufl.inner(value, q) * p.dx for w, p in zip(r, parts))) / volume

        self._centre.x.array[:] = mean(x, self._centre)
        self._centre.x.scatter_forward()
        y = x - self._centre
        squares = mean(ufl.outer(y, y), self._inverse).reshape(-1, dim, dim)
        squares[np.trace(squares, axis1=1, axis2=2) == 0.0] = np.eye(dim)  # cells of other parts
        self._inverse.x.array[:] = np.linalg.inv(np.linalg.cholesky(squares)).ravel()
        self._inverse.x.scatter_forward()


def _ones(q: Any) -> Any:
    """Tensor of ones of the shape of q."""
    shape = q.ufl_shape
    return ufl.as_tensor(np.ones(shape).tolist())


def _integral(form: Any) -> FloatArray:
    """Entries of a form of rank 1 on this rank."""
    values: FloatArray = fem.assemble_vector(ffcx_form(form)).array.copy()
    return values
