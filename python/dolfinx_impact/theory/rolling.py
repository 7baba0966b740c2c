# SPDX-License-Identifier: MIT
"""Steady rolling of cylinders with creep: Carter 1926; Johnson 8.3."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import checks
from ..common.types import ArrayLike, FloatArray
from .hertz import HertzLine, hertz_line
from .partial_slip import tangential_ratio
from .result import Result


@dataclass(frozen=True)
class Carter(Result):
    """Cylinders that roll towards +x and transmit a tangential load.

    Attributes:
        contact: the normal contact (HertzLine).
        tangential_load_per_length: Q [F/L].
        friction: coefficient [1].
        stick_half_width: d; the stick strip a - 2 d < x < a lies at the leading edge [L].
        creep: difference of the surface speeds over the rolling speed [1].
    """

    contact: HertzLine
    tangential_load_per_length: float
    friction: float
    stick_half_width: float
    creep: float

    def traction(self, x: ArrayLike) -> FloatArray | float:
        """q = friction p, in the strip less (d/a) friction p0 sqrt(1 - (x - a + d)^2/d^2); zero outside [F/L^2].

        Args:
            x: scalar or array [L].
        """
        x, d = checks.points(x), self.stick_half_width
        q = self.friction * self.contact.pressure(x)
        if d > 0:
            scale = self.friction * self.contact.peak_pressure * d / self.contact.half_width
            q = q - scale * checks.root(1.0 - ((x - self.contact.half_width + d) / d) ** 2)
        # Both parts have the same root at the leading edge; their difference may be a negative round-off there.
        return np.maximum(q, 0.0)[()]

    def _figure(self) -> tuple[str, str, list[tuple[Any, ...]]]:
        x = np.linspace(-1.2, 1.2, 961) * self.contact.half_width
        limit = self.friction * self.contact.pressure(x)
        return "x [L]", "traction [F/L²]", [("friction times pressure", x, limit), ("traction", x, self.traction(x))]


def carter(
    load_per_length: float,
    friction: float,
    R1: float,
    R2: float,
    E1: float,
    nu1: float,
    E2: float,
    nu2: float,
    *,
    tangential_load_per_length: float | None = None,
    creep: float | None = None,
) -> Carter:
    """Steady rolling of two cylinders, plane strain; Carter 1926, Johnson 8.3.

    d/a = sqrt(1 - Q/(friction P)), creep = (friction a/R)(1 - d/a). A creep of friction a/R or more slides everywhere.
    Valid for bodies of like elastic constants (beta = 0 in dundurs).

    Args:
        load_per_length: P, positive [F/L].
        friction: coefficient, positive [1].
        R1, R2, E1, nu1, E2, nu2: as for hertz_line.
        tangential_load_per_length: Q, between 0 and friction P [F/L]; or
        creep: not negative [1]: exactly one of the two.

    Returns:
        Carter; for Q = friction P with the creep at which sliding begins.

    Raises:
        ValueError: a value outside its range; Q above friction P; none or both of Q and creep. TypeError: no numbers.
    """
    contact = hertz_line(load_per_length, R1, R2, E1, nu1, E2, nu2)
    P, a = contact.load_per_length, contact.half_width
    full = checks.number("friction", friction) * a / contact.radius
    if checks.exactly_one(tangential_load_per_length=tangential_load_per_length, creep=creep) == "creep":
        creep = checks.number("creep", creep, closed=True)
        stick = max(1.0 - creep / full, 0.0)
        return Carter(contact, float(friction) * P * (1.0 - stick**2), float(friction), stick * a, creep)
    Q, friction, ratio = tangential_ratio(P, tangential_load_per_length, friction, "[F/L]")
    stick = math.sqrt(max(1.0 - ratio, 0.0))
    # 1 - sqrt(1 - k) = k/(1 + sqrt(1 - k)): no cancellation at small Q.
    return Carter(contact, Q, friction, stick * a, full * ratio / (1.0 + stick))
