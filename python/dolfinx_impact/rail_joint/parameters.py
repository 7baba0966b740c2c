# SPDX-License-Identifier: MIT
"""Parameters of a wheel that rolls over an insulated rail joint, read from TOML with units."""

from __future__ import annotations

import dataclasses
import math
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from .. import theory
from ..common.types import FilePath

# Young's modulus [Pa], Poisson's ratio and density [kg/m^3] of end posts. Moduli and ratios: Chen and Kuang (2002), as
# quoted in the literature on insulated joints; densities: data sheets of the materials.
END_POSTS = {
    "epoxy": (45.0e9, 0.19, 1900.0),  # epoxy with glass fibres
    "nylon": (1.59e9, 0.39, 1140.0),  # nylon 66
    "ptfe": (0.40e9, 0.46, 2170.0),
    "steel": (207.0e9, 0.30, 7800.0),  # no joint at all: to compare with
}

# Cells in the half-axis of the contact that lies along the rail, and size of the largest cells [m].
PRESETS = {"coarse": (4, 0.05), "medium": (8, 0.04), "fine": (16, 0.03)}

# Factors of units that a TOML file may use, besides the SI units of the parameters.
UNITS = {
    "m": 1.0, "mm": 1e-3, "um": 1e-6, "N": 1.0, "kN": 1e3, "MN": 1e6, "kg": 1.0, "t": 1e3, "m/s": 1.0, "km/h": 1 / 3.6,
    "Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "kg/m^3": 1.0, "t/m^3": 1e3, "N/m": 1.0, "kN/mm": 1e6, "MN/m": 1e6,
    "N s/m": 1.0, "kN s/m": 1e3, "Pa/m": 1.0, "1": 1.0, "%": 1e-2, "s": 1.0, "min": 60.0, "deg": math.pi / 180.0,
}  # fmt: skip
KINDS = (
    {"m", "mm", "um"}, {"N", "kN", "MN"}, {"kg", "t"}, {"m/s", "km/h"}, {"Pa", "kPa", "MPa", "GPa"},
    {"kg/m^3", "t/m^3"}, {"N/m", "kN/mm", "MN/m"}, {"N s/m", "kN s/m"}, {"Pa/m"}, {"1", "%"}, {"s", "min"},
)  # fmt: skip
SIGNED = ("begin", "end", "cone")
MAY_BE_ZERO = ("fillet", "cells", "coarse", "friction", "pad_damping", "penalty", "recovery", "hardening_modulus")


def _number(default: Any, unit: str, what: str) -> Any:
    """A field with its unit and what it is."""
    return field(default=default, metadata={"unit": unit, "what": what})


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


@dataclass(frozen=True)
class RailJoint:
    """Wheel, rails, end post, joint bars and track; everything in SI units. Each field names its unit in its metadata.

    Raises:
        ValueError: a value is not finite or outside its range.
    """

    preset: str = _number("coarse", "", "mesh: coarse, medium or fine")
    load: float = _number(130e3, "N", "wheel load")
    speed: float = _number(120 / 3.6, "m/s", "of travel")
    friction: float = _number(0.3, "1", "coefficient between wheel and rail")
    gap: float = _number(8e-3, "m", "between the rail ends")
    end_post: str = _number("epoxy", "", f"material of the end post: {', '.join(END_POSTS)}")
    passes: int = _number(1, "1", "passages of the wheel, one after the other")

    wheel_radius: float = _number(0.46, "m", "of the wheel")
    cone: float = _number(0.0, "1", "slope of the tread; other than 0: both sides of the rail are computed")
    fillet: float = _number(0.0, "m", "radius of the flange's fillet, 0: none")
    wheel_mass: float = _number(600.0, "kg", "unsprung mass: wheel, half of the axle, bearing box")
    crown_radius: float = _number(0.30, "m", "transverse radius of the rail head")
    head_profile: tuple[tuple[float, float], ...] = _number((), "m", "points (y, z) of the head instead of the crown")

    rail_length: float = _number(1.5, "m", "from the joint to the far end of each rail")
    bar_length: float = _number(0.9, "m", "of the joint bars")
    bar: float = _number(22e-3, "m", "thickness of a joint bar")
    glue: float = _number(2e-3, "m", "thickness of the insulating layer between joint bar and web")
    glue_modulus: float = _number(5e9, "Pa", "Young's modulus of that layer")
    pad_stiffness: float = _number(100e6, "N/m", "of the pad below each sleeper seat")
    pad_damping: float = _number(30e3, "N s/m", "of the pad")
    sleepers: float = _number(0.6, "m", "spacing of the sleepers, the joint half way between two")
    support: str = _number("pads", "", "pads at the sleepers, or winkler: the same stiffness spread along the rail")

    E: float = _number(207e9, "Pa", "Young's modulus of the steel")
    nu: float = _number(0.3, "1", "Poisson's ratio of the steel")
    density: float = _number(7800.0, "kg/m^3", "of the steel")
    yield_stress: float = _number(780e6, "Pa", "of the rail near the path; inf: elastic")
    hardening_modulus: float = _number(30e9, "Pa", "C of Armstrong and Frederick's kinematic hardening")
    recovery: float = _number(100.0, "1", "gamma of their dynamic recovery; the back stress saturates at C/gamma")

    begin: float = _number(-24e-3, "m", "place of the wheel at the start, the joint at 0")
    end: float = _number(26e-3, "m", "place of the wheel at the end")
    cells: int = _number(0, "1", "in the contact's half-axis along the rail, 0: by the preset")
    coarse: float = _number(0.0, "m", "largest cells, 0: by the preset")
    penalty: float = _number(0.0, "Pa/m", "of the contact in the explicit run, 0: as stiff as the time step allows")
    smooth: bool = _number(False, "", "whether the contact sees round surfaces instead of facets")

    def __post_init__(self) -> None:
        for item in dataclasses.fields(self):
            self._check(item.name, getattr(self, item.name), item)
        if self.preset not in PRESETS:
            raise ValueError(f"preset is {self.preset!r}: one of {', '.join(PRESETS)}")
        if self.end_post not in END_POSTS:
            raise ValueError(f"end_post is {self.end_post!r}: one of {', '.join(END_POSTS)}")
        if self.support not in ("pads", "winkler"):
            raise ValueError(f"support is {self.support!r}: pads or winkler")
        if not self.begin < -0.5 * self.gap or not self.end > 0.5 * self.gap:
            raise ValueError(f"the wheel rolls from {self.begin} m to {self.end} m: not over the gap of {self.gap} m")
        if self.passes < 1:
            raise ValueError(f"passes is {self.passes}: at least one")
        if self.head_profile and not self.whole:
            object.__setattr__(self, "head_profile", tuple(tuple(float(v) for v in p) for p in self.head_profile))

    def _check(self, name: str, value: Any, item: Any) -> None:
        if isinstance(item.default, bool) or isinstance(item.default, (str, tuple)):
            return
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise ValueError(f"{name} is {value!r}: a number [{item.metadata['unit']}]")
        good = math.isfinite(value) or (name == "yield_stress" and value > 0)
        signed, zero = name in SIGNED, name in SIGNED + MAY_BE_ZERO
        if not good or (value < 0 and not signed) or (value == 0 and not zero):
            kind = "finite" if signed else "non-negative" if zero else "positive"
            raise ValueError(f"{name} is {value!r}: a {kind} number [{item.metadata['unit']}]")

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
    def duration(self) -> float:
        """Time of a passage [s]."""
        return (self.end - self.begin) / self.speed

    def changed(self, **values: Any) -> RailJoint:
        """The same joint with other values.

        Args:
            values: by name.

        Raises:
            ValueError: an unknown name, or a value outside its range.
        """
        known = {item.name for item in dataclasses.fields(self)}
        unknown = sorted(set(values) - known)
        if unknown:
            raise ValueError(f"a RailJoint has no {', '.join(unknown)}; it has {', '.join(sorted(known))}")
        return dataclasses.replace(self, **values)

    @classmethod
    def from_toml(cls, path: FilePath) -> RailJoint:
        """Read parameters: `name = number` in SI units, or `name = "number unit"`, for example `speed = "120 km/h"`.

        Args:
            path: file; what it does not name has its default.

        Raises:
            ValueError: the file cannot be read or is no TOML, an unknown name, a unit of another kind, a bad value.
        """
        try:
            text = Path(path).read_text(encoding="utf-8")
            given = tomllib.loads(text)
        except OSError as error:
            raise ValueError(f"{path} cannot be read: {error.strerror}") from None
        except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
            raise ValueError(f"{path} is no TOML file: {error}") from None
        return cls.from_mapping(given)

    @classmethod
    def from_mapping(cls, given: Mapping[str, Any]) -> RailJoint:
        """Parameters from names and values, which may be texts with units.

        Args:
            given: values by name, as in a TOML file.

        Raises:
            ValueError: an unknown name, a unit of another kind, a bad value.
        """
        known = {item.name: item for item in dataclasses.fields(cls)}
        values = {}
        for name, value in given.items():
            if name in known:
                value = with_unit(name, value, known[name].metadata["unit"], type(known[name].default))
            values[name] = value
        return cls().changed(**values)

    def to_toml(self) -> str:
        """Text of a TOML file with all parameters, their units and what they are."""
        lines = ['# Insulated rail joint; numbers are in the units of the comments, or write texts such as "120 km/h"']
        for item in dataclasses.fields(self):
            value = getattr(self, item.name)
            unit = f"[{item.metadata['unit']}] " if item.metadata["unit"] else ""
            lines.append(f"{item.name} = {_as_toml(value)}  # {unit}{item.metadata['what']}")
        return "\n".join(lines) + "\n"


def _as_toml(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, tuple):
        return "[" + ", ".join(_as_toml(v) for v in value) + "]"
    return repr(value)


def with_unit(name: str, value: Any, unit: str, kind: type) -> Any:
    """A value of a TOML file or of the command line in the unit of the parameter.

    Args:
        name: of the parameter, for messages.
        value: a number in SI units, or a text such as "120 km/h"; other kinds are returned as they are.
        unit: of the parameter.
        kind: type of the parameter.

    Raises:
        ValueError: the text is no number with a unit of the right kind.
    """
    if kind is tuple:
        return tuple(tuple(float(v) for v in point) for point in value)
    if not isinstance(value, str) or kind is str:
        return float(value) if kind is float and isinstance(value, int) and not isinstance(value, bool) else value
    if kind is bool:
        if value.lower() in ("true", "false"):
            return value.lower() == "true"
        raise ValueError(f"{name} is {value!r}: true or false")
    match = re.fullmatch(r"\s*([-+]?(?:\d+\.?\d*(?:[eE][-+]?\d+)?|\.\d+(?:[eE][-+]?\d+)?|inf))\s*(.*?)\s*", value)
    given = match.group(2) if match else ""
    alike = next((kinds for kinds in KINDS if unit in kinds), {unit})
    if match is None or (given and given not in alike):
        raise ValueError(f"{name} is {value!r}: a number in {', '.join(sorted(alike))} (without a unit: {unit})")
    number = float(match.group(1)) * (UNITS[given] if given else 1.0)
    if kind is int:
        if number != int(number):
            raise ValueError(f"{name} is {value!r}: a whole number")
        return int(number)
    return number
