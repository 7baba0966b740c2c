# SPDX-License-Identifier: MIT
"""Friction whose coefficient depends on velocity, and friction that depends on the direction."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import ufl

from ..common.arguments import number
from .law import TANGENTIAL, InterfaceLaw, InterfaceUpdate, Part


def falling_friction(static: float, kinetic: float, velocity: float) -> Part:
    """Coefficient that falls from a static to a kinetic value: mu_k + (mu_s - mu_k) exp(-|v|/v_c).

    Args:
        static: mu_s, at rest [1].
        kinetic: mu_k, at large velocities [1].
        velocity: v_c, slip velocity that the difference falls to its e-th part at [L/T].

    Returns:
        A function for the argument `friction` of laws.

    Raises:
        TypeError: a value that is no number.
        ValueError: a value that is not positive.
    """
    mu_s, mu_k = number("static", static, 0.0, " [1]"), number("kinetic", kinetic, 0.0, " [1]")
    v_c = number("velocity", velocity, 0.0, " [L/T]")

    def coefficient(slip_rate: Any) -> Any:
        # Tiny beside v_c^2: it only keeps the derivative at rest a number.
        speed = ufl.sqrt(ufl.dot(slip_rate, slip_rate) + (1e-12 * v_c) ** 2)
        return mu_k + (mu_s - mu_k) * ufl.exp(-speed / v_c)

    return coefficient


def anisotropic_friction(
    stiffness: float, coefficients: Sequence[float], direction: Sequence[float], tangential: float | None = None
) -> InterfaceLaw:
    """Coulomb's law with an elliptic limit: (t_1/mu_1)^2 + (t_2/mu_2)^2 <= p^2.

    t_1 is the shear traction along a direction, t_2 that across it, both in the tangent plane. The slip is normal to
    the limit surface (Michalowski and Mroz 1978), so that it is not opposite to the traction in general; with equal
    coefficients the law is Coulomb's. The pressure is that of linear springs. In the plane it has no meaning.

    Args:
        stiffness: pressure per penetration [F/L^3].
        coefficients: mu_1 and mu_2 [1].
        direction: vector whose part in the tangent plane is the first direction, (3).
        tangential: shear traction per slip of sticking points; None: `stiffness` [F/L^3].

    Raises:
        TypeError: values that are no numbers.
        ValueError: values that are not positive, or no direction in space.
    """
    k = number("stiffness", stiffness, 0.0, " [F/L^3]")
    k_t = k if tangential is None else number("tangential", tangential, 0.0, " [F/L^3]")
    first, second = (number(f"coefficient {i + 1}", mu, 0.0, " [1]") for i, mu in enumerate(coefficients))
    axis = np.array(direction, dtype=float)
    if axis.shape != (3,) or not np.linalg.norm(axis) > 0.0:
        raise ValueError(f"direction is {direction}: a vector of three components that is not zero is needed")
    axis = axis / np.linalg.norm(axis)
    values = {"stiffness": k, "tangential": k_t, "first": first, "second": second}

    def respond(point: Any) -> InterfaceUpdate:
        P, n, multiplier = point.parameters, point.normal, point.unknown
        pressure = ufl.max_value(-P.stiffness * point.gap, 0)
        along = ufl.as_vector(list(axis)) - ufl.dot(ufl.as_vector(list(axis)), n) * n
        along = along / ufl.sqrt(ufl.dot(along, along))
        across = ufl.cross(n, along)
        trial = -P.tangential * (point.slip - point.history.slid)
        parts = [ufl.dot(trial, along) / P.first, ufl.dot(trial, across) / P.second]
        size = ufl.sqrt(parts[0] ** 2 + parts[1] ** 2)
        sticks = ufl.le(size, pressure)
        # t_i = trial_i/(1 + x/mu_i^2): the unknown x, tangential stiffness times the multiplier of the slip, is zero
        # where the point sticks. The limit is written for its reciprocal, which is nearly linear in x.
        scaled = ufl.sqrt(sum((s / (1 + multiplier / mu**2)) ** 2 for s, mu in zip(parts, (P.first, P.second))))
        limit = ufl.max_value(pressure, 1e-300)
        residual = ufl.conditional(sticks, multiplier, 1 - limit / scaled)
        t = [s * mu / (1 + multiplier / mu**2) for s, mu in zip(parts, (P.first, P.second))]
        open_ = ufl.le(pressure, 0)
        shear = ufl.conditional(open_, 0 * along, ufl.conditional(sticks, trial, t[0] * along + t[1] * across))
        return InterfaceUpdate(
            pressure,
            shear,
            energy=P.stiffness * ufl.min_value(point.gap, 0) ** 2 / 2 + ufl.dot(shear, shear) / (2 * P.tangential),
            history={"slid": point.slip + shear / P.tangential},
            sticks=sticks,
            residual=ufl.conditional(open_, multiplier, residual),
            start=ufl.as_ufl(0.0),
            scale=1.0,
        )

    return InterfaceLaw(
        response=respond,
        history={"slid": TANGENTIAL},
        unknown=(),
        parameters=values,
        name="anisotropic friction",
        only_in_space=True,
    )
