# SPDX-License-Identifier: MIT
"""Hertz's contact of bodies with different principal curvatures, seed (3.3)-(3.8), corrected.

The integrals of (3.8) are Carlson's symmetric elliptic integrals: neither circle nor needle is a special case of them.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from . import checks
from ..common.types import ArrayLike, FloatArray
from .elastic_bodies import Bodies
from .curvature import RelativeCurvature, relative_curvature
from .result import Result


@dataclass(frozen=True)
class HertzElliptic(Result):
    """Contact over an ellipse.

    Attributes:
        load: pressing the bodies together [F].
        curvature: of the gap, with the direction of its axes (RelativeCurvature).
        bodies: elastic constants of both (Bodies).
        a: semi-axis along x; not always the larger one [L].
        b: semi-axis along y [L].
        approach: of distant points of the bodies [L].
        peak_pressure: p0 [F/L^2].
    """

    load: float
    curvature: RelativeCurvature
    bodies: Bodies
    a: float
    b: float
    approach: float
    peak_pressure: float

    @property
    def rotation(self) -> float:
        """Angle from body 1's first principal direction to x; zero where the bodies' axes coincide [rad]."""
        return self.curvature.rotation

    @property
    def stiffness(self) -> float:
        """d load / d approach = 3 P/(2 approach) [F/L]."""
        return 1.5 * self.load / self.approach

    def load_at(self, approach: float) -> float:
        """Load at another approach of the same bodies, P ~ approach^1.5 [F]."""
        return self.load * (checks.number("approach", approach, "[L]", closed=True) / self.approach) ** 1.5

    def pressure(self, x: ArrayLike, y: ArrayLike) -> FloatArray | float:
        """p = p0 sqrt(1 - x^2/a^2 - y^2/b^2), seed (3.7), zero outside; scalars or arrays [L] -> [F/L^2]."""
        x, y = checks.points(x, y)
        return self.peak_pressure * checks.root(1.0 - (x / self.a) ** 2 - (y / self.b) ** 2)[()]

    def displacement(self, x: ArrayLike, y: ArrayLike, body: int | None = None) -> FloatArray | float:
        """Normal surface displacement, positive into the body; in contact approach - A x^2 - B y^2, seed (3.4) [L].

        Everywhere (3 P/(4 pi E*)) int_s^inf (1 - x^2/(a^2 + t) - y^2/(b^2 + t)) dt/Q(t) with s = 0 in contact,
        outside the positive root of x^2/(a^2 + s) + y^2/(b^2 + s) = 1: Landau and Lifshitz 9, the potential of an
        ellipsoid.

        Args:
            x, y: scalars or arrays [L].
            body: 1, 2 or None for the sum of both.
        """
        x, y = checks.points(x, y)
        a2, b2 = self.a**2, self.b**2
        p, q = a2 + b2 - x**2 - y**2, a2 * b2 - x**2 * b2 - y**2 * a2  # s^2 + p s + q = 0
        spread = np.sqrt(np.maximum(p**2 - 4 * q, 0.0))
        # Two forms of one root, each where it does not cancel.
        small = np.divide(-2 * q, p + spread, out=np.zeros_like(p), where=p + spread > 0)
        s = np.maximum(np.where(p > 0, small, (spread - p) / 2), 0.0)
        u = 2 * scipy.special.elliprf(s, a2 + s, b2 + s)
        u -= 2 / 3 * (x**2 * scipy.special.elliprd(s, b2 + s, a2 + s) + y**2 * scipy.special.elliprd(s, a2 + s, b2 + s))
        factor = 0.75 * self.load / (math.pi * self.bodies.modulus)
        return (self.bodies.share(body) * factor * u)[()]

    def gap(self, x: ArrayLike, y: ArrayLike) -> FloatArray | float:
        """Gap of the deformed surfaces: zero in contact, positive outside, seed (3.5), corrected [L]."""
        x, y = checks.points(x, y)
        outside = (x / self.a) ** 2 + (y / self.b) ** 2 > 1.0
        gap = self.curvature.gap(x, y) - self.approach + self.displacement(x, y)
        return np.where(outside, gap, 0.0)[()]

    def _figure(self) -> tuple[str, str, list[tuple[Any, ...]]]:
        s = np.linspace(-1.2, 1.2, 481) * max(self.a, self.b)
        curves = [("along x", s, self.pressure(s, 0.0)), ("along y", s, self.pressure(0.0, s))]
        return "x, y [L]", "pressure [F/L²]", curves


def axis_ratio(ratio: float) -> float:
    """b/a of the ellipse for A/B = ratio <= 1, so the smaller semi-axis over the larger one [1].

    From the quotient of the first two equations (3.8), which grows with b/a; in logarithms its slope lies between
    3/2 (circle) and 2 (needle), which brackets the root.
    """
    if ratio == 1.0:
        return 1.0

    def residual(log_k: float) -> float:
        k2 = math.exp(2 * log_k)
        return math.log(scipy.special.elliprd(0.0, k2, 1.0) / scipy.special.elliprd(0.0, 1.0, k2)) - math.log(ratio)

    low, high = math.log(ratio) / 1.5, math.log(ratio) / 2
    margin = 1e-12 + 1e-12 * abs(low)  # near the circle the bracket is as narrow as round-off
    return math.exp(scipy.optimize.brentq(residual, low - margin, min(high + margin, 0.0), xtol=1e-15, rtol=1e-15))


def hertz_elliptic(
    load: float,
    R1x: float,
    R1y: float,
    R2x: float,
    R2y: float,
    E1: float,
    nu1: float,
    E2: float,
    nu2: float,
    angle: ArrayLike = 0.0,
) -> HertzElliptic:
    """Contact of two bodies with principal radii of any size, without friction; seed (3.3)-(3.8), corrected.

    The semi-axis a lies along x, b along y, whichever is larger. For an angle other than zero x is the principal
    direction of the gap within 45 degrees of body 1's first one: see `.rotation`. Valid for a, b small against the
    radii.

    Args:
        load: P, positive [F].
        R1x, R1y: principal radii of body 1; negative where concave, np.inf where flat [L].
        R2x, R2y: those of body 2 [L].
        E1, nu1, E2, nu2: elastic constants; E = np.inf is a rigid body [F/L^2; 1].
        angle: from body 1's first principal direction to body 2's [rad].

    Returns:
        HertzElliptic.

    Raises:
        ValueError: a value outside its range, a pair that is not convex, or a line contact (flat along one direction).
        TypeError: no numbers.
    """
    load = checks.number("load", load, "[F]")
    curvature, bodies = relative_curvature(R1x, R1y, R2x, R2y, angle), Bodies(E1, nu1, E2, nu2)
    A, B = curvature.A, curvature.B
    if min(A, B) <= 1e-100 * max(A, B):
        raise ValueError(
            f"the gap is flat along {'x' if A < B else 'y'}: that is a line contact, use hertz_line with a load per "
            "length"
        )
    # Along the larger semi-axis c: C = P/(2 pi E*) RD(0, k^2 c^2, c^2) = P/(2 pi E* c^3) RD(0, k^2, 1), C = min(A, B).
    k = axis_ratio(min(A, B) / max(A, B))
    cube = load * float(scipy.special.elliprd(0.0, k**2, 1.0)) / (2 * math.pi * bodies.modulus * min(A, B))
    c = cube ** (1.0 / 3.0)
    a, b = (c, k * c) if A <= B else (k * c, c)
    approach = 1.5 * load / (math.pi * bodies.modulus) * scipy.special.elliprf(0.0, a**2, b**2)
    return HertzElliptic(load, curvature, bodies, a, b, float(approach), 1.5 * load / (math.pi * a * b))
