# SPDX-License-Identifier: MIT
"""Plastic answers in closed form: Hill 1950 (thick sphere and cylinder), Prandtl's punch, Melan's theorem in line
rolling (Johnson 9.2), cyclic loops (Lemaitre & Chaboche ch. 5), the elastic-plastic bar (von Karman & Taylor).

Von Mises' yield condition, Y in uniaxial tension and k = Y/sqrt(3) in shear; small strain.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from . import checks
from ..common.types import ArrayLike, FloatArray
from .hertz import hertz_line
from .result import Result


@dataclass(frozen=True)
class PlasticSphere(Result):
    """A thick sphere under internal pressure, perfectly plastic inside the front.

    Attributes:
        pressure: inside [F/L^2].
        front: radius up to which it is plastic; the inner radius below first yield [L].
        inner_displacement: radial, of the inner surface [L].
        outer_displacement: radial, of the outer surface [L].
        first_yield: pressure, (2 Y/3)(1 - a^3/b^3) [F/L^2].
        limit: pressure, 2 Y ln(b/a) [F/L^2].
        inner_radius: a [L].
        outer_radius: b [L].
        E: Young's modulus [F/L^2].
        nu: Poisson's ratio [1].
        difference: hoop less radial stress in the plastic part, Y; at the inner surface if all is elastic [F/L^2].
    """

    pressure: float
    front: float
    inner_displacement: float
    outer_displacement: float
    first_yield: float
    limit: float
    inner_radius: float
    outer_radius: float
    E: float
    nu: float
    difference: float

    def radial_stress(self, r: ArrayLike) -> FloatArray | float:
        """sigma_r; NaN outside the sphere; r scalar or array [L] -> [F/L^2]."""
        r = checks.points(r)
        inside = (r >= self.inner_radius) & (r <= self.outer_radius)
        c, b, r = self.front, self.outer_radius, np.where(inside, r, np.nan)
        elastic = -2 / 3 * self.difference * ((c / r) ** 3 - (c / b) ** 3)
        plastic = -2 * self.difference * (np.log(c / r) + (1 - (c / b) ** 3) / 3)
        return np.where(r > c, elastic, plastic)[()]

    def hoop_stress(self, r: ArrayLike) -> FloatArray | float:
        """sigma_theta; NaN outside the sphere; r scalar or array [L] -> [F/L^2]."""
        r = checks.points(r)
        ratio = np.divide(self.front, r, out=np.ones_like(r), where=r > self.front)
        return (self.radial_stress(r) + self.difference * ratio**3)[()]

    def displacement(self, r: ArrayLike) -> FloatArray | float:
        """Radial displacement; NaN outside the sphere; r scalar or array [L] -> [L]."""
        r = checks.points(r)
        inside = (r >= self.inner_radius) & (r <= self.outer_radius)
        c, b, nu, r = self.front, self.outer_radius, self.nu, np.where(inside, r, np.nan)
        elastic = (c / b) ** 3 * (2 / 3 * (1 - 2 * nu) * r + (1 + nu) * b**3 / (3 * r**2))
        plastic = r * ((1 - nu) * (c / r) ** 3 - 2 / 3 * (1 - 2 * nu) * (1 + 3 * np.log(c / r) - (c / b) ** 3))
        return (self.difference / self.E * np.where(r > c, elastic, plastic))[()]

    def _figure(self) -> tuple[str, str, list[tuple[Any, ...]]]:
        r = np.linspace(self.inner_radius, self.outer_radius, 401)
        return "r [L]", "stress [F/L²]", [("radial", r, self.radial_stress(r)), ("hoop", r, self.hoop_stress(r))]


def _vessel(
    inner_radius: float, outer_radius: float, E: float, nu: float, yield_stress: float
) -> tuple[float, float, float, float, float]:
    a = checks.number("inner_radius", inner_radius, "[L]")
    b = checks.number("outer_radius", outer_radius, "[L]", low=a)
    E, nu = checks.number("Young's modulus E", E, "[F/L^2]"), checks.poisson("Poisson's ratio nu", nu)
    return a, b, E, nu, checks.number("yield_stress", yield_stress, "[F/L^2]")


def _state(
    pressure: float | None, front: float | None, a: float, b: float, of_front: Any
) -> tuple[float, float, float]:
    """(pressure, front, share of the yield stress that is reached)."""
    checks.exactly_one(pressure=pressure, front=front)
    if front is not None:
        c = checks.number("front", front, "[L]", low=a, closed=True, high=b)
        return of_front(c), c, 1.0
    p = checks.number("pressure", pressure, "[F/L^2]", high=of_front(b))
    if p <= of_front(a):
        return p, a, p / of_front(a)
    return p, scipy.optimize.brentq(lambda c: of_front(c) - p, a, b, xtol=1e-15 * b, rtol=1e-14), 1.0


def plastic_sphere(
    inner_radius: float,
    outer_radius: float,
    E: float,
    nu: float,
    yield_stress: float,
    pressure: float | None = None,
    front: float | None = None,
) -> PlasticSphere:
    """Thick sphere of a perfectly plastic material under internal pressure; Hill 1950 ch. V.2.

    With the front at c: p = 2 Y ln(c/a) + (2 Y/3)(1 - c^3/b^3). Exact for von Mises and Tresca.

    Args:
        inner_radius: a [L].
        outer_radius: b, larger [L].
        E: Young's modulus [F/L^2].
        nu: Poisson's ratio [1].
        yield_stress: Y in uniaxial tension [F/L^2].
        pressure: up to the limit [F/L^2]; give this, or
        front: radius of the plastic part, from a to b [L].

    Returns:
        PlasticSphere.

    Raises:
        ValueError: a value outside its range, both or none of pressure and front. TypeError: no numbers.
    """
    a, b, E, nu, Y = _vessel(inner_radius, outer_radius, E, nu, yield_stress)

    def of_front(c: float) -> float:
        return 2 * Y * math.log(c / a) + 2 / 3 * Y * (1 - (c / b) ** 3)

    p, c, share = _state(pressure, front, a, b, of_front)
    sphere = PlasticSphere(p, c, 0.0, 0.0, of_front(a), of_front(b), a, b, E, nu, share * Y)
    inner, outer = (float(sphere.displacement(r)) for r in (a, b))
    return PlasticSphere(p, c, inner, outer, of_front(a), of_front(b), a, b, E, nu, share * Y)


@dataclass(frozen=True)
class PlasticCylinder(Result):
    """A thick cylinder in plane strain under internal pressure, perfectly plastic inside the front.

    Attributes:
        pressure: inside [F/L^2].
        front: radius up to which it is plastic; the inner radius below first yield [L].
        inner_displacement: radial, of the inner surface [L].
        outer_displacement: radial, of the outer surface [L].
        first_yield: pressure, (Y/sqrt(3))(1 - a^2/b^2) [F/L^2].
        limit: pressure, (2 Y/sqrt(3)) ln(b/a); exact for any nu [F/L^2].
        inner_radius: a [L].
        outer_radius: b [L].
        E: Young's modulus [F/L^2].
        nu: Poisson's ratio [1].
        difference: hoop less radial stress in the plastic part, 2 k; at the inner surface if all is elastic [F/L^2].
    """

    pressure: float
    front: float
    inner_displacement: float
    outer_displacement: float
    first_yield: float
    limit: float
    inner_radius: float
    outer_radius: float
    E: float
    nu: float
    difference: float

    def radial_stress(self, r: ArrayLike) -> FloatArray | float:
        """sigma_r; NaN outside the cylinder; r scalar or array [L] -> [F/L^2]."""
        r = checks.points(r)
        inside = (r >= self.inner_radius) & (r <= self.outer_radius)
        c, b, r = self.front, self.outer_radius, np.where(inside, r, np.nan)
        elastic = -self.difference / 2 * ((c / r) ** 2 - (c / b) ** 2)
        plastic = -self.difference * (np.log(c / r) + (1 - (c / b) ** 2) / 2)
        return np.where(r > c, elastic, plastic)[()]

    def hoop_stress(self, r: ArrayLike) -> FloatArray | float:
        """sigma_theta; NaN outside the cylinder; r scalar or array [L] -> [F/L^2]."""
        r = checks.points(r)
        ratio = np.divide(self.front, r, out=np.ones_like(r), where=r > self.front)
        return (self.radial_stress(r) + self.difference * ratio**2)[()]

    def displacement(self, r: ArrayLike) -> FloatArray | float:
        """Radial displacement; NaN outside the cylinder; r scalar or array [L] -> [L]."""
        r = checks.points(r)
        nu = self.nu
        shear = (1 - nu) * self.difference * np.divide(self.front**2, r, out=np.full_like(r, np.nan), where=r > 0)
        return ((1 + nu) / self.E * ((1 - 2 * nu) * r * self.radial_stress(r) + shear))[()]

    def _figure(self) -> tuple[str, str, list[tuple[Any, ...]]]:
        r = np.linspace(self.inner_radius, self.outer_radius, 401)
        return "r [L]", "stress [F/L²]", [("radial", r, self.radial_stress(r)), ("hoop", r, self.hoop_stress(r))]


def plastic_cylinder(
    inner_radius: float,
    outer_radius: float,
    E: float,
    nu: float,
    yield_stress: float,
    pressure: float | None = None,
    front: float | None = None,
) -> PlasticCylinder:
    """Thick cylinder of a perfectly plastic material in plane strain under internal pressure; Hill 1950 ch. V.2.

    With the front at c: p = 2 k [ln(c/a) + (1 - c^2/b^2)/2], k = Y/sqrt(3), and no plastic strain along the axis. Exact
    for von Mises at nu = 1/2 and for Tresca with 2 k; for von Mises at nu = 0.3 within about 1 %, the limit exactly.

    Args:
        inner_radius: a [L].
        outer_radius: b, larger [L].
        E: Young's modulus [F/L^2].
        nu: Poisson's ratio [1].
        yield_stress: Y in uniaxial tension [F/L^2].
        pressure: up to the limit [F/L^2]; give this, or
        front: radius of the plastic part, from a to b [L].

    Returns:
        PlasticCylinder.

    Raises:
        ValueError: a value outside its range, both or none of pressure and front. TypeError: no numbers.
    """
    a, b, E, nu, Y = _vessel(inner_radius, outer_radius, E, nu, yield_stress)
    twice = 2 * Y / math.sqrt(3)

    def of_front(c: float) -> float:
        return twice * (math.log(c / a) + (1 - (c / b) ** 2) / 2)

    p, c, share = _state(pressure, front, a, b, of_front)
    cylinder = PlasticCylinder(p, c, 0.0, 0.0, of_front(a), of_front(b), a, b, E, nu, share * twice)
    inner, outer = (float(cylinder.displacement(r)) for r in (a, b))
    return PlasticCylinder(p, c, inner, outer, of_front(a), of_front(b), a, b, E, nu, share * twice)


def prandtl_pressure(yield_stress: float) -> float:
    """Mean pressure under a flat punch on a half-plane at collapse, (2 + pi) k with k = Y/sqrt(3); Prandtl 1920.

    Args:
        yield_stress: Y in uniaxial tension [F/L^2].

    Returns:
        Pressure, 2.968500 Y [F/L^2].

    Raises:
        ValueError: a value outside its range. TypeError: no number.
    """
    return (2 + math.pi) / math.sqrt(3) * checks.number("yield_stress", yield_stress, "[F/L^2]")


@dataclass(frozen=True)
class LineShakedown(Result):
    """Peak pressures of a line contact that rolls without friction, where its behaviour changes.

    Attributes:
        first_yield: below it all stays elastic, von Mises on the axis of the contact [F/L^2].
        depth: of the first yield over the half width of the contact [1].
        shakedown: 4 k; up to it residual stresses make the passes elastic, above it every pass flows [F/L^2].
        shear_yield_stress: k = Y/sqrt(3) [F/L^2].
        nu: Poisson's ratio [1].
    """

    first_yield: float
    depth: float
    shakedown: float
    shear_yield_stress: float
    nu: float

    def _figure(self) -> tuple[str, str, list[tuple[Any, ...]]]:
        depth = np.linspace(0.0, 3.0, 301)
        Y = math.sqrt(3) * self.shear_yield_stress
        contact = hertz_line(1.0, 1.0, math.inf, 1.0, self.nu, 1.0, self.nu)
        mises = contact.stress(depth * contact.half_width).mises / contact.peak_pressure
        curves: list[tuple[Any, ...]] = [("yield stress", np.array([0.0, 3.0]), np.array([Y, Y]))]
        for name, p0 in (("first yield", self.first_yield), ("shakedown limit", self.shakedown)):
            curves.append((name, depth, p0 * mises))
        return "depth over half width [1]", "elastic Mises stress on the axis [F/L²]", curves


def line_shakedown(yield_stress: float, nu: float = 0.3) -> LineShakedown:
    """First yield and shakedown limit of a line contact in free rolling; Johnson 4.3 and 9.2.

    Melan: the orthogonal shear p0/4 at the depth a/2 reverses in every pass and no residual stress can act against it;
    the passes become elastic up to p0 = 4 k.

    Args:
        yield_stress: Y in uniaxial tension [F/L^2].
        nu: Poisson's ratio, for the first yield [1].

    Returns:
        LineShakedown.

    Raises:
        ValueError: a value outside its range. TypeError: no number.
    """
    Y = checks.number("yield_stress", yield_stress, "[F/L^2]")
    nu = checks.poisson("Poisson's ratio nu", nu)
    contact = hertz_line(1.0, 1.0, math.inf, 1.0, nu, 1.0, nu)
    mises, depth = contact.largest_mises()
    k = Y / math.sqrt(3)
    return LineShakedown(float(Y * contact.peak_pressure / mises), float(depth / contact.half_width), 4 * k, k, nu)


def uniaxial_path(
    plastic_strain: ArrayLike,
    E: float,
    yield_stress: float,
    hardening: float = 0.0,
    kinematic: float = 0.0,
    recall: float = 0.0,
) -> tuple[FloatArray, FloatArray]:
    """Exact strain and stress of uniaxial loading along plastic strains, from a virgin state.

    sigma = X +- (Y + H a) with the accumulated plastic strain a; in a branch from e_0, X_0 with the direction s
    X = s C/gamma + (X_0 - s C/gamma) exp(-gamma abs(e - e_0)), or X_0 + C (e - e_0) without recall.

    Args:
        plastic_strain: axial, monotone between one value and the next, shape (n); the path begins at zero [1].
        E: Young's modulus [F/L^2].
        yield_stress: Y [F/L^2].
        hardening: H [F/L^2].
        kinematic: C, of Prager's or Armstrong and Frederick's back stress [F/L^2].
        recall: gamma [1].

    Returns:
        Strain [1] and stress [F/L^2] at the ends of the branches, on the yield surface in their direction, shape (n).
    """
    path = np.atleast_1d(np.asarray(plastic_strain, dtype=float))
    X = a = before = 0.0
    stress = np.zeros(path.shape)
    sign = 1.0
    for i, e in enumerate(path):
        change = e - before
        sign = float(np.sign(change)) or sign
        if recall > 0:
            X = sign * kinematic / recall + (X - sign * kinematic / recall) * math.exp(-recall * abs(change))
        else:
            X += kinematic * change
        a, before = a + abs(change), e
        stress[i] = X + sign * (yield_stress + hardening * a)
    return stress / E + path, stress


@dataclass(frozen=True)
class PlasticCycle(Result):
    """Stable loop of uniaxial cycles between two plastic strains, Armstrong and Frederick's back stress.

    Attributes:
        stress_amplitude: Y + (C/gamma) tanh(gamma plastic_amplitude); C plastic_amplitude without recall [F/L^2].
        strain_amplitude: elastic and plastic [1].
        back_stress_amplitude: the stress amplitude less Y [F/L^2].
        plastic_amplitude: half the width of the loop at zero stress change [1].
        work: area of the loop: plastic work of a cycle per volume [F/L^2].
        yield_stress: Y [F/L^2].
        E: Young's modulus [F/L^2].
        kinematic: C [F/L^2].
        recall: gamma [1].
    """

    stress_amplitude: float
    strain_amplitude: float
    back_stress_amplitude: float
    plastic_amplitude: float
    work: float
    yield_stress: float
    E: float
    kinematic: float
    recall: float

    def loop(self, num_points: int = 101) -> tuple[FloatArray, FloatArray]:
        """Strain [1] and stress [F/L^2] around the loop, from its lower left corner; `num_points` in each branch."""
        e = np.linspace(-self.plastic_amplitude, self.plastic_amplitude, num_points)
        X, passed = -self.back_stress_amplitude, e - e[0]
        if self.recall > 0:
            limit = self.kinematic / self.recall
            rising = limit + (X - limit) * np.exp(-self.recall * passed)
        else:
            rising = X + self.kinematic * passed
        up = rising + self.yield_stress
        # Point-symmetric; elastic lines close it.
        stress = np.concatenate([[-self.stress_amplitude], up, -up, [-self.stress_amplitude]])
        plastic = np.concatenate([e[:1], e, -e, e[:1]])
        return stress / self.E + plastic, stress

    def _figure(self) -> tuple[str, str, list[tuple[Any, ...]]]:
        return "strain [1]", "stress [F/L²]", [("", *self.loop())]


def plastic_cycle(
    plastic_amplitude: float, E: float, yield_stress: float, kinematic: float, recall: float = 0.0
) -> PlasticCycle:
    """Stable loop of cycles with a given plastic amplitude; Lemaitre & Chaboche 5.4.4.

    Args:
        plastic_amplitude: half the range of the plastic strain [1].
        E: Young's modulus [F/L^2].
        yield_stress: Y [F/L^2].
        kinematic: C [F/L^2].
        recall: gamma; 0 is Prager's linear law [1].

    Returns:
        PlasticCycle.

    Raises:
        ValueError: a value outside its range. TypeError: no numbers.
    """
    amplitude = checks.number("plastic_amplitude", plastic_amplitude)
    E, Y = checks.number("Young's modulus E", E, "[F/L^2]"), checks.number("yield_stress", yield_stress, "[F/L^2]")
    C, gamma = checks.number("kinematic", kinematic, "[F/L^2]"), checks.number("recall", recall, closed=True)
    if gamma > 0:
        X = C / gamma * math.tanh(gamma * amplitude)
        # Twice the integral of X over the rising branch: C/gamma (2 A - (1 - exp(-2 gamma A))(1 + X gamma/C)/gamma).
        drop = -math.expm1(-2 * gamma * amplitude) / gamma
        area = 2 * (C / gamma * 2 * amplitude - (C / gamma + X) * drop)
    else:
        X, area = C * amplitude, 0.0
    stress = Y + X
    return PlasticCycle(stress, stress / E + amplitude, X, amplitude, 4 * Y * amplitude + area, Y, E, C, gamma)


@dataclass(frozen=True)
class PlasticBarImpact(Result):
    """A long bar with linear hardening that strikes a rigid wall, before the first wave is back.

    Attributes:
        stress: behind the plastic front, positive in compression [F/L^2].
        strain: behind the plastic front, positive in compression [1].
        plastic_strain: the plastic part of it [1].
        precursor: stress between the fronts, the yield stress [F/L^2].
        wave_speed: of the precursor, sqrt(E/rho) [L/T].
        plastic_speed: of the plastic front, sqrt(Et/rho) [L/T].
        yield_velocity: Y/(rho wave_speed), the largest elastic velocity [L/T].
        velocity: of the bar before the impact [L/T].
        plastic: False: all stays elastic, and there is one front.
    """

    stress: float
    strain: float
    plastic_strain: float
    precursor: float
    wave_speed: float
    plastic_speed: float
    yield_velocity: float
    velocity: float
    plastic: bool

    def waves(self, x: ArrayLike, t: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Stress and velocity in the bar.

        Args:
            x: distance from the wall in the undeformed bar, not negative; broadcast against t [L].
            t: time after the impact [T].

        Returns:
            Stress, positive in compression [F/L^2], and velocity towards the wall [L/T].
        """
        x, t = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(t, dtype=float))
        behind, passed = x < self.plastic_speed * t, x < self.wave_speed * t
        if not self.plastic:
            behind = passed
        stress = np.where(behind, self.stress, np.where(passed, self.precursor, 0.0))
        left = max(self.velocity - self.yield_velocity, 0.0)
        return stress, np.where(behind, 0.0, np.where(passed, left, self.velocity))

    def _figure(self) -> tuple[str, str, list[tuple[Any, ...]]]:
        x = np.array([0.0, self.plastic_speed, self.plastic_speed, self.wave_speed, self.wave_speed])
        stress = np.array([self.stress, self.stress, self.precursor, self.precursor, 0.0])
        if not self.plastic:
            x, stress = x[[0, 3, 4]], stress[[0, 1, 4]]
        return "distance over time [L/T]", "stress [F/L²]", [("", x, stress)]


def plastic_bar_impact(
    velocity: float, density: float, E: float, yield_stress: float, tangent_modulus: float
) -> PlasticBarImpact:
    """Impact of a slender bar with linear hardening on a rigid wall; von Karman & Taylor, Johnson 11.5.

    Two fronts: Y runs with sqrt(E/rho), Y + rho c_p (v - Y/(rho c)) with c_p = sqrt(Et/rho).

    Args:
        velocity: of the bar [L/T].
        density: [M/L^3].
        E: Young's modulus [F/L^2].
        yield_stress: Y in uniaxial stress [F/L^2].
        tangent_modulus: Et = E H/(E + H), slope of stress over strain beyond yield, at most E [F/L^2].

    Returns:
        PlasticBarImpact.

    Raises:
        ValueError: a value outside its range. TypeError: no numbers.
    """
    v, rho = checks.number("velocity", velocity, "[L/T]"), checks.number("density", density, "[M/L^3]")
    E, Y = checks.number("Young's modulus E", E, "[F/L^2]"), checks.number("yield_stress", yield_stress, "[F/L^2]")
    Et = checks.number("tangent_modulus", tangent_modulus, "[F/L^2]", high=E)
    c, c_p = math.sqrt(E / rho), math.sqrt(Et / rho)
    limit = Y / (rho * c)
    if v <= limit:
        stress = rho * c * v
        return PlasticBarImpact(stress, stress / E, 0.0, stress, c, c_p, limit, v, False)
    stress = Y + rho * c_p * (v - limit)
    strain = Y / E + (stress - Y) / Et
    return PlasticBarImpact(stress, strain, strain - stress / E, Y, c, c_p, limit, v, True)
