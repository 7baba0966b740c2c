# SPDX-License-Identifier: MIT
"""Pressure over gap: linear, exponential, damped, and adhesive."""

from __future__ import annotations

from typing import Any

import ufl

from ..common.arguments import number
from .law import InterfaceLaw, Part

FAR = 40.0  # ranges at which the adhesion of `adhesion` is below round-off: exp(-40) is 4e-18


def linear_pressure(stiffness: float, friction: Part | float | None = None, **options: Any) -> InterfaceLaw:
    """Springs that only push: p = -k g where g < 0.

    Args:
        stiffness: pressure per penetration k [F/L^3].
        friction: Coulomb's coefficient, a number or a function, see InterfaceLaw; None: no friction [1].
        options: of InterfaceLaw; `tangential` is `stiffness` unless it is given.

    Raises:
        TypeError: a value that is no number.
        ValueError: a stiffness that is not positive.
    """
    k = number("stiffness", stiffness, 0.0, " [F/L^3]")
    return InterfaceLaw(
        pressure=lambda gap, parameters: ufl.max_value(-parameters.stiffness * gap, 0),
        energy=lambda gap, parameters: parameters.stiffness * ufl.min_value(gap, 0) ** 2 / 2,
        **_with_friction(friction, k, {"stiffness": k}, options),
    )


def exponential_pressure(
    pressure: float, clearance: float, friction: Part | float | None = None, **options: Any
) -> InterfaceLaw:
    """Exponential pressure-overclosure: p = p0/(e - 1) (1 - g/c) (exp(1 - g/c) - 1) where g < c.

    The pressure is p0 at zero gap and begins at the clearance c, with zero slope.

    Args:
        pressure: p0, at zero gap [F/L^2].
        clearance: c, gap at which the pressure begins [L].
        friction: Coulomb's coefficient, a number or a function, see InterfaceLaw; None: no friction [1].
        options: of InterfaceLaw; `tangential` is the slope of the pressure at zero gap unless it is given.

    Raises:
        TypeError: a value that is no number.
        ValueError: a value that is not positive.
    """
    p0 = number("pressure", pressure, 0.0, " [F/L^2]")
    c = number("clearance", clearance, 0.0, " [L]")
    e = float(ufl.exp(1.0))

    def of_gap(gap: Any, parameters: Any) -> Any:
        y = ufl.max_value(1 - gap / parameters.clearance, 0)
        return parameters.pressure / (e - 1) * y * (ufl.exp(y) - 1)

    def energy(gap: Any, parameters: Any) -> Any:
        y = ufl.max_value(1 - gap / parameters.clearance, 0)
        return parameters.pressure * parameters.clearance / (e - 1) * (ufl.exp(y) * (y - 1) + 1 - y**2 / 2)

    slope = p0 / c * (2 * e - 1) / (e - 1)
    values = {"pressure": p0, "clearance": c}
    return InterfaceLaw(pressure=of_gap, energy=energy, reach=c, **_with_friction(friction, slope, values, options))


def damped_contact(stiffness: float, damping: float, **options: Any) -> InterfaceLaw:
    """Springs and dampers that only push: p = max(-k g - c g', 0) where g < 0.

    The damper acts in proportion to the penetration's spring, c(g) = -d k g, so that the pressure begins and ends at
    zero (Hunt and Crossley 1975): p = -k g (1 - d g'). A point mass that meets it at a small velocity v leaves with the
    coefficient of restitution 1 - 2/3 d v.

    Args:
        stiffness: pressure per penetration k [F/L^3].
        damping: d [T/L].
        options: of InterfaceLaw.

    Raises:
        TypeError: a value that is no number.
        ValueError: a value that is not positive.
    """
    values = {
        "stiffness": number("stiffness", stiffness, 0.0, " [F/L^3]"),
        "damping": number("damping", damping, 0.0, " [T/L]"),
    }

    def pressure(gap: Any, gap_rate: Any, parameters: Any) -> Any:
        spring = ufl.max_value(-parameters.stiffness * gap, 0)
        return spring * ufl.max_value(1 - parameters.damping * gap_rate, 0)

    return InterfaceLaw(
        pressure=pressure,
        energy=lambda gap, parameters: parameters.stiffness * ufl.min_value(gap, 0) ** 2 / 2,
        parameters=values,
        **options,
    )


def adhesion(work: float, distance: float, **options: Any) -> InterfaceLaw:
    """Surfaces that attract each other: p = -w g/d^2 exp(-g/d).

    The work w separates a unit of area; the attraction is largest, w/(e d), at the gap d, and overlaps are resisted
    with a stiffness that begins at w/d^2. This is the normal part of the potential of Xu and Needleman (1993).

    Args:
        work: work of adhesion w [F/L].
        distance: d, gap of the largest attraction [L].
        options: of InterfaceLaw.

    Raises:
        TypeError: a value that is no number.
        ValueError: a value that is not positive.
    """
    values = {"work": number("work", work, 0.0, " [F/L]"), "distance": number("distance", distance, 0.0, " [L]")}
    options = {"reach": FAR * values["distance"]} | options

    def energy(gap: Any, parameters: Any) -> Any:
        y = gap / parameters.distance
        return -parameters.work * (1 + y) * ufl.exp(-y)

    return InterfaceLaw(energy=energy, parameters=values, **options)


def _with_friction(
    friction: Part | float | None, stiffness: float, values: dict[str, float], options: dict[str, Any]
) -> dict[str, Any]:
    """Options of a law with these parameters, and with friction whose stiffness is given unless the options do."""
    out = dict(options, parameters=values | dict(options.get("parameters") or {}))
    if friction is not None:
        out.setdefault("tangential", stiffness)
        out["friction"] = friction
    return out
