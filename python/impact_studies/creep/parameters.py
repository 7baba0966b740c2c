# SPDX-License-Identifier: MIT
"""Parameters of creep curves of a wheel on a rail."""

from __future__ import annotations

import math

from dolfinx_impact import theory
from dolfinx_impact.common import rail_steel
from dolfinx_impact.common.parameters import Parameters, parameter

HUGE = 1e15  # of what may be in units without dimension, as in the literature on rolling
# Least speed of a surface wave over that of shear, at nu = 0: steady states that move faster are unstable.
SURFACE_WAVE = 0.874
# Least half-axis over the radius: gaps, some 1e-10 of the radius then, keep six of the digits of double precision.
SMALLEST = 1e-5


class WheelOnRail(Parameters):
    """Wheel on a rail; the contact is small against both, as in the theory of Hertz.

    Raises:
        ValueError: a value of a wrong kind, outside its range, or one that does not fit the others.
    """

    load: float = parameter(100e3, "N", "that presses wheel and rail together", high=HUGE, above=0.0)
    friction: float = parameter(0.3, "1", "coefficient", 1e-6, 10.0)
    radius: float = parameter(0.46, "m", "of the wheel", high=HUGE, above=0.0)
    crown_radius: float = parameter(
        0.30, "m", "transverse radius of the rail head, inf is flat", high=HUGE, above=0.0, infinite=True
    )
    wheel_crown_radius: float = parameter(
        math.inf, "m", "transverse radius of the tread, inf is flat, negative hollow", -HUGE, HUGE, infinite=True
    )
    E: float = parameter(rail_steel.E, "Pa", "Young's modulus", high=HUGE, above=0.0)
    nu: float = parameter(rail_steel.NU, "1", "Poisson's ratio", 0.0, 0.499)
    density: float = parameter(rail_steel.DENSITY, "kg/m^3", "density", high=HUGE, above=0.0)
    speed: float = parameter(30.0, "m/s", "of travel", high=HUGE, above=0.0)
    cells: int = parameter(6, "1", "cells in each half-axis of the contact, and a part of one up to its edge", 1, 64)
    reach: float = parameter(5.0, "1", "size of the bodies in larger half-axes", 2.5, 100.0)
    path: float = parameter(
        0.0, "1", "what an explicit run from the steady state may roll, in half-axes along the rail", 0.0, 1000.0
    )

    def _check_together(self) -> None:
        tread, rail = self.wheel_crown_radius, self.crown_radius
        if tread == 0.0 or 1.0 / tread + 1.0 / rail <= 0.0:
            raise ValueError(
                f"wheel_crown_radius is {tread:g} m: with crown_radius, {rail:g} m, the bodies do not touch in an "
                "ellipse; give a hollow tread (negative) a larger radius than the head, and not both inf"
            )
        hertz = self.hertz
        size = self.reach * max(hertz.a, hertz.b)
        smallest = min(hertz.a, hertz.b)
        if not smallest > SMALLEST * self.radius:
            raise ValueError(
                f"load is {self.load:g} N: by Hertz a half-axis of the contact is {smallest:.3g} m, too small beside "
                f"the radius of {self.radius:g} m; give a larger load, or a smaller E"
            )
        wave = SURFACE_WAVE * math.sqrt(self.E / (2.0 * (1.0 + self.nu) * self.density))
        if not self.speed < wave:
            raise ValueError(
                f"speed is {self.speed:g} m/s: give less than {wave:.4g} m/s, about that of waves along the surface "
                "(E, nu, density)"
            )
        for name in ("crown_radius", "wheel_crown_radius"):
            if not abs(getattr(self, name)) > size:
                raise ValueError(
                    f"{name} is {getattr(self, name):g} m: give more than the half-width of the bodies, {size:.3g} m, "
                    "which follows from reach and load"
                )
        if not size < 0.5 * self.radius or not size + self.path * hertz.a < self.radius:
            raise ValueError(
                f"radius is {self.radius:g} m: the bodies would be {size:.3g} m deep, half of it or more, or the path "
                "longer; give a larger radius, or a smaller load, reach or path"
            )

    @property
    def hertz(self) -> theory.HertzElliptic:
        """Contact without friction, x along the rail."""
        return theory.hertz_elliptic(
            self.load, self.radius, self.wheel_crown_radius, math.inf, self.crown_radius, self.E, self.nu, self.E,
            self.nu,
        )  # fmt: skip
