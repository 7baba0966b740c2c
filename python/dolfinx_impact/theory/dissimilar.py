# SPDX-License-Identifier: MIT
"""Bodies of different materials: Dundurs' constants, contact without slip and free rolling, seed (3.15), (3.16)."""

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from . import checks
from ..common.types import AnyArray, ArrayLike, FloatArray
from .elastic_bodies import Bodies
from .hertz import HertzLine, hertz_line
from .result import Result


@dataclass(frozen=True)
class Dundurs(Result):
    """Dundurs' constants of a pair in plane strain; they change sign when the bodies change places.

    Attributes:
        alpha: mismatch of the normal compliances, between -1 and 1 [1].
        beta: mismatch that couples normal and tangential loads, between -1/2 and 1/2 [1].
    """

    alpha: float
    beta: float

    def _figure(self) -> tuple[str, str, list[tuple[str, AnyArray, FloatArray]]]:
        # nu between 0 and 1/2: all pairs lie in this parallelogram.
        edge = ("0 <= nu <= 1/2", np.array([1, 1, -1, -1, 1]), np.array([0.0, 0.5, 0.0, -0.5, 0.0]))
        return "alpha [1]", "beta [1]", [edge, ("this pair", np.array([self.alpha]), np.array([self.beta]))]


def dundurs(E1: float, nu1: float, E2: float, nu2: float) -> Dundurs:
    """Dundurs' constants in plane strain; seed (3.16), corrected, Johnson (5.2).

    alpha = [(1 - nu1)/G1 - (1 - nu2)/G2]/[(1 - nu1)/G1 + (1 - nu2)/G2],
    beta = (1/2) [(1 - 2 nu1)/G1 - (1 - 2 nu2)/G2]/[(1 - nu1)/G1 + (1 - nu2)/G2]. Other authors' alpha, written with
    stiffnesses, has the opposite sign.

    Args:
        E1, nu1, E2, nu2: elastic constants; E = np.inf is a rigid body [F/L^2; 1].

    Returns:
        Dundurs.

    Raises:
        ValueError: a value outside its range. TypeError: no numbers.
    """
    return of_bodies(Bodies(E1, nu1, E2, nu2))


def of_bodies(bodies: Bodies) -> Dundurs:
    """Dundurs' constants of a Bodies."""
    c1, c2, nu1, nu2 = bodies.shear_compliance(1), bodies.shear_compliance(2), bodies.nu1, bodies.nu2
    sum_ = (1 - nu1) * c1 + (1 - nu2) * c2
    alpha = ((1 - nu1) * c1 - (1 - nu2) * c2) / sum_
    return Dundurs(alpha, ((1 - 2 * nu1) * c1 - (1 - 2 * nu2) * c2) / (2 * sum_))


@dataclass(frozen=True)
class BondedIndentation(Result):
    """Line contact of different materials that never slip.

    Attributes:
        contact: the frictionless contact (HertzLine).
        beta: Dundurs' constant [1].
    """

    contact: HertzLine
    beta: float

    @property
    def half_width(self) -> float:
        """a [L]."""
        return self.contact.half_width

    @property
    def peak_pressure(self) -> float:
        """p0 [F/L^2]."""
        return self.contact.peak_pressure

    @property
    def peak_shear(self) -> float:
        """Largest shear traction, 0.793515 |beta| p0 at x = a/sqrt(2) [F/L^2]."""
        return abs(self.beta) * self.peak_pressure * math.sqrt(2) / math.pi * math.log(3 + 2 * math.sqrt(2))

    def pressure(self, x: ArrayLike) -> FloatArray | float:
        """Hertz's pressure: the effect of the shear on it is neglected; x scalar or array [L] -> [F/L^2]."""
        return self.contact.pressure(x)

    def shear(self, x: ArrayLike) -> FloatArray | float:
        """Shear traction on body 1 along +x (on body 2 the opposite), zero outside; seed (3.15).

        q = (beta p0/(pi a)) [s ln|(a + x)/(a - x)| + x ln((a + s)/(a - s))], s = sqrt(a^2 - x^2); odd in x, outward on
        body 1 for beta > 0.

        Args:
            x: scalar or array [L].
        """
        x = checks.points(x) / self.half_width
        inside = (np.abs(x) < 1.0) & (x != 0.0)
        x = np.where(inside, x, 0.5)
        s = np.sqrt((1.0 - x) * (1.0 + x))
        q = 2 * self.beta * self.peak_pressure / math.pi * (s * np.arctanh(x) + x * np.arccosh(1.0 / np.abs(x)))
        return np.where(inside, q, 0.0)[()]

    def _figure(self) -> tuple[str, str, list[tuple[Any, ...]]]:
        x = np.linspace(-1.2, 1.2, 961) * self.half_width
        return "x [L]", "traction [F/L²]", [("pressure", x, self.pressure(x)), ("shear on body 1", x, self.shear(x))]


def bonded_indentation(
    load_per_length: float, R1: float, R2: float, E1: float, nu1: float, E2: float, nu2: float
) -> BondedIndentation:
    """Line contact of two materials pressed together without slip; Goodman 1962, seed (3.15), (3.16), corrected.

    The load grows from zero and every point sticks from the moment it touches. Valid for small beta (q is found for
    Hertz's p) and plane strain; near the edge q/p is not bounded, so real contacts slip there.

    Args:
        load_per_length, R1, R2, E1, nu1, E2, nu2: as for hertz_line [F/L; L; F/L^2; 1].

    Returns:
        BondedIndentation.

    Raises:
        ValueError, TypeError: as hertz_line.
    """
    contact = hertz_line(load_per_length, R1, R2, E1, nu1, E2, nu2)
    return BondedIndentation(contact, of_bodies(contact.bodies).beta)


@functools.cache
def _creep_factor() -> float:
    """Creep of free rolling over 2 beta a/R: half of the load lies within |x| < x0, then sqrt(1 - x0^2/a^2)/2 [1]."""
    half = scipy.optimize.brentq(lambda t: math.asin(t) + t * math.sqrt(1 - t * t) - math.pi / 4, 0.0, 1.0, xtol=1e-15)
    return math.sqrt(1 - half**2) / 2


def bentall_johnson(
    load_per_length: float, R1: float, R2: float, E1: float, nu1: float, E2: float, nu2: float
) -> float:
    """Creep of free rolling of two cylinders of different materials as friction goes to zero; Bentall and Johnson 1967.

    creep = 0.4573855 (2 beta) a/R, positive for beta > 0. Friction makes it smaller.

    Args:
        load_per_length, R1, R2, E1, nu1, E2, nu2: as for hertz_line [F/L; L; F/L^2; 1].

    Returns:
        Creep: difference of the surface speeds over the rolling speed [1].

    Raises:
        ValueError: a value outside its range, a pair that is not convex. TypeError: no numbers.
    """
    contact = hertz_line(load_per_length, R1, R2, E1, nu1, E2, nu2)
    return _creep_factor() * 2 * of_bodies(contact.bodies).beta * contact.half_width / contact.radius
