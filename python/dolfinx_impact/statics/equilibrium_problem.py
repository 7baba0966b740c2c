# SPDX-License-Identifier: MIT
"""What Newton's method asks of a problem."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

from dolfinx.fem import Function, FunctionSpace

from ..common.types import BoolArray
from .linear_solver import LinearSolver

if TYPE_CHECKING:
    from ..contact.mortar.lagrange import LagrangeContact
    from ..contact.penalty.quadrature_penalty import QuadraturePenalty


class EquilibriumProblem(Protocol):
    """Bodies and contacts in equilibrium: those of a static problem, or of one step of an implicit one.

    Attributes:
        u: displacement, the unknown [L].
        space: displacement space.
        fixed: mask of prescribed degrees of freedom, owned and ghosts.
        num_owned: number of degrees of freedom that this rank owns [1].
        linear_solver: solver of the linear systems.
    """

    u: Function
    space: FunctionSpace
    fixed: BoolArray
    num_owned: int
    linear_solver: LinearSolver

    @property
    def contact(self) -> Sequence[LagrangeContact | QuadraturePenalty]:
        """Contacts."""

    @property
    def equilibrium(self) -> Any:
        """The problem as C++ sees it, EquilibriumProblem (C++)."""
