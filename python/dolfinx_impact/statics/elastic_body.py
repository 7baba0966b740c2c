# SPDX-License-Identifier: MIT
"""Bodies without internal variables, and residuals of a user's own: assembled by DOLFINx."""

from __future__ import annotations

import dolfinx.fem.petsc as petsc
import ufl
from dolfinx import fem
from petsc4py import PETSc

from ..assembly.averaged_form import has_averages
from ..assembly.ffcx_form import ffcx_form
from ..common.described import Described
from ..assembly import operators
from .body import BodyTangent


class ElasticBody(Described):
    """Bodies whose forces follow from the present displacement alone; see Body.

    Args:
        u: displacement function [L].
        residual: UFL form of the internal minus the external forces, of rank 1.
        tangent: UFL form of its derivative, of rank 2.
        has_springs: whether springs to the ground may hold the bodies.

    Attributes:
        tangent: derivative of the residual.
        linear, keeps_tangent: see Body.
        symmetric: whether the tangent is symmetric, as far as is known.
        inelastic: False.
        has_inertia: False.
        has_springs: as given.
    """

    inelastic = False
    has_inertia = False

    def __init__(self, u: fem.Function, residual: ufl.Form, tangent: ufl.Form, has_springs: bool = False) -> None:
        # FFCx does not know averages over a cell; our kernels do.
        self._averaged = operators.InternalForce(residual) if has_averages(residual) else None
        vectors = ufl.inner(u, ufl.TestFunction(u.function_space)) * ufl.dx(degree=0)
        self._residual = ffcx_form(residual if self._averaged is None else vectors)
        self.tangent: BodyTangent = operators.Tangent(tangent)
        self.tangent.matrix.setOption(PETSc.Mat.Option.KEEP_NONZERO_PATTERN, True)
        self.symmetric, self.has_springs = True, has_springs
        # The tangent of linear materials is written without u. Derivatives contain u until they are expanded.
        self.keeps_tangent = not any(c is u for c in tangent.coefficients())
        expanded = ufl.algorithms.expand_derivatives(tangent)
        self.linear = not any(c is u for c in expanded.coefficients())

    @property
    def origin(self) -> None:
        """None: forces are measured from zero displacement."""
        return None

    def vector(self) -> PETSc.Vec:
        """Make a vector for the residual, with ghosts."""
        return petsc.create_vector(self._residual)

    def add_residual(self, b: PETSc.Vec) -> None:
        """Add internal minus external forces, on owned and ghost entries [F]. Collective.

        Args:
            b: vector with ghosts.
        """
        if self._averaged is None:
            petsc.assemble_vector(b, self._residual)
            return
        with b.localForm() as local:
            self._averaged.assemble(local.array)

    def fault(self) -> str:
        """An empty text: the forces can always be computed, though they may not be finite."""
        return ""

    def accept_step(self) -> None:
        """Nothing: there is no history."""
