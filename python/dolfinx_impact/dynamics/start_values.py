# SPDX-License-Identifier: MIT
"""Checks that explicit and implicit problems have in common."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import ufl
from dolfinx import fem

from ..assembly.residual_bodies import ResidualBodies
from ..assembly.fields import Density, densities, same_spaces
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
    if not same_spaces(W, V):
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


def residual_bodies(
    V: fem.FunctionSpace, hypothesis: str | None, density: float | ufl.core.expr.Expr | Sequence[Any] | None
) -> ResidualBodies:
    """Bodies of a residual of a user's own, with inertia.

    Args:
        V: space of the displacement.
        hypothesis: hypothesis of the residual, or None.
        density: number, function or UFL expression, or a list of them [M/L^3].

    Returns:
        Bodies with density and hypothesis.

    Raises:
        TypeError: the density is none of these.
        ValueError: it is a number that is not positive, or a mixed space has not one for each field; the hypothesis is
            unknown, or does not fit the mesh.
    """
    found: Density = densities(density, V)
    value = found.value.item() if isinstance(found, fem.Constant) and not isinstance(density, fem.Constant) else None
    return ResidualBodies(V.mesh, hypothesis, found, value)
