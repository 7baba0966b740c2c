# SPDX-License-Identifier: MIT
"""Impact of spheres: Hertz's contact law as a spring between rigid masses; Johnson 11.4."""

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from . import checks
from ..common.types import ArrayLike, FloatArray
from .elastic_bodies import Bodies
from .curvature import relative_radius
from .result import Result

# Duration over (largest approach/velocity): 2.943275.
_DURATION = 4 * math.sqrt(math.pi) * math.gamma(0.4) / math.gamma(0.9) / 5


@functools.cache
def _approach_curve() -> Any:
    """y(s): approach over its largest value against time over (largest approach/velocity); y'' = -(5/4) y^1.5.

    The same for every impact. Integrated to the turning point only: the way out mirrors the way in.
    """
    return scipy.integrate.solve_ivp(
        lambda s, y: (y[1], -1.25 * max(y[0], 0.0) ** 1.5),
        (0.0, _DURATION / 2),
        (0.0, 1.0),
        method="DOP853",
        rtol=1e-12,
        atol=1e-14,
        dense_output=True,
    ).sol


@dataclass(frozen=True)
class HertzImpact(Result):
    """Central impact of two elastic bodies that are spheres near the contact.

    Attributes:
        velocity: closing speed V [L/T].
        mass: m, 1/m = 1/m1 + 1/m2 [M].
        radius: relative radius R, 1/R = 1/R1 + 1/R2 [L].
        bodies: elastic constants of both (Bodies).
        duration: of the contact [T].
        peak_force: [F].
        max_approach: [L].
        max_radius: of the contact [L].
        peak_pressure: largest p0 [F/L^2].
    """

    velocity: float
    mass: float
    radius: float
    bodies: Bodies
    duration: float
    peak_force: float
    max_approach: float
    max_radius: float
    peak_pressure: float

    def approach(self, t: ArrayLike) -> Any:
        """Approach at times t after first touch, zero before and after contact; scalar or array [T] -> [L].

        m approach'' = -(4/3) E* sqrt(R) approach^1.5, integrated numerically to ten digits.
        """
        s = checks.points(t) * (self.velocity / self.max_approach)
        s = np.minimum(s, _DURATION - s)
        y = _approach_curve()(np.maximum(s, 0.0).ravel())[0].reshape(s.shape)
        return (self.max_approach * np.where(s > 0, np.maximum(y, 0.0), 0.0))[()]

    def force(self, t: ArrayLike) -> FloatArray | float:
        """Force at times t after first touch, zero before and after contact; scalar or array [T] -> [F]."""
        return self.peak_force * (self.approach(t) / self.max_approach) ** 1.5

    def history(self, num: int = 201) -> tuple[FloatArray, Any]:
        """(times, forces) from first touch to separation, num values each [T; F]."""
        t = np.linspace(0.0, self.duration, int(checks.number("num", num, low=2, closed=True)))
        return t, self.force(t)

    def _figure(self) -> tuple[str, str, list[tuple[Any, ...]]]:
        t = np.linspace(-0.1, 1.1, 481) * self.duration
        return "time [T]", "force [F]", [("", t, self.force(t))]


def hertz_impact(
    velocity: float, mass1: float, mass2: float, R1: float, R2: float, E1: float, nu1: float, E2: float, nu2: float
) -> HertzImpact:
    """Impact of two spheres without friction; Hertz 1882, Johnson 11.4(a).

    max_approach = (15 m V^2/(16 sqrt(R) E*))^(2/5), duration 2.943275 max_approach/V. Valid while waves cross the
    bodies many times during contact: V small against the wave speed; on a half-space waves carry some energy off.

    Args:
        velocity: closing speed, positive [L/T].
        mass1, mass2: at most one of them np.inf (a body that does not give way) [M].
        R1, R2: radii; negative for a socket, np.inf for a plane [L].
        E1, nu1, E2, nu2: elastic constants; E = np.inf is a rigid body [F/L^2; 1].

    Returns:
        HertzImpact.

    Raises:
        ValueError: a value outside its range, two infinite masses, a pair that is not convex. TypeError: no numbers.
    """
    V = checks.number("velocity", velocity, "[L/T]")
    masses = [checks.number(n, m, "[M]", infinite=True) for n, m in (("mass1", mass1), ("mass2", mass2))]
    if all(map(math.isinf, masses)):
        raise ValueError("both masses are infinite: at least one must be finite [M]")
    mass = 1.0 / sum(1.0 / m for m in masses)
    R, bodies = relative_radius(R1, R2), Bodies(E1, nu1, E2, nu2)
    modulus = bodies.modulus
    approach = (15 * mass * V**2 / (16 * math.sqrt(R) * modulus)) ** 0.4
    a = math.sqrt(R * approach)
    return HertzImpact(
        V,
        mass,
        R,
        bodies,
        duration=_DURATION * approach / V,
        peak_force=4 / 3 * modulus * a * approach,
        max_approach=approach,
        max_radius=a,
        peak_pressure=2 * modulus * a / (math.pi * R),
    )
