# SPDX-License-Identifier: MIT
"""Equations of one implicit step, as Newton's method sees them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from dolfinx.fem import Function

from ... import _cpp
from ...common.described import Described
from ...common.types import BoolArray
from ...contact.mortar.shared_nodes import connect
from ...statics.linear_solver import LinearSolver
from ...statics import newton

if TYPE_CHECKING:
    from ...contact.mortar.lagrange import LagrangeContact
    from ...contact.penalty.quadrature_penalty import QuadraturePenalty


class StepEquations(Described):
    """Bodies with inertia, supports and contacts at the end of a step.

    Args:
        u: displacement function [L].
        axisymmetric: whether x is the radius.
        body: bodies with inertia (C++).
        contact: contacts.
        fixed: mask of prescribed degrees of freedom, owned and ghosts.
        options: PETSc options, as for StaticProblem.
        prefix: prefix of PETSc options on the command line.

    Attributes:
        u, contact, fixed: as given.
        space: displacement space.
        num_owned: number of owned degrees of freedom [1].
        linear_solver: solver of the linear systems.
        equilibrium: the equations as C++ sees them.
    """

    def __init__(
        self,
        u: Function,
        axisymmetric: bool,
        body: Any,
        contact: Sequence[LagrangeContact | QuadraturePenalty],
        fixed: BoolArray,
        options: dict[str, Any] | None,
        prefix: str,
    ) -> None:
        V = u.function_space
        self.u, self.space, self.contact, self.fixed = u, V, contact, fixed
        self.num_owned: int = V.dofmap.index_map.size_local * V.dofmap.index_map_bs
        shared = connect(contact)
        keeps_multipliers = shared or any(getattr(c, "basis", "dual") != "dual" for c in contact)
        self.linear_solver = LinearSolver(V, options, prefix, indefinite=keeps_multipliers)
        self.equilibrium = _cpp.solve.EquilibriumProblem(
            u._cpp_object,
            body,
            [newton.contact_in_cpp(c) for c in contact],
            fixed,
            self.linear_solver._cpp_object,
            axisymmetric,
            keeps_multipliers,
            self.linear_solver.direct,
            newton.field_numbers(V),
        )
