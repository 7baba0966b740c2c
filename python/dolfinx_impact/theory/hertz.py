# SPDX-License-Identifier: MIT
"""Hertz's line and point contacts, seed (3.4)-(3.8) for bodies of revolution and cylinders; Johnson 4.2."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import checks
from ..common.types import ArrayLike, FloatArray
from .elastic_bodies import Bodies
from .curvature import relative_radius
from .result import Result
from .stress import Stress, largest


@dataclass(frozen=True)
class HertzLine(Result):
    """Contact of two parallel cylinders in plane strain.

    Attributes:
        load_per_length: pressing the bodies together [F/L].
        radius: relative radius R, 1/R = 1/R1 + 1/R2 [L].
        bodies: elastic constants of both (Bodies).
        half_width: a [L].
        peak_pressure: p0 [F/L^2].
    """

    load_per_length: float
    radius: float
    bodies: Bodies
    half_width: float
    peak_pressure: float

    def pressure(self, x: ArrayLike) -> FloatArray | float:
        """p = p0 sqrt(1 - x^2/a^2), zero outside contact; x scalar or array [L] -> [F/L^2]."""
        return self.peak_pressure * checks.root(1.0 - (checks.points(x) / self.half_width) ** 2)[()]

    def gap(self, x: ArrayLike) -> FloatArray | float:
        """Gap of the deformed surfaces: zero in contact, positive outside, the inequality seed (3.5), corrected [L]."""
        ratio = np.maximum(np.abs(checks.points(x)) / self.half_width, 1.0)
        shape = ratio * checks.root(ratio**2 - 1.0) - np.arccosh(ratio)
        return (self.half_width**2 / (2 * self.radius) * shape)[()]

    def displacement(self, x: ArrayLike, body: int | None = None) -> FloatArray | float:
        """Normal surface displacement relative to the centre, positive into the body [L].

        In contact -x^2/(2R) for both bodies together, seed (3.4) in the plane; there is no absolute value, because the
        displacement of a half-plane under a load has none.

        Args:
            x: scalar or array [L].
            body: 1, 2 or None for the sum of both.
        """
        x = checks.points(x)
        return (self.bodies.share(body) * (self.gap(x) - x**2 / (2 * self.radius)))[()]

    def stress(self, z: ArrayLike, x: ArrayLike = 0.0, body: int | None = 1) -> Stress:
        """Stress in a body at depth z >= 0, x from the axis, without friction; Johnson (4.49), McEwen 1949.

        On the axis: sigma_x = -p0 [(1 + 2 z^2)/s - 2 z], sigma_z = -p0/s, s = sqrt(1 + z^2), z in half widths.

        Args:
            z, x: scalars or arrays [L].
            body: 1 or 2; matters for the out-of-plane stress only.

        Returns:
            Stress.

        Raises:
            ValueError: a negative depth, a rigid body.
        """
        nu = self.bodies.elastic_nu(body)
        z, x = (c / self.half_width for c in checks.points(z, x))
        if np.any(z < 0):
            raise ValueError("depth z is negative: z is measured into the body")
        t = (1.0 - x) * (1.0 + x) + z**2
        d = np.hypot(t, 2 * x * z)  # m^2 + n^2, where (m + i n)^2 = t + 2 i x z
        big = np.sqrt((d + np.abs(t)) / 2)
        small = np.divide(np.abs(x) * z, big, out=np.zeros_like(big), where=big > 0)
        m, n = np.where(t >= 0, big, small), np.where(t >= 0, small, big) * np.sign(x)
        w = (1.0 - x) * (1.0 + x) + n**2  # m^2 - z^2 without its cancellation in the depth
        sum_xz = -2.0 * np.divide(w, m + z, out=np.zeros_like(d), where=m + z > 0)  # zero on the free surface
        w = np.divide(w, d, out=np.zeros_like(d), where=d > 0)  # and at the edge of contact
        sigma_z, tau = -m * w, -n * w
        p0 = self.peak_pressure
        return Stress(*((p0 * s)[()] for s in (sum_xz - sigma_z, nu * sum_xz, sigma_z, tau)))

    def largest_shear(self, body: int | None = 1) -> tuple[float, float]:
        """(largest shear stress on the axis, its depth): 0.30028 p0 at 0.7862 a for nu above 0.2 [F/L^2; L].

        Over all planes: below nu = 0.2 the out-of-plane stress makes it (1/2 - nu) p0 at the surface.
        """
        return largest(lambda z: self.stress(z, body=body).max_shear, 3 * self.half_width)

    def largest_mises(self, body: int | None = 1) -> tuple[float, float]:
        """(largest Mises stress on the axis, its depth) [F/L^2; L]: 0.55752 p0 at 0.7043 a for nu = 0.3."""
        return largest(lambda z: self.stress(z, body=body).mises, 3 * self.half_width)

    def _figure(self) -> tuple[str, str, list[tuple[Any, ...]]]:
        x = np.linspace(-1.4, 1.4, 561) * self.half_width
        return "x [L]", "pressure [F/L²]", [("", x, self.pressure(x))]


def hertz_line(load_per_length: float, R1: float, R2: float, E1: float, nu1: float, E2: float, nu2: float) -> HertzLine:
    """Contact of two cylinders with parallel axes, plane strain, without friction; Johnson 4.2(c).

    a = sqrt(4 P R/(pi E*)), p0 = 2 P/(pi a). Valid for a small against R1, R2 and the size of the bodies.

    Args:
        load_per_length: P, positive [F/L].
        R1, R2: radii; negative inside a bore, np.inf for a plane [L].
        E1, nu1, E2, nu2: elastic constants; E = np.inf is a rigid body [F/L^2; 1].

    Returns:
        HertzLine.

    Raises:
        ValueError: a value outside its range, a pair that is not convex. TypeError: no numbers.
    """
    load = checks.number("load_per_length", load_per_length, "[F/L]")
    radius, bodies = relative_radius(R1, R2), Bodies(E1, nu1, E2, nu2)
    half_width = math.sqrt(4 * load * radius / (math.pi * bodies.modulus))
    return HertzLine(load, radius, bodies, half_width, 2 * load / (math.pi * half_width))


@dataclass(frozen=True)
class HertzPoint(Result):
    """Contact of two spheres.

    Attributes:
        load: pressing the bodies together [F].
        radius: relative radius R, 1/R = 1/R1 + 1/R2 [L].
        bodies: elastic constants of both (Bodies).
        a: radius of the contact [L].
        approach: of distant points of the bodies [L].
        peak_pressure: p0 [F/L^2].
    """

    load: float
    radius: float
    bodies: Bodies
    a: float
    approach: float
    peak_pressure: float

    @property
    def b(self) -> float:
        """The other semi-axis: a again [L]."""
        return self.a

    @property
    def stiffness(self) -> float:
        """d load / d approach = 3 P/(2 approach) [F/L]."""
        return 1.5 * self.load / self.approach

    def load_at(self, approach: float) -> float:
        """Load at another approach of the same bodies, P ~ approach^1.5 [F]."""
        return self.load * (checks.number("approach", approach, "[L]", closed=True) / self.approach) ** 1.5

    def pressure(self, x: ArrayLike, y: ArrayLike = 0.0) -> FloatArray | float:
        """p = p0 sqrt(1 - r^2/a^2), r^2 = x^2 + y^2, zero outside; scalars or arrays [L] -> [F/L^2]."""
        return self.peak_pressure * checks.root(1.0 - (np.hypot(*checks.points(x, y)) / self.a) ** 2)[()]

    def displacement(self, x: ArrayLike, y: ArrayLike = 0.0, body: int | None = None) -> FloatArray | float:
        """Normal surface displacement, positive into the body; in contact approach - r^2/(2R), seed (3.4) [L].

        Outside p0/(2 a E*) [(2 a^2 - r^2) asin(a/r) + a sqrt(r^2 - a^2)], Johnson (3.42).

        Args:
            x, y: scalars or arrays [L].
            body: 1, 2 or None for the sum of both.
        """
        r = np.hypot(*checks.points(x, y)) / self.a
        q = np.maximum(r, 1.0)
        outside = ((2.0 - q**2) * np.arcsin(1.0 / q) + checks.root(q**2 - 1.0)) / math.pi
        return (self.bodies.share(body) * self.approach * np.where(r <= 1.0, 1.0 - r**2 / 2, outside))[()]

    def gap(self, x: ArrayLike, y: ArrayLike = 0.0) -> FloatArray | float:
        """Gap of the deformed surfaces: zero in contact, positive outside, seed (3.5), corrected [L]."""
        x, y = checks.points(x, y)
        r = np.hypot(x, y)
        return np.where(r > self.a, r**2 / (2 * self.radius) - self.approach + self.displacement(x, y), 0.0)[()]

    def stress(self, z: ArrayLike, body: int | None = 1) -> Stress:
        """Stress on the axis at depth z >= 0, without friction; Johnson (3.45).

        sigma_x = sigma_y = -p0 {(1 + nu) [1 - z atan(1/z)] - 1/(2 (1 + z^2))}, sigma_z = -p0/(1 + z^2), z in a.

        Args:
            z: scalar or array [L].
            body: 1 or 2.

        Returns:
            Stress.

        Raises:
            ValueError: a negative depth, a rigid body.
        """
        nu = self.bodies.elastic_nu(body)
        z = checks.points(z) / self.a
        if np.any(z < 0):
            raise ValueError("depth z is negative: z is measured into the body")
        sigma_z = -1.0 / (1.0 + z**2)
        sigma_r = -(1.0 + nu) * (1.0 - z * np.arctan2(1.0, z)) - sigma_z / 2
        return Stress(*((self.peak_pressure * s)[()] for s in (sigma_r, sigma_r, sigma_z)))

    def largest_shear(self, body: int | None = 1) -> tuple[float, float]:
        """(largest shear stress on the axis, its depth) [F/L^2; L]: 0.310 p0 at 0.481 a for nu = 0.3."""
        return largest(lambda z: self.stress(z, body).max_shear, 3 * self.a)

    def largest_mises(self, body: int | None = 1) -> tuple[float, float]:
        """(largest Mises stress on the axis, its depth) [F/L^2; L]: p0 = 1.613 Y at first yield for nu = 0.3."""
        return largest(lambda z: self.stress(z, body).mises, 3 * self.a)

    def _figure(self) -> tuple[str, str, list[tuple[Any, ...]]]:
        r = np.linspace(-1.4, 1.4, 561) * self.a
        return "r [L]", "pressure [F/L²]", [("", r, self.pressure(r))]


def hertz_point(load: float, R1: float, R2: float, E1: float, nu1: float, E2: float, nu2: float) -> HertzPoint:
    """Contact of two spheres, without friction; seed (3.7), (3.8) for R' = R'', Johnson 4.2(a).

    a = (3 P R/(4 E*))^(1/3), p0 = 3 P/(2 pi a^2), approach = a^2/R. Valid for a small against R1 and R2.

    Args:
        load: P, positive [F].
        R1, R2, E1, nu1, E2, nu2: as for hertz_line; the radius of a socket is negative.

    Returns:
        HertzPoint.

    Raises:
        ValueError, TypeError: as hertz_line.
    """
    load = checks.number("load", load, "[F]")
    radius, bodies = relative_radius(R1, R2), Bodies(E1, nu1, E2, nu2)
    a = (0.75 * load * radius / bodies.modulus) ** (1.0 / 3.0)
    return HertzPoint(load, radius, bodies, a, a**2 / radius, 1.5 * load / (math.pi * a**2))
