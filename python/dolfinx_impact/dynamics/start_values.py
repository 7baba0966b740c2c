# SPDX-License-Identifier: MIT
"""Checks that explicit and implicit problems have in common."""

from __future__ import annotations

import numpy as np
import ufl
from dolfinx import default_scalar_type, fem
from dolfinx.mesh import Mesh

from ..common import arguments


def check_velocity(velocity: fem.Function | None, u: fem.Function) -> None:
    """Check the initial velocity of a problem on this rank; for use under a guard.

    Args:
        velocity: the argument; None: at rest [L/T].
        u: displacement function [L].

    Raises:
        TypeError: it is no function.
        ValueError: it is on another space, or not finite.
    """
    if velocity is None:
        return
    arguments.function("velocity", velocity)
    if velocity is u:
        raise ValueError("displacement and velocity are one function: give two")
    V, W = u.function_space, velocity.function_space
    if W.element != V.element or W.mesh != V.mesh:
        raise ValueError("the velocity is on another space than the displacement")
    if not all(np.all(np.isfinite(f.x.array)) for f in (u, velocity)):
        raise ValueError("displacement or velocity at the start is not a number")


def velocity_or_rest(velocity: fem.Function | None, u: fem.Function) -> fem.Function:
    """Initial velocity as a function. Collective.

    Args:
        velocity: the argument, checked; None: at rest [L/T].
        u: displacement function [L].

    Returns:
        `velocity`, or a new function that is zero.
    """
    return fem.Function(u.function_space) if velocity is None else velocity


def density_expression(density: float | ufl.core.expr.Expr | None, mesh: Mesh) -> ufl.core.expr.Expr:
    """Density of a residual of a user's own in UFL.

    Args:
        density: number, function or UFL expression [M/L^3].
        mesh: mesh of the displacement.

    Returns:
        Expression or constant [M/L^3].

    Raises:
        TypeError: it is neither.
        ValueError: a number that is not positive.
    """
    if isinstance(density, ufl.core.expr.Expr):
        return density
    return fem.Constant(mesh, default_scalar_type(arguments.number("density", density, 0.0, " [M/L^3]")))
