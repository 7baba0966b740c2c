# SPDX-License-Identifier: MIT
"""Checks that explicit and implicit problems have in common."""

from __future__ import annotations

import numpy as np
import ufl
from dolfinx import default_scalar_type, fem
from dolfinx.mesh import Mesh

from ..assembly.residual_bodies import ResidualBodies
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


def residual_bodies(mesh: Mesh, hypothesis: str | None, density: float | ufl.core.expr.Expr | None) -> ResidualBodies:
    """Bodies of a residual of a user's own, with inertia.

    Args:
        mesh: mesh of the displacement.
        hypothesis: hypothesis of the residual, or None.
        density: number, function or UFL expression [M/L^3].

    Returns:
        Bodies with density and hypothesis.

    Raises:
        TypeError: the density is none of these.
        ValueError: it is a number that is not positive; the hypothesis is unknown, or does not fit the mesh.
    """
    if isinstance(density, ufl.core.expr.Expr):
        return ResidualBodies(mesh, hypothesis, density)
    value = arguments.number("density", density, 0.0, " [M/L^3]")
    return ResidualBodies(mesh, hypothesis, fem.Constant(mesh, default_scalar_type(value)), value)
