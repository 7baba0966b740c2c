# SPDX-License-Identifier: MIT
"""What Newton's method asks of the bodies: residual, tangent, and the state that a step begins from."""

from __future__ import annotations

from typing import Protocol

from petsc4py import PETSc

from ..common.types import FloatArray


class BodyTangent(Protocol):
    """Matrix of the bodies, made once."""

    @property
    def matrix(self) -> PETSc.Mat:
        """The matrix [F/L]."""
        ...

    def assemble(self) -> PETSc.Mat:
        """Assemble the matrix at the present state. Collective."""
        ...


class Body(Protocol):
    """Bodies of a problem.

    Attributes:
        linear: whether the tangent does not depend on the displacement, so that one serves an increment.
        keeps_tangent: whether it is that of linear materials alone, so that one serves all steps: loads and residuals
            of a user's own may contain what changes with time.
        symmetric: whether the tangent is symmetric, as far as is known.
        inelastic: whether a body has internal variables.
        has_inertia: whether inertia holds the bodies, so that they need no supports.
        has_springs: whether springs to the ground may hold them.
    """

    linear: bool
    keeps_tangent: bool
    symmetric: bool
    inelastic: bool
    has_inertia: bool
    has_springs: bool

    @property
    def origin(self) -> FloatArray | None:
        """Displacements from which Newton's method measures how large forces are, over owned degrees of freedom; None:
        from zero [L]."""

    @property
    def tangent(self) -> BodyTangent:
        """Derivative of the residual."""
        ...

    def vector(self) -> PETSc.Vec:
        """Make a vector for the residual, with ghosts."""
        ...

    def add_residual(self, b: PETSc.Vec) -> None:
        """Add internal minus external forces at the present displacement, on owned and ghost entries [F]. Collective.

        Args:
            b: vector with ghosts.
        """
        ...

    def fault(self) -> str:
        """Why the last residual could not be computed; an empty text if it could. Collective."""
        ...

    def accept_step(self) -> None:
        """Take the state of the last residual as the one that the next step begins from."""
        ...
