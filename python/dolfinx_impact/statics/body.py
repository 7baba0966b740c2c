# SPDX-License-Identifier: MIT
"""What Newton's method asks of the bodies: residual, tangent, and the state that a step begins from."""

from __future__ import annotations

from typing import Protocol

from .. import _cpp
from ..contact.protocol import BodyTangent


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
    def tangent(self) -> BodyTangent:
        """Derivative of the residual."""
        ...

    def in_cpp(self) -> _cpp.solve.Body:
        """The bodies as Newton's method in C++ sees them."""
        ...
