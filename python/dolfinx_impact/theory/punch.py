# SPDX-License-Identifier: MIT
"""Rigid flat punches on an elastic half-plane or half-space, seed (3.13), corrected; Johnson 2.8 and 3.4."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import checks
from ..common.types import ArrayLike, FloatArray
from .result import Result

CONDITIONS = ("frictionless", "bonded", "sliding")


@dataclass(frozen=True)
class FlatPunch(Result):
    """A flat punch of width 2 a on a half-plane, plane strain.

    Attributes:
        load_per_length: P [F/L].
        half_width: a [L].
        condition: "frictionless", "bonded" or "sliding" (towards +x).
        nu: Poisson's ratio of the half-plane, or None [1].
        tangential_load_per_length: Q on the half-plane along +x, friction P when sliding [F/L].
        eta: exponent of the oscillation when bonded, ln(3 - 4 nu)/(2 pi), else 0 [1].
        gamma: exponent when sliding, tan(pi gamma) = friction (1 - 2 nu)/(2 (1 - nu)), else 0 [1].
    """

    load_per_length: float
    half_width: float
    condition: str
    nu: float | None
    tangential_load_per_length: float = 0.0
    eta: float = 0.0
    gamma: float = 0.0

    @property
    def _factor(self) -> float:
        if self.condition == "bonded":  # 2 (1 - nu)/sqrt(3 - 4 nu) = cosh(pi eta)
            return math.cosh(math.pi * self.eta) / math.pi
        return math.cos(math.pi * self.gamma) / math.pi

    def _tractions(self, x: ArrayLike) -> tuple[FloatArray | float, FloatArray | float]:
        """(pressure, shear) inside, zero outside, infinite at the edges."""
        x = checks.points(x) / self.half_width
        inside = np.abs(x) < 1.0
        t = np.arctanh(np.where(inside, x, 0.0))  # ln((a + x)/(a - x)) = 2 t, 1/sqrt(a^2 - x^2) = cosh(t)/a
        scale = np.where(inside, self._factor / self.half_width * np.cosh(t), 0.0)
        P, Q = self.load_per_length, self.tangential_load_per_length
        if self.condition == "sliding":
            p = P * scale * np.exp(-2 * self.gamma * t)
            q = Q / P * p
        else:
            cos, sin = np.cos(2 * self.eta * t), np.sin(2 * self.eta * t)
            p, q = scale * (P * cos - Q * sin), scale * (P * sin + Q * cos)
        return np.where(np.abs(x) == 1.0, np.inf, p)[()], q[()]

    def pressure(self, x: ArrayLike) -> FloatArray | float:
        """Pressure under the punch, zero outside, np.inf at the edges; x scalar or array [L] -> [F/L^2].

        Frictionless P/(pi sqrt(a^2 - x^2)). Bonded p + i q = (2 (1 - nu)/sqrt(3 - 4 nu)) (P + i Q)/(pi sqrt(a^2 - x^2))
        ((a + x)/(a - x))^(i eta): its sign changes, closer to the edge than any mesh resolves (`first_sign_change`).
        Sliding towards +x: P cos(pi gamma)/(pi sqrt(a^2 - x^2)) ((a - x)/(a + x))^gamma.
        """
        return self._tractions(x)[0]

    def shear(self, x: ArrayLike) -> FloatArray | float:
        """Shear traction on the half-plane along +x, zero outside and where frictionless; as `pressure` [F/L^2]."""
        return self._tractions(x)[1]

    def near_edge_pressure(self, s: ArrayLike) -> FloatArray | float:
        """Leading term at small distances s > 0 from the edge x = +a; bonded, Q = 0: seed (3.13), corrected [F/L^2].

        (2 (1 - nu)/(pi sqrt(3 - 4 nu))) P (2 a s)^(-1/2) cos(eta ln(2 a/s)); valid for s much smaller than a.
        """
        s = checks.points(s)
        if not np.all(s > 0):
            raise ValueError("s must be positive: it is the distance from the edge into the contact [L]")
        ratio = 2 * self.half_width / s
        scale = self._factor / np.sqrt(2 * self.half_width * s) * ratio ** (-self.gamma)
        angle, P, Q = self.eta * np.log(ratio), self.load_per_length, self.tangential_load_per_length
        if self.condition == "sliding":
            return (P * scale)[()]
        return (scale * (P * np.cos(angle) - Q * np.sin(angle)))[()]

    @property
    def first_sign_change(self) -> float | None:
        """1 - x/a where the bonded pressure first turns negative for Q = 0; None where it does not [1]."""
        if self.eta == 0.0 or self.tangential_load_per_length:
            return None
        return 2.0 / (1.0 + math.exp(math.pi / (2 * self.eta)))

    def _figure(self) -> tuple[str, str, list[tuple[Any, ...]]]:
        x = np.sin(np.linspace(-1, 1, 401) * math.pi / 2 * 0.97) * self.half_width
        curves = [("pressure", x, self.pressure(x))]
        if self.condition != "frictionless":
            curves.append(("shear", x, self.shear(x)))
        return "x [L]", "traction [F/L²]", curves


def flat_punch(
    load_per_length: float,
    half_width: float,
    nu: float | None = None,
    condition: str = "frictionless",
    friction: float = 0.0,
    tangential_load_per_length: float = 0.0,
) -> FlatPunch:
    """A rigid flat punch with square corners on an elastic half-plane, plane strain; seed (3.13), corrected.

    The pressure does not depend on Young's modulus, without friction not even on nu.

    Args:
        load_per_length: P, positive [F/L].
        half_width: a, positive [L].
        nu: Poisson's ratio of the half-plane; not needed without friction [1].
        condition: "frictionless"; "bonded": no slip anywhere; "sliding": towards +x with friction everywhere.
        friction: coefficient; of the sliding punch only [1].
        tangential_load_per_length: Q, of the bonded punch only, positive along +x [F/L].

    Returns:
        FlatPunch.

    Raises:
        ValueError: a value outside its range, or one that does not go with the condition. TypeError: no numbers.
    """
    load = checks.number("load_per_length", load_per_length, "[F/L]")
    a = checks.number("half_width", half_width, "[L]")
    condition = checks.choice("condition", condition, CONDITIONS)
    if nu is None and condition != "frictionless":
        raise ValueError(f"the {condition} punch needs Poisson's ratio nu of the half-plane")
    nu = None if nu is None else checks.poisson("Poisson's ratio nu", nu)
    friction = checks.number("friction", friction, closed=True)
    Q = checks.number("tangential_load_per_length", tangential_load_per_length, "[F/L]", low=None)
    if friction and condition != "sliding":
        raise ValueError(f"friction is {friction:g}, but the punch is {condition}: it goes with condition='sliding'")
    if Q and condition != "bonded":
        raise ValueError(
            f"a tangential load goes with condition='bonded', found {condition!r}; sliding it is friction P"
        )
    if condition == "bonded" and nu is not None:
        return FlatPunch(load, a, condition, nu, Q, eta=math.log(3 - 4 * nu) / (2 * math.pi))
    gamma = math.atan(friction * (1 - 2 * nu) / (2 * (1 - nu))) / math.pi if friction and nu is not None else 0.0
    return FlatPunch(load, a, condition, nu, friction * load, gamma=gamma)


@dataclass(frozen=True)
class CircularPunch(Result):
    """A flat punch of circular section on a half-space.

    Attributes:
        approach: depth of indentation [L].
        radius: of the punch, a [L].
        E, nu: elastic constants of the half-space [F/L^2; 1].
        condition: "frictionless" or "bonded".
        load: P [F].
    """

    approach: float
    radius: float
    E: float
    nu: float
    condition: str
    load: float

    @property
    def stiffness(self) -> float:
        """Load per approach [F/L]."""
        return self.load / self.approach

    def _frictionless(self, what: str) -> None:
        if self.condition == "bonded":
            raise ValueError(f"the {what} of the bonded circular punch has no closed form here, only its load has")

    def pressure(self, r: ArrayLike) -> FloatArray | float:
        """p = P/(2 pi a sqrt(a^2 - r^2)), zero outside, np.inf at the edge; without friction only.

        Args:
            r: scalar or array [L].

        Raises:
            ValueError: the punch is bonded.
        """
        self._frictionless("pressure")
        r = np.abs(checks.points(r)) / self.radius
        depth = checks.root(1.0 - r**2)
        p = np.divide(self.load / (2 * math.pi * self.radius**2), depth, out=np.full(r.shape, np.inf), where=depth > 0)
        return np.where(r > 1.0, 0.0, p)[()]

    def displacement(self, r: ArrayLike) -> FloatArray | float:
        """Normal surface displacement: approach under the punch, (2/pi) approach asin(a/r) outside [L].

        Raises:
            ValueError: the punch is bonded.
        """
        self._frictionless("displacement")
        r = np.maximum(np.abs(checks.points(r)) / self.radius, 1.0)
        return (2 / math.pi * self.approach * np.arcsin(1.0 / r))[()]

    def _figure(self) -> tuple[str, str, list[tuple[Any, ...]]]:
        if self.condition == "bonded":
            return "approach [L]", "load [F]", [("bonded", np.array([0, self.approach]), np.array([0, self.load]))]
        r = np.sin(np.linspace(-1, 1, 401) * math.pi / 2 * 0.97) * self.radius
        return "r [L]", "pressure [F/L²]", [("", r, self.pressure(r))]


def circular_punch(
    approach: float, radius: float, E: float, nu: float, condition: str = "frictionless"
) -> CircularPunch:
    """A rigid flat circular punch on an elastic half-space; Johnson 3.4, bonded after Mossakovski.

    P = 2 E a approach/(1 - nu^2) without friction; bonded 4 G a approach ln(3 - 4 nu)/(1 - 2 nu).

    Args:
        approach: depth of indentation, positive [L].
        radius: a, positive [L].
        E, nu: elastic constants of the half-space [F/L^2; 1].
        condition: "frictionless" or "bonded".

    Returns:
        CircularPunch.

    Raises:
        ValueError: a value outside its range. TypeError: no numbers.
    """
    approach, radius = checks.number("approach", approach, "[L]"), checks.number("radius", radius, "[L]")
    E, nu = checks.number("Young's modulus E", E, "[F/L^2]"), checks.poisson("Poisson's ratio nu", nu)
    condition = checks.choice("condition", condition, CONDITIONS[:2])
    load = 2 * E / (1 - nu**2) * radius * approach
    if condition == "bonded":
        t = 1 - 2 * nu  # ln(1 + 2 t)/t has the limit 2
        load *= (1 - nu) * (math.log1p(2 * t) / t if t else 2.0)
    return CircularPunch(approach, radius, E, nu, condition, load)
