# SPDX-License-Identifier: MIT
"""What Newton's method asks of a problem."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

from dolfinx.fem import Function, FunctionSpace
from petsc4py import PETSc

from ..common.types import BoolArray
from ..materials import MaterialMap, _Material
from .body import Body, BodyTangent
from .linear_solver import LinearSolver

if TYPE_CHECKING:
    from ..contact.mortar.lagrange import LagrangeContact
    from ..contact.penalty.quadrature_penalty import QuadraturePenalty


class EquilibriumProblem(Protocol):
    """Bodies and contacts in equilibrium: those of a static problem, or of one step of an implicit one.

    Attributes:
        u: displacement, the unknown [L].
        space: displacement space.
        material: material of the bodies; None for a residual of a user's own.
        axisymmetric: whether x is the radius.
        fixed: mask of prescribed degrees of freedom, owned and ghosts.
        num_owned: number of degrees of freedom that this rank owns [1].
        linear_solver: solver of the linear systems.
        keeps_multipliers: whether multipliers stay in the linear systems; otherwise they are condensed.
        exact_tangent: whether the part of the contact tangent that is not symmetric is in the matrix.
    """

    u: Function
    space: FunctionSpace
    material: _Material | MaterialMap | None
    axisymmetric: bool
    fixed: BoolArray
    num_owned: int
    linear_solver: LinearSolver
    keeps_multipliers: bool
    exact_tangent: bool

    @property
    def contact(self) -> Sequence[LagrangeContact | QuadraturePenalty]:
        """Contacts."""

    @property
    def body(self) -> Body:
        """Residual of the bodies and its tangent."""

    @property
    def tangent(self) -> BodyTangent:
        """Derivative of the bodies' residual."""

    def assemble_residual(self) -> PETSc.Vec:
        """Assemble the bodies' residual without contact; owned entries are complete [F]. Collective."""
