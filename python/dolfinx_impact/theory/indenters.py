# SPDX-License-Identifier: MIT
"""Blunt wedge and cone, seed (3.14), corrected; Johnson 5.2."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import checks
from ..common.types import ArrayLike, FloatArray
from .elastic_bodies import Bodies
from .result import Result


def _acosh_of_inverse(ratio: FloatArray) -> FloatArray:
    """acosh(1/|ratio|) inside |ratio| < 1, zero outside, infinite at zero."""
    ratio = np.minimum(np.abs(ratio), 1.0)
    return np.arccosh(np.divide(1.0, ratio, out=np.full(ratio.shape, np.inf), where=ratio > 0))


@dataclass(frozen=True)
class Wedge(Result):
    """A wedge pressed into a half-plane, plane strain.

    Attributes:
        load_per_length: P [F/L].
        half_angle: alpha, from the axis to a face [rad].
        bodies: elastic constants of wedge and half-plane (Bodies).
        half_width: of the contact, a [L].
    """

    load_per_length: float
    half_angle: float
    bodies: Bodies
    half_width: float

    def pressure(self, x: ArrayLike) -> FloatArray | float:
        """p = (E* cot(alpha)/pi) acosh(a/|x|), zero outside, np.inf at the apex; x scalar or array [L] -> [F/L^2]."""
        scale = self.bodies.modulus / math.tan(self.half_angle) / math.pi
        return (scale * _acosh_of_inverse(checks.points(x) / self.half_width))[()]

    def _figure(self) -> tuple[str, str, list[tuple[Any, ...]]]:
        x = np.linspace(-1.2, 1.2, 480) * self.half_width  # an even number: no node at the apex
        return "x [L]", "pressure [F/L²]", [("", x, self.pressure(x))]


@dataclass(frozen=True)
class Cone(Result):
    """A cone pressed into a half-space.

    Attributes:
        load: P [F].
        half_angle: alpha, from the axis to the surface [rad].
        bodies: elastic constants of cone and half-space (Bodies).
        a: radius of the contact [L].
        approach: depth of indentation [L].
    """

    load: float
    half_angle: float
    bodies: Bodies
    a: float
    approach: float

    @property
    def stiffness(self) -> float:
        """d load / d approach = 2 E* a [F/L]."""
        return 2 * self.bodies.modulus * self.a

    def pressure(self, r: ArrayLike) -> FloatArray | float:
        """p = (E* cot(alpha)/2) acosh(a/r), zero outside, np.inf at the apex; r scalar or array [L] -> [F/L^2]."""
        scale = self.bodies.modulus / math.tan(self.half_angle) / 2
        return (scale * _acosh_of_inverse(checks.points(r) / self.a))[()]

    def _figure(self) -> tuple[str, str, list[tuple[Any, ...]]]:
        r = np.linspace(-1.2, 1.2, 480) * self.a
        return "r [L]", "pressure [F/L²]", [("", r, self.pressure(r))]


def _half_angle(value: Any) -> float:
    found = checks.number("half_angle", value, "[rad]")
    if found >= math.pi / 2:
        raise ValueError(f"half_angle is {found:g} rad: it must be below pi/2 (a blunt indenter: a little below)")
    return found


def wedge(
    half_angle: float,
    E1: float,
    nu1: float,
    E2: float,
    nu2: float,
    *,
    load_per_length: float | None = None,
    half_width: float | None = None,
) -> Wedge:
    """A blunt wedge on a half-plane, without friction; seed (3.14), corrected: P = a E* cot(alpha).

    Valid for half angles close to pi/2: the slope cot(alpha) is small.

    Args:
        half_angle: alpha, between 0 and pi/2 [rad].
        E1, nu1, E2, nu2: elastic constants; E = np.inf is a rigid body [F/L^2; 1].
        load_per_length: P, positive [F/L]; or
        half_width: a, positive [L]: exactly one of the two.

    Returns:
        Wedge.

    Raises:
        ValueError: a value outside its range, none or two of load and width. TypeError: no numbers.
    """
    bodies, half_angle = Bodies(E1, nu1, E2, nu2), _half_angle(half_angle)
    slope = bodies.modulus / math.tan(half_angle)
    if checks.exactly_one(load_per_length=load_per_length, half_width=half_width) == "half_width":
        a = checks.number("half_width", half_width, "[L]")
        return Wedge(a * slope, half_angle, bodies, a)
    load = checks.number("load_per_length", load_per_length, "[F/L]")
    return Wedge(load, half_angle, bodies, load / slope)


def cone(
    half_angle: float,
    E1: float,
    nu1: float,
    E2: float,
    nu2: float,
    *,
    load: float | None = None,
    a: float | None = None,
    approach: float | None = None,
) -> Cone:
    """A blunt cone on a half-space, without friction; Love 1939: P = (pi/2) a^2 E* cot(alpha).

    approach = (pi/2) a cot(alpha). Valid for half angles close to pi/2.

    Args:
        half_angle: alpha, between 0 and pi/2 [rad].
        E1, nu1, E2, nu2: elastic constants; E = np.inf is a rigid body [F/L^2; 1].
        load: P, positive [F]; or
        a: radius of the contact, positive [L]; or
        approach: depth of indentation, positive [L]: exactly one of the three.

    Returns:
        Cone.

    Raises:
        ValueError: a value outside its range, none or several of load, a, approach. TypeError: no numbers.
    """
    bodies, half_angle = Bodies(E1, nu1, E2, nu2), _half_angle(half_angle)
    cot = 1.0 / math.tan(half_angle)
    given = checks.exactly_one(load=load, a=a, approach=approach)
    if given == "load":
        a = math.sqrt(2 * checks.number("load", load, "[F]") / (math.pi * bodies.modulus * cot))
    elif given == "approach":
        a = 2 * checks.number("approach", approach, "[L]") / (math.pi * cot)
    else:
        a = checks.number("a", a, "[L]")
    return Cone(math.pi / 2 * a**2 * bodies.modulus * cot, half_angle, bodies, a, math.pi / 2 * a * cot)
