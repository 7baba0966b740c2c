# SPDX-License-Identifier: MIT
"""Small contact problems whose answers fit on a line: a press fit and a bar pulled over a rough plane."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from . import checks
from ..common.types import ArrayLike, FloatArray
from .elastic_bodies import Bodies
from .result import Result


@dataclass(frozen=True)
class PressFit(Result):
    """A shaft in a ring that was too small for it.

    Attributes:
        pressure: between the two [F/L^2].
        inner_radius: of the shaft's bore, 0 for a solid one [L].
        radius: of the interface [L].
        outer_radius: of the ring [L].
    """

    pressure: float
    inner_radius: float
    radius: float
    outer_radius: float

    def _lame(self, r: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(A, B) of sigma = A -+ B/r^2 where r is; NaN outside the bodies."""
        i2, b2, c2 = self.inner_radius**2, self.radius**2, self.outer_radius**2
        shaft, ring = -self.pressure * b2 / (b2 - i2), self.pressure * b2 / (c2 - b2)
        A = np.where(r < self.radius, shaft, ring)
        B = np.where(r < self.radius, shaft * i2, ring * c2)
        return np.where((r < self.inner_radius) | (r > self.outer_radius), np.nan, A), B

    def radial_stress(self, r: ArrayLike) -> FloatArray | float:
        """sigma_r; at the interface minus the pressure from both sides; r scalar or array [L] -> [F/L^2]."""
        r = checks.points(r)
        A, B = self._lame(r)
        return (A - np.divide(B, r**2, out=np.zeros_like(r), where=B != 0))[()]

    def hoop_stress(self, r: ArrayLike) -> FloatArray | float:
        """sigma_theta; the ring's at the interface itself, where it jumps; r scalar or array [L] -> [F/L^2]."""
        r = checks.points(r)
        A, B = self._lame(r)
        return (A + np.divide(B, r**2, out=np.zeros_like(r), where=B != 0))[()]

    def _figure(self) -> tuple[str, str, list[tuple[Any, ...]]]:
        r = np.linspace(self.inner_radius, self.outer_radius, 601)
        return "r [L]", "stress [F/L²]", [("radial", r, self.radial_stress(r)), ("hoop", r, self.hoop_stress(r))]


def press_fit(
    interference: float,
    radius: float,
    outer_radius: float,
    E1: float,
    nu1: float,
    E2: float,
    nu2: float,
    inner_radius: float = 0.0,
    hypothesis: str = "plane_stress",
) -> PressFit:
    """Pressure between a shaft (body 1) and a ring (body 2) shrunk on it, without friction; Lame.

    Solid shaft of the ring's material in plane stress: p = E d (c^2 - b^2)/(2 b c^2).

    Args:
        interference: of the radii, positive, small against the radius [L].
        radius: b of the interface [L].
        outer_radius: c of the ring, larger; np.inf for a plate [L].
        E1, nu1, E2, nu2: elastic constants; E = np.inf is a rigid body [F/L^2; 1].
        inner_radius: of the shaft's bore, 0 for a solid one [L].
        hypothesis: "plane_stress" or "plane_strain".

    Returns:
        PressFit.

    Raises:
        ValueError: a value outside its range, radii out of order. TypeError: no numbers.
    """
    interference, b = checks.number("interference", interference, "[L]"), checks.number("radius", radius, "[L]")
    c = checks.number("outer_radius", outer_radius, "[L]", low=b, infinite=True)
    i = checks.number("inner_radius", inner_radius, "[L]", closed=True)
    if i >= b:
        raise ValueError(f"inner_radius is {i:g}: it must be below the radius {b:g} [L]")
    bodies = Bodies(E1, nu1, E2, nu2)
    hypothesis = checks.choice("hypothesis", hypothesis, ("plane_stress", "plane_strain"))
    compliance = 0.0
    # Radial displacement at b per pressure and radius: (k -+ nu)/E with k from Lame's solution of shaft and ring.
    for body, k in ((1, -(1 + (i / b) ** 2) / (1 - (i / b) ** 2)), (2, (1 + (b / c) ** 2) / (1 - (b / c) ** 2))):
        E, nu = bodies.constants(body)
        if hypothesis == "plane_strain":
            E, nu = E / (1 - nu**2), nu / (1 - nu)
        compliance += abs(k + nu) / E
    return PressFit(interference / (b * compliance), i, b, c)


@dataclass(frozen=True)
class BarPull(Result):
    """A long bar on a rough rigid plane, pulled at its end x = 0.

    Attributes:
        force: F at the end [F].
        friction_per_length: friction times normal load per length [F/L].
        axial_stiffness: E A [F].
        slip_length: F/friction_per_length; beyond it nothing moves [L].
        end_displacement: F^2/(2 E A friction_per_length) [L].
        residual_displacement: of the end after the force is taken away, half of the former [L].
    """

    force: float
    friction_per_length: float
    axial_stiffness: float
    slip_length: float
    end_displacement: float
    residual_displacement: float

    def displacement(self, x: ArrayLike) -> FloatArray | float:
        """Displacement towards the pulled end under the full force; x >= 0 from the end, scalar or array [L] -> [L]."""
        left = np.maximum(1.0 - checks.points(x) / self.slip_length, 0.0)
        return (self.end_displacement * left**2)[()]

    def tension(self, x: ArrayLike) -> FloatArray | float:
        """Axial force in the bar under the full force; x >= 0 from the end, scalar or array [L] -> [F]."""
        return (self.force * np.maximum(1.0 - checks.points(x) / self.slip_length, 0.0))[()]

    def _figure(self) -> tuple[str, str, list[tuple[Any, ...]]]:
        x = np.linspace(0.0, 1.3, 261) * self.slip_length
        return "x from the pulled end [L]", "displacement [L]", [("", x, self.displacement(x))]


def bar_pull(force: float, normal_load_per_length: float, friction: float, E: float, area: float) -> BarPull:
    """An elastic bar on a rigid plane with friction, pulled slowly at one end.

    Args:
        force: F, positive [F].
        normal_load_per_length: presses the bar on the plane, positive [F/L].
        friction: coefficient, positive [1].
        E: Young's modulus [F/L^2].
        area: of the section [L^2].

    Returns:
        BarPull; valid for a bar longer than its slip_length, a shorter one slides off.

    Raises:
        ValueError: a value outside its range. TypeError: no numbers.
    """
    F = checks.number("force", force, "[F]")
    normal = checks.number("normal_load_per_length", normal_load_per_length, "[F/L]")
    grip = normal * checks.number("friction", friction)
    stiffness = checks.number("Young's modulus E", E, "[F/L^2]") * checks.number("area", area, "[L^2]")
    end = F**2 / (2 * stiffness * grip)
    return BarPull(F, grip, stiffness, F / grip, end, end / 2)
