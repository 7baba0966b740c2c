# SPDX-License-Identifier: MIT
"""Equations of one implicit step, as Newton's method sees them; statics.equilibrium_problem.EquilibriumProblem."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from dolfinx.fem import Function
from petsc4py import PETSc

from ...common.described import Described
from ...common.types import BoolArray
from ...contact.mortar.shared_nodes import connect
from ...materials import MaterialMap, _Material
from ...statics.bodies import assemble_residual
from ...statics.linear_solver import LinearSolver
from .moving_body import MovingBody

if TYPE_CHECKING:
    from ...contact.mortar.lagrange import LagrangeContact
    from ...contact.penalty.quadrature_penalty import QuadraturePenalty


class StepEquations(Described):
    """Bodies with inertia, supports and contacts at the end of a step.

    Args:
        u: displacement function [L].
        material: material of the bodies; None for a residual of a user's own.
        axisymmetric: whether x is the radius.
        body: bodies with inertia.
        contact: contacts.
        fixed: mask of prescribed degrees of freedom, owned and ghosts.
        options: PETSc options, as for StaticProblem.
        prefix: prefix of PETSc options on the command line.

    Attributes: as those of EquilibriumProblem.
    """

    def __init__(
        self,
        u: Function,
        material: _Material | MaterialMap | None,
        axisymmetric: bool,
        body: MovingBody,
        contact: Sequence[LagrangeContact | QuadraturePenalty],
        fixed: BoolArray,
        options: dict[str, Any] | None,
        prefix: str,
    ) -> None:
        V = u.function_space
        self.u, self.space, self.material, self.axisymmetric = u, V, material, axisymmetric
        self.body, self.contact, self.fixed = body, contact, fixed
        self.num_owned: int = V.dofmap.index_map.size_local * V.dofmap.index_map_bs
        shared = connect(contact)
        self.keeps_multipliers = shared or any(getattr(c, "basis", "dual") != "dual" for c in contact)
        self.linear_solver = LinearSolver(V, options, prefix, indefinite=self.keeps_multipliers)
        self.exact_tangent = self.linear_solver.direct
        self._b = body.vector()

    @property
    def tangent(self) -> MovingBody:
        """Derivative of the bodies' residual."""
        return self.body

    def assemble_residual(self) -> PETSc.Vec:
        """Assemble inertia, damping and internal minus external forces; owned entries are complete [F]. Collective."""
        return assemble_residual(self.u, self.body, self._b)
