# SPDX-License-Identifier: MIT
"""Profiles of two bodies near the first point of contact and the gap between them, seed (3.1)-(3.3)."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import checks
from ..common.types import ArrayLike, FloatArray
from .result import Result


def profile(x: ArrayLike, y: ArrayLike, Rx: float, Ry: float, body: int | None = 1) -> FloatArray | float:
    """Height of a body's surface over the common tangent plane, seed (3.1) for body 1, (3.2) for body 2, corrected.

    The axes are the body's principal directions; z points into body 1. Valid for x, y small against the radii.

    Args:
        x, y: where, scalars or arrays [L]. Rx, Ry: principal radii [L].
        body: 1 or 2.

    Returns:
        z = x^2/(2 Rx) + y^2/(2 Ry) for body 1, the negative of it for body 2 [L].

    Raises:
        ValueError: a radius of zero, a body that is neither 1 nor 2. TypeError: no numbers.
    """
    Rx, Ry = checks.radius("Rx", Rx), checks.radius("Ry", Ry)
    x, y = checks.points(x, y)
    if body not in (1, 2):
        raise ValueError(f"body is {body!r}: the bodies are 1 and 2")
    return ((x**2 / Rx + y**2 / Ry) * (0.5 if body == 1 else -0.5))[()]


@dataclass(frozen=True)
class RelativeCurvature(Result):
    """The gap A x^2 + B y^2 of two undeformed bodies that touch, seed (3.3), corrected.

    Attributes:
        A, B: half the relative curvatures, 1/(2 R') along x and 1/(2 R'') along y [1/L].
        rotation: angle from the first principal direction of body 1 to the x of this gap [rad].
    """

    A: float
    B: float
    rotation: float = 0.0

    @property
    def Rx(self) -> float:
        """R' = 1/(2 A), np.inf where the bodies conform along x [L]."""
        return 0.5 / self.A if self.A > 0 else math.inf

    @property
    def Ry(self) -> float:
        """R'' = 1/(2 B), np.inf where the bodies conform along y [L]."""
        return 0.5 / self.B if self.B > 0 else math.inf

    def gap(self, x: ArrayLike, y: ArrayLike) -> FloatArray | float:
        """Distance of the undeformed surfaces [L]; x, y along the axes of this gap, scalars or arrays [L]."""
        x, y = checks.points(x, y)
        return (self.A * x**2 + self.B * y**2)[()]

    def _figure(self) -> tuple[str, str, list[tuple[Any, ...]]]:
        s = np.linspace(-1, 1, 201) * 0.1 / max(self.A, self.B)
        return "x, y [L]", "gap [L]", [("along x", s, self.gap(s, 0)), ("along y", s, self.gap(0, s))]


def relative_radius(R1: float, R2: float) -> float:
    """R of two cylinders or spheres, 1/R = 1/R1 + 1/R2 [L].

    Raises:
        ValueError: a radius of zero, or a pair that is not convex.
    """
    curvature = 1.0 / checks.radius("R1", R1) + 1.0 / checks.radius("R2", R2)
    if not curvature > 0.0:
        raise ValueError(
            f"R1 = {R1}, R2 = {R2}: the pair is not convex (1/R1 + 1/R2 = {curvature:g}); the concave radius must be "
            "the larger one, and two flat bodies have no Hertz contact"
        )
    return 1.0 / curvature


def relative_curvature(R1x: float, R1y: float, R2x: float, R2y: float, angle: ArrayLike = 0.0) -> RelativeCurvature:
    """Relative curvatures of two bodies, seed (3.3), corrected; at an angle as in Johnson 4.1.

    For an angle of zero 1/R' = 1/R1x + 1/R2x and 1/R'' = 1/R1y + 1/R2y. Else the two curvature tensors are added
    and turned to principal axes; x is then the axis within 45 degrees of body 1's first one.

    Args:
        R1x, R1y: principal radii of body 1, negative where concave, np.inf where flat [L].
        R2x, R2y: those of body 2 [L].
        angle: from body 1's first principal direction to body 2's [rad].

    Returns:
        RelativeCurvature.

    Raises:
        ValueError: a radius of zero; a pair that is not convex (A or B negative) or flat in both directions.
        TypeError: no numbers.
    """
    radii = {"R1x": R1x, "R1y": R1y, "R2x": R2x, "R2y": R2y}
    k1x, k1y, k2x, k2y = (1.0 / checks.radius(name, value) for name, value in radii.items())
    angle = checks.number("angle", angle, "[rad]", low=None)
    if angle == 0.0:  # no trigonometry: sums that cancel stay exact
        A, B, rotation = (k1x + k2x) / 2, (k1y + k2y) / 2, 0.0
    else:
        d1, d2 = k1x - k1y, k2x - k2y
        mean = (k1x + k1y + k2x + k2y) / 4
        half = math.hypot(d1 + d2 * math.cos(2 * angle), d2 * math.sin(2 * angle)) / 4
        rotation = math.atan2(d2 * math.sin(2 * angle), d1 + d2 * math.cos(2 * angle)) / 2
        if abs(rotation) <= math.pi / 4:  # direction of the larger curvature
            A, B = mean + half, mean - half
        else:
            A, B, rotation = mean - half, mean + half, rotation - math.copysign(math.pi / 2, rotation)
    if min(A, B) < 0.0 or max(A, B) == 0.0:
        raise ValueError(
            f"{', '.join(f'{n} = {v}' for n, v in radii.items())}: the pair is not convex (half curvatures {A:g} along "
            f"x, {B:g} along y); a concave radius must be larger than the convex one that lies in it"
        )
    return RelativeCurvature(A, B, rotation)
