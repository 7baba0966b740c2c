# SPDX-License-Identifier: MIT
"""What Newton's method asks of the bodies: residual, tangent, and the state that a step begins from."""

from __future__ import annotations

from typing import Protocol

from .. import _cpp
from ..contact.protocol import BodyTangent


class Body(Protocol):
    """Bodies of a problem.

    Attributes:
        properties: what is known of them beforehand.
        tangent: derivative of the residual.
    """

    @property
    def properties(self) -> _cpp.solve.BodyProperties:
        """What is known of them beforehand, as the linearity of the tangent."""
        ...

    @property
    def tangent(self) -> BodyTangent:
        """Derivative of the residual."""
        ...

    def in_cpp(self) -> _cpp.solve.Body:
        """The bodies as Newton's method in C++ sees them."""
        ...
