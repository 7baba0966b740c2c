# SPDX-License-Identifier: MIT
"""Parameters of a wheel that rolls over an insulated rail joint, and of studies of them."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Any, Literal

from dolfinx_impact import theory
from dolfinx_impact.common import rail_steel
from dolfinx_impact.common.parameters import Parameters, parameter
from dolfinx_impact.meshes.wheel_rail import HEAD_HALF_WIDTH  # type: ignore[import-not-found,unused-ignore]

# Young's modulus [Pa], Poisson's ratio and density [kg/m^3] of end posts. Moduli and ratios: Chen and Kuang (2002), as
# quoted in the literature on insulated joints; densities: data sheets of the materials.
END_POSTS = {
    "epoxy": (45.0e9, 0.19, 1900.0),  # epoxy with glass fibres
    "nylon": (1.59e9, 0.39, 1140.0),  # nylon 66
    "ptfe": (0.40e9, 0.46, 2170.0),
    "steel": (rail_steel.E, rail_steel.NU, rail_steel.DENSITY),  # no joint at all: to compare with
}

# Cells in the half-axis of the contact that lies along the rail, and size of the largest cells [m].
PRESETS = {"coarse": (4, 0.05), "medium": (8, 0.04), "fine": (16, 0.03)}

WHEEL_WIDTH, HUB = 0.06, 0.15  # width of the wheel, radius of the hub with all that is fixed to it [m]
PAD_LENGTH = 0.16  # of a pad along the rail [m]
MARGIN = 1.1  # half-axes of the contact by which the fine cells are longer than the way
SECOND_MOMENT = 3038e-8  # of the section of a rail 60E1 about its horizontal axis, EN 13674-1 [m^4]
MOST_CASES = 10_000  # of a study


@dataclass(frozen=True)
class EndPost:
    """Material of an end post.

    Attributes:
        E: Young's modulus [Pa].
        nu: Poisson's ratio [1].
        density: [kg/m^3].
    """

    E: float
    nu: float
    density: float


class RailJoint(Parameters):
    """Insulated rail joint: wheel, rails, end post, joint bars and track.

    Raises:
        ValueError: a value of a wrong kind, outside its range, or one that does not fit the others.
    """

    preset: Literal["coarse", "medium", "fine"] = parameter("coarse", "", "mesh")
    load: float = parameter(130e3, "N", "wheel load", 1e3, 1e6)
    speed: float = parameter(120 / 3.6, "m/s", "of travel", 0.1, 200.0)
    friction: float = parameter(0.3, "1", "coefficient between wheel and rail", 0.0, 2.0)
    gap: float = parameter(8e-3, "m", "between the rail ends", 1e-4, 0.1)
    end_post: Literal["epoxy", "nylon", "ptfe", "steel"] = parameter("epoxy", "", "material of the end post")
    passes: int = parameter(1, "1", "passages of the wheel, one after the other", 1, 10_000)

    wheel_radius: float = parameter(0.46, "m", "of the wheel", 0.25, 1.5)
    cone: float = parameter(
        0.0, "1", "slope of the tread; other than 0: both sides of the rail are computed", -0.19, 0.19
    )
    fillet: float = parameter(0.0, "m", "radius of the flange's fillet, 0: none", 1e-3, 0.05, zero=True)
    wheel_mass: float = parameter(600.0, "kg", "unsprung mass: wheel, half of the axle, bearing box", 50.0, 1e5)
    crown_radius: float = parameter(0.30, "m", "transverse radius of the rail head", 2.0 * HEAD_HALF_WIDTH, 100.0)
    head_profile: tuple[tuple[float, float], ...] = parameter((), "m", "points (y, z) of the head instead of the crown")

    rail_length: float = parameter(1.5, "m", "from the joint to the far end of each rail", 0.1, 50.0)
    bar_length: float = parameter(0.9, "m", "of the joint bars", 0.02, 20.0)
    bar: float = parameter(22e-3, "m", "thickness of a joint bar", 2e-3, 0.1)
    glue: float = parameter(2e-3, "m", "thickness of the insulating layer between joint bar and web", 1e-4, 0.02)
    glue_modulus: float = parameter(5e9, "Pa", "Young's modulus of that layer", 1e4, 1e12)
    pad_stiffness: float = parameter(100e6, "N/m", "of the pad below each sleeper seat", 1e5, 1e10)
    pad_damping: float = parameter(30e3, "N s/m", "of the pad", 0.0, 1e7)
    sleepers: float = parameter(0.6, "m", "spacing of the sleepers, the joint half way between two", 0.2, 2.0)
    support: Literal["pads", "winkler"] = parameter(
        "pads", "", "pads at the sleepers, or winkler: the same stiffness spread along the rail"
    )

    E: float = parameter(rail_steel.E, "Pa", "Young's modulus of the steel", 1e9, 1e12)
    nu: float = parameter(rail_steel.NU, "1", "Poisson's ratio of the steel", 0.0, 0.499)
    density: float = parameter(rail_steel.DENSITY, "kg/m^3", "of the steel", 100.0, 3e4)
    yield_stress: float = parameter(780e6, "Pa", "of the rail near the path; inf: elastic", 1e6, 1e11, infinite=True)
    hardening_modulus: float = parameter(
        30e9, "Pa", "C of Armstrong and Frederick's kinematic hardening, 0: none", 0.0, 1e12
    )
    recovery: float = parameter(
        100.0, "1", "gamma of their dynamic recovery; the back stress saturates at C/gamma", 0.0, 1e6
    )

    begin: float = parameter(-24e-3, "m", "place of the wheel at the start, the joint at 0", -20.0, 0.0)
    end: float = parameter(26e-3, "m", "place of the wheel at the end", 0.0, 20.0)
    cells: int = parameter(0, "1", "cells in the contact's half-axis along the rail, 0: by the preset", 0, 64)
    coarse: float = parameter(0.0, "m", "largest cells, 0: by the preset", 5e-3, 1.0, zero=True)
    penalty: float = parameter(
        0.0, "Pa/m", "of the contact in the explicit run, 0: as stiff as the time step allows", 1e6, 1e18, zero=True
    )
    tied: Literal["none", "bars", "all"] = parameter(
        "none", "", "parts meshed apart and tied: none, bars (with their glue), all (the end post, too)"
    )
    tied_size: float = parameter(1.5, "1", "size of the cells of tied parts over that of the rails' beside", 0.25, 4.0)
    smooth: bool = parameter(False, "", "whether the contact sees round surfaces instead of facets")

    def _check_together(self) -> None:
        if not self.begin < -0.5 * self.gap or not self.end > 0.5 * self.gap:
            raise ValueError(
                f"begin is {self.begin:g} m and end {self.end:g} m: the wheel does not roll over the gap of "
                f"{self.gap:g} m; give begin below {-0.5 * self.gap:g} m and end above {0.5 * self.gap:g} m"
            )
        self._check_profile()
        hertz = self.hertz
        if hertz.b > 0.5 * HEAD_HALF_WIDTH:
            raise ValueError(
                f"load is {self.load:g} N: by Hertz the contact is {2e3 * hertz.b:.0f} mm wide, more than half of the "
                "head; give a smaller load or crown_radius, or a larger E"
            )
        margin = MARGIN * hertz.a
        fine = max(-self.begin + margin, self.end + margin, 0.5 * self.gap + self.cell_size)
        if not 2.0 * fine < self.bar_length:
            raise ValueError(
                f"bar_length is {self.bar_length:g} m: from begin to end the wheel needs more than {2.0 * fine:.3g} m; "
                "give longer bars or a shorter way"
            )
        if not self.bar_length < 2.0 * self.rail_length:
            raise ValueError(
                f"rail_length is {self.rail_length:g} m: give more than half of bar_length, {self.bar_length / 2:g} m"
            )
        if self.support == "pads" and self.rail_length < 0.5 * self.sleepers:
            raise ValueError(
                f"sleepers is {self.sleepers:g} m: the rails of {self.rail_length:g} m (rail_length) end before the "
                "first sleeper, half a spacing from the joint"
            )
        rim = self.density * math.pi * (self.wheel_radius**2 - HUB**2) * WHEEL_WIDTH
        if not self.wheel_mass > rim:
            raise ValueError(
                f"wheel_mass is {self.wheel_mass:g} kg: the rim alone (wheel_radius, density) weighs {rim:.0f} kg; "
                "give more than that"
            )

    def _check_profile(self) -> None:
        points = self.head_profile
        if not points:
            return
        across = [y for y, _ in points]
        good = len(points) >= 3 and all(math.isfinite(v) for point in points for v in point)
        good = good and all(a < b for a, b in zip(across, across[1:])) and max(abs(z) for _, z in points) < 0.05
        if not good or across[0] > -HEAD_HALF_WIDTH or across[-1] < HEAD_HALF_WIDTH:
            raise ValueError(
                f"head_profile is {str(points)[:60]}: give at least three points (y, z) with ascending y from "
                f"{-HEAD_HALF_WIDTH} m or less to {HEAD_HALF_WIDTH} m or more, and heights within 0.05 m"
            )

    @property
    def whole(self) -> bool:
        """Are both sides of the rail computed? Else one half, by symmetry."""
        return bool(self.cone or self.fillet or self.head_profile)

    @property
    def sides(self) -> int:
        """Number of times that computed forces and masses count: 2 for one half by symmetry."""
        return 1 if self.whole else 2

    @property
    def post(self) -> EndPost:
        """Material of the end post."""
        return EndPost(*END_POSTS[self.end_post])

    @property
    def hertz(self) -> theory.HertzElliptic:
        """Contact of wheel and rail away from the joint, x along the rail."""
        return theory.hertz_elliptic(
            self.load, self.wheel_radius, math.inf, math.inf, self.crown_radius, self.E, self.nu, self.E, self.nu
        )

    @property
    def cell_size(self) -> float:
        """Size of the cells at the running surface [m]."""
        return self.hertz.a / (self.cells or PRESETS[self.preset][0])

    @property
    def largest_cells(self) -> float:
        """Size of the cells far away [m]."""
        return self.coarse or PRESETS[self.preset][1]

    @property
    def track_stiffness(self) -> float:
        """Vertical stiffness of rail and pads under the wheel: a beam on Winkler's bed [N/m]."""
        bed = self.pad_stiffness / self.sleepers
        return float(2.0 * (4.0 * self.E * SECOND_MOMENT) ** 0.25 * bed**0.75)

    @property
    def p2_period(self) -> float:
        """Period of the unsprung mass on the track, in which the force P2 rises and falls [s].

        The rail, its bars and what moves of the pads are left out: a lower bound.
        """
        return 2.0 * math.pi * math.sqrt(self.wheel_mass / self.track_stiffness)

    @property
    def shows_p2(self) -> bool:
        """Is the way behind the joint long enough for P2? It must contain a period: rise, peak and fall."""
        return self.end >= self.speed * self.p2_period * (1.0 - 1e-9)

    def for_p2(self) -> RailJoint:
        """The same joint with a way that is long enough for P2, bars and rails as long as that needs, and two cells in
        the half-axis of the contact unless `cells` says otherwise."""
        end = max(self.end, self.speed * self.p2_period)
        bars = max(self.bar_length, 2.0 * (end + MARGIN * self.hertz.a) + 0.05)
        rails = max(self.rail_length, 0.5 * bars + self.sleepers)
        return self.changed(end=end, bar_length=bars, rail_length=rails, cells=self.cells or 2)

    @property
    def duration(self) -> float:
        """Time of a passage [s]."""
        return (self.end - self.begin) / self.speed


class Study(Parameters):
    """Study of rail joints: all combinations of some values."""

    gap: tuple[float | str, ...] = parameter((), "m", "gaps, numbers or texts with units")
    speed: tuple[float | str, ...] = parameter((), "m/s", "speeds, numbers or texts with units")
    load: tuple[float | str, ...] = parameter((), "N", "wheel loads, numbers or texts with units")
    end_post: tuple[str, ...] = parameter((), "", "end posts")
    jobs: int = parameter(1, "1", "cases at once", 1, 1024)

    def cases(self, base: RailJoint) -> list[RailJoint]:
        """All combinations of the values, each once.

        Args:
            base: joint with what is not varied.

        Raises:
            ValueError: a joint does not take one of the values, or there are too many cases.
        """
        axes: dict[str, list[Any]] = {}
        for name in ("gap", "speed", "load", "end_post"):
            given = getattr(self, name)
            if given:
                axes[name] = list(given)
        number = math.prod(len(values) for values in axes.values())
        if number > MOST_CASES:
            raise ValueError(f"{', '.join(axes)} make {number} cases: give at most {MOST_CASES} combinations")
        found = [base.changed(**dict(zip(axes, row))) for row in itertools.product(*axes.values())]
        return list({joint.identity(): joint for joint in found}.values())
