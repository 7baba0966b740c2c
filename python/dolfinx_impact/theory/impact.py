# SPDX-License-Identifier: MIT
"""Stress waves of an impact, seed (3.82), (3.83), corrected; Johnson 11.1 and 11.5."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import checks
from .hertz import hertz_point
from .result import Result


def impact_stress(
    density: float, c: float | None, v: float, density2: float | None = None, c2: float | None = None
) -> float:
    """Stress behind the wave of an impact, seed (3.82): rho c v.

    One material: a bar that meets a rigid wall at speed v, or equal bars with closing speed 2 v. Two materials:
    Z1 Z2 v/(Z1 + Z2), Z = rho c, where v is the closing speed. c is the speed of the waves in question: sqrt(E/rho) in
    a slender bar, seed (3.80) in uniaxial strain.

    Args:
        density: rho, positive [M/L^3].
        c: wave speed, positive [L/T].
        v: speed, not negative [L/T].
        density2, c2: of the second body; both or none [M/L^3; L/T].

    Returns:
        Stress, positive in compression [F/L^2].

    Raises:
        ValueError: a value outside its range, only one of density2 and c2. TypeError: no numbers.
    """
    Z = checks.number("density", density, "[M/L^3]") * checks.number("c", c, "[L/T]")
    v = checks.number("v", v, "[L/T]", closed=True)
    if (density2 is None) != (c2 is None):
        raise ValueError("give both density2 and c2, or none of them (a rigid wall)")
    if density2 is None:
        return Z * v
    Z2 = checks.number("density2", density2, "[M/L^3]") * checks.number("c2", c2, "[L/T]")
    return Z * Z2 / (Z + Z2) * v


@dataclass(frozen=True)
class BarImpact(Result):
    """A bar that strikes a rigid wall, or the end of a long bar at rest.

    Attributes:
        stress: in the contact, positive in compression [F/L^2].
        wave_speed: of the striker, sqrt(E/rho) [L/T].
        interface_velocity: of the contact while it lasts [L/T].
        release_time: 2 L/c after first touch, when the striker's release wave is back [T].
        rear_velocity: of the striker behind the release wave, positive forwards [L/T].
        shortening: of the striker when the wave is at its rear end, stress L/E [L].
        separates: the contact ends at `release_time`: the striker has not the larger impedance.
    """

    stress: float
    wave_speed: float
    interface_velocity: float
    release_time: float
    rear_velocity: float
    shortening: float
    separates: bool

    def _figure(self) -> tuple[str, str, list[tuple[Any, ...]]]:
        t = np.array([-0.1, 0, 0, 1, 1, 1.2]) * self.release_time
        stress = np.array([0, 0, 1, 1, 0, 0]) * self.stress
        if not self.separates:
            t, stress = t[:4], stress[:4]
        return "time [T]", "contact stress [F/L²]", [("", t, stress)]


def bar_impact(
    velocity: float, length: float, density: float, E: float, density2: float | None = None, E2: float | None = None
) -> BarImpact:
    """Impact of an elastic bar, one-dimensional waves; Johnson 11.1, seed (3.82).

    A rigid wall: stress rho c v, contact 2 L/c, rebound with v. A second bar of the same section, at rest, whose own
    far end is not heard of before 2 L/c: stress Z1 Z2 v/(Z1 + Z2).

    Args:
        velocity: of the striker, positive [L/T].
        length: of the striker [L].
        density, E: of the striker [M/L^3; F/L^2].
        density2, E2: of the struck bar; both or none (rigid wall) [M/L^3; F/L^2].

    Returns:
        BarImpact.

    Raises:
        ValueError: a value outside its range, only one of density2 and E2. TypeError: no numbers.
    """
    v, length = checks.number("velocity", velocity, "[L/T]"), checks.number("length", length, "[L]")
    rho, E = checks.number("density", density, "[M/L^3]"), checks.number("E", E, "[F/L^2]")
    if (density2 is None) != (E2 is None):
        raise ValueError("give both density2 and E2, or none of them (a rigid wall)")
    c, Z = math.sqrt(E / rho), math.sqrt(E * rho)
    part = 1.0  # Z2/(Z1 + Z2)
    if density2 is not None:
        Z2 = math.sqrt(checks.number("density2", density2, "[M/L^3]") * checks.number("E2", E2, "[F/L^2]"))
        part = Z2 / (Z + Z2)
    stress = Z * part * v
    interface = v * (1.0 - part)
    return BarImpact(stress, c, interface, 2 * length / c, 2 * interface - v, stress * length / E, part >= 0.5)


@dataclass(frozen=True)
class YieldVelocity(Result):
    """Speeds at which an impact first yields: readings of seed (3.83).

    Attributes:
        bar: slender bar on a rigid wall, Y/(rho sqrt(E/rho)) [L/T].
        two_bars: closing speed of two equal slender bars, twice the former [L/T].
        uniaxial_strain: half-space struck all over, hugoniot/(rho c) with the dilatational speed [L/T].
        hugoniot: stress at which uniaxial strain yields, Y (1 - nu)/(1 - 2 nu) [F/L^2].
        sphere: sphere on a half-space of the same material, yielding below the surface: V^2 = 26 (Y/rho)(Y/E*)^4,
            Johnson (11.20) [L/T].
        sphere_mises: the same from Mises' condition on the axis at this nu, without the rounding of the 26 [L/T].
        printed: Y/(rho c) as the seed prints it, a uniaxial stress with the speed of uniaxial strain; quote only [L/T].
        yield_stress: Y in uniaxial stress [F/L^2].
    """

    bar: float
    two_bars: float
    uniaxial_strain: float
    hugoniot: float
    sphere: float
    sphere_mises: float
    printed: float
    yield_stress: float

    def _figure(self) -> tuple[str, str, list[tuple[Any, ...]]]:
        curves = []
        for name, v, stress in (
            ("bar", self.bar, self.yield_stress),
            ("uniaxial strain", self.uniaxial_strain, self.hugoniot),
        ):
            curves.append((name, np.array([0.0, v]), np.array([0.0, stress])))
        return "impact velocity [L/T]", "stress up to yield [F/L²]", curves


def yield_velocity(yield_stress: float, density: float, E: float, nu: float, c: float | None = None) -> YieldVelocity:
    """Largest impact velocity that stays elastic, seed (3.83) with the wave speed that belongs to the stress state.

    Args:
        yield_stress: Y in uniaxial stress, positive [F/L^2].
        density: positive [M/L^3].
        E, nu: elastic constants; nu below 0.5 [F/L^2; 1].
        c: speed for `printed`; default the dilatational speed of E, nu and density [L/T].

    Returns:
        YieldVelocity.

    Raises:
        ValueError: a value outside its range. TypeError: no numbers.
    """
    Y, rho = checks.number("yield_stress", yield_stress, "[F/L^2]"), checks.number("density", density, "[M/L^3]")
    E = checks.number("Young's modulus E", E, "[F/L^2]")
    nu = checks.poisson("Poisson's ratio nu", nu, incompressible=False)
    dilatational = math.sqrt(E * (1 - nu) / (rho * (1 + nu) * (1 - 2 * nu)))
    c = dilatational if c is None else checks.number("c", c, "[L/T]")
    bar, hugoniot = Y / math.sqrt(rho * E), Y * (1 - nu) / (1 - 2 * nu)
    # Sphere: m V^2/2 = (8/15) E* sqrt(R) approach^2.5 with p0 = (2 E*/pi) sqrt(approach/R), so that
    # V^2 = (4/(5 pi)) (pi/2)^5 p0^5/(rho E*^4).
    contact = hertz_point(1.0, 1.0, math.inf, E, nu, E, nu)
    modulus = contact.bodies.modulus
    p0 = Y * contact.peak_pressure / contact.largest_mises()[0]
    mises = math.sqrt(4 / (5 * math.pi) * (math.pi / 2) ** 5 * p0 / rho) * (p0 / modulus) ** 2
    sphere = math.sqrt(26 * Y / rho) * (Y / modulus) ** 2
    return YieldVelocity(bar, 2 * bar, hugoniot / (rho * dilatational), hugoniot, sphere, mises, Y / (rho * c), Y)
