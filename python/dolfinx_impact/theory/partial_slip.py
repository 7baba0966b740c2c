# SPDX-License-Identifier: MIT
"""Partial slip under a tangential load smaller than friction: Cattaneo 1938, Mindlin 1949; Johnson 7.2."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from . import checks
from ..common.types import ArrayLike, FloatArray
from .hertz import HertzLine, HertzPoint, hertz_line, hertz_point
from .result import Result


def tangential_ratio(
    load: float, tangential_load: float | None, friction: float, unit: str
) -> tuple[float, float, float]:
    """(Q, friction, Q/(friction P)), checked.

    Raises:
        ValueError: no friction, a negative Q, or more than friction holds.
    """
    friction = checks.number("friction", friction)
    Q = checks.number("tangential load", tangential_load, unit, closed=True)
    if Q > friction * load:
        raise ValueError(
            f"the tangential load {Q:g} {unit} is above friction times load, {friction * load:g}: the bodies slide"
        )
    return Q, friction, Q / (friction * load)


def _traction(contact: HertzLine | HertzPoint, friction: float, size: float, stick: float, x: FloatArray) -> Any:
    """friction p, in the stick zone less the same shape scaled to that zone."""
    q = np.asarray(friction * contact.pressure(x))
    if stick > 0:
        q = q - friction * contact.peak_pressure * stick / size * checks.root(1.0 - (x / stick) ** 2)
    return q[()]


@dataclass(frozen=True)
class CattaneoMindlinLine(Result):
    """Cylinders under a load and a tangential load across their axes.

    Attributes:
        contact: the normal contact (HertzLine).
        tangential_load_per_length: Q [F/L].
        friction: coefficient [1].
        stick_half_width: c = a sqrt(1 - Q/(friction P)); slip in c < |x| < a [L].
    """

    contact: HertzLine
    tangential_load_per_length: float
    friction: float
    stick_half_width: float

    def traction(self, x: ArrayLike) -> FloatArray | float:
        """q = friction p0 [sqrt(1 - x^2/a^2) - (c/a) sqrt(1 - x^2/c^2)], zero outside; x in [L] -> [F/L^2]."""
        return _traction(self.contact, self.friction, self.contact.half_width, self.stick_half_width, checks.points(x))

    def _figure(self) -> tuple[str, str, list[tuple[Any, ...]]]:
        x = np.linspace(-1.2, 1.2, 961) * self.contact.half_width
        limit = self.friction * self.contact.pressure(x)
        return "x [L]", "traction [F/L²]", [("friction times pressure", x, limit), ("traction", x, self.traction(x))]


def cattaneo_mindlin_line(
    load_per_length: float,
    tangential_load_per_length: float,
    friction: float,
    R1: float,
    R2: float,
    E1: float,
    nu1: float,
    E2: float,
    nu2: float,
) -> CattaneoMindlinLine:
    """Partial slip of cylinders in plane strain; Johnson 7.2(a). The shift is not determined in a half-plane.

    Valid for bodies of like elastic constants (beta = 0 in dundurs), a constant P, and Q that grows from zero.

    Args:
        load_per_length: P, positive [F/L].
        tangential_load_per_length: Q, between 0 and friction P [F/L].
        friction: coefficient, positive [1].
        R1, R2, E1, nu1, E2, nu2: as for hertz_line.

    Returns:
        CattaneoMindlinLine.

    Raises:
        ValueError: a value outside its range; Q above friction P. TypeError: no numbers.
    """
    contact = hertz_line(load_per_length, R1, R2, E1, nu1, E2, nu2)
    Q, friction, ratio = tangential_ratio(contact.load_per_length, tangential_load_per_length, friction, "[F/L]")
    return CattaneoMindlinLine(contact, Q, friction, contact.half_width * math.sqrt(max(1.0 - ratio, 0.0)))


@dataclass(frozen=True)
class CattaneoMindlin(Result):
    """Spheres under a load and a tangential load.

    Attributes:
        contact: the normal contact (HertzPoint).
        tangential_load: Q [F].
        friction: coefficient [1].
        stick_radius: c = a (1 - Q/(friction P))^(1/3); slip in c < r < a [L].
        shift: tangential displacement of distant points of the bodies [L].
        first_dissipation: work of slip while Q grows from zero [F L].
        cycle_dissipation: work of slip in a full cycle between Q and -Q, four times the first [F L].
    """

    contact: HertzPoint
    tangential_load: float
    friction: float
    stick_radius: float
    shift: float
    first_dissipation: float
    cycle_dissipation: float

    @property
    def full_shift(self) -> float:
        """Shift at which the bodies begin to slide, (3 friction P/(16 a)) [(2 - nu1)/G1 + (2 - nu2)/G2] [L]."""
        return _full_shift(self.contact, self.friction)

    def traction(self, r: ArrayLike) -> FloatArray | float:
        """q = friction p0 [sqrt(1 - r^2/a^2) - (c/a) sqrt(1 - r^2/c^2)], zero outside; r in [L] -> [F/L^2]."""
        return _traction(self.contact, self.friction, self.contact.a, self.stick_radius, checks.points(r))

    def slip(self, r: ArrayLike) -> FloatArray | float:
        """Slip between the bodies, zero for r <= c, mean over the circle; r scalar or array, not outside contact [L].

        shift less the surface displacements of both tractions, which are those of (3.42) in Johnson with the tangential
        compliance. np.nan outside contact, where there is nothing to slip on.
        """
        r, c = np.abs(checks.points(r)) / self.contact.a, self.stick_radius / self.contact.a
        k = c / np.maximum(np.maximum(r, c), 1e-300)
        shape = (1 - 2 * k**2) * (1 - 2 / math.pi * np.arcsin(k)) + 2 / math.pi * k * checks.root(1 - k**2)
        slip = self.full_shift * r**2 / 2 * np.where(r > c, shape, 0.0)
        return np.where(r <= 1.0, slip, np.nan)[()]

    def _figure(self) -> tuple[str, str, list[tuple[Any, ...]]]:
        r = np.linspace(-1.2, 1.2, 961) * self.contact.a
        limit = self.friction * self.contact.pressure(r)
        return "r [L]", "traction [F/L²]", [("friction times pressure", r, limit), ("traction", r, self.traction(r))]


def _full_shift(contact: HertzPoint, friction: float) -> float:
    return 3 * friction * contact.load / (16 * contact.a) * contact.bodies.tangential_compliance


def _loop(q: float) -> float:
    """1 - (1 - q)^(5/3) - (5 q/6) [1 + (1 - q)^(2/3)], 0 <= q <= 1: by its series where it cancels."""
    if q > 0.1:
        return 1 - (1 - q) ** (5 / 3) - 5 * q / 6 * (1 + (1 - q) ** (2 / 3))
    n = np.arange(3, 30)
    return float(
        np.sum((-1.0) ** n * (5 / 6 * scipy.special.binom(2 / 3, n - 1) - scipy.special.binom(5 / 3, n)) * q**n)
    )


def cattaneo_mindlin(
    load: float,
    tangential_load: float,
    friction: float,
    R1: float,
    R2: float,
    E1: float,
    nu1: float,
    E2: float,
    nu2: float,
) -> CattaneoMindlin:
    """Partial slip of spheres; Johnson 7.2(b), work of slip after Mindlin, Mason, Osmer and Deresiewicz 1952.

    Valid for bodies of like elastic constants (beta = 0 in dundurs), a constant P, and Q that grows from zero; the
    small traction across Q is neglected. The work in a cycle is (9 friction^2 P^2/(10 a)) [(2 - nu1)/G1 + (2 - nu2)/G2]
    {1 - (1 - k)^(5/3) - (5 k/6) [1 + (1 - k)^(2/3)]}, k = Q/(friction P).

    Args:
        load: P [F].
        tangential_load: Q [F].
        friction, R1, R2, E1, nu1, E2, nu2: as for cattaneo_mindlin_line.

    Returns:
        CattaneoMindlin.

    Raises:
        ValueError, TypeError: as cattaneo_mindlin_line.
    """
    contact = hertz_point(load, R1, R2, E1, nu1, E2, nu2)
    Q, friction, ratio = tangential_ratio(contact.load, tangential_load, friction, "[F]")
    left = max(1.0 - ratio, 0.0)
    full = _full_shift(contact, friction)
    # 1 - left^(2/3) without cancellation at small Q.
    shift = -full * math.expm1(2 / 3 * math.log1p(-ratio)) if ratio < 1.0 else full
    cycle = 24 / 5 * friction * contact.load * full * _loop(min(ratio, 1.0))
    return CattaneoMindlin(contact, Q, friction, contact.a * left ** (1 / 3), shift, cycle / 4, cycle)
