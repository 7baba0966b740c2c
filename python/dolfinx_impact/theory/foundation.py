# SPDX-License-Identifier: MIT
"""Winkler's elastic foundation: independent springs on a rigid base, seed (3.9)-(3.12)."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import checks
from ..common.types import ArrayLike, FloatArray
from .result import Result


@dataclass(frozen=True)
class WinklerContact(Result):
    """A rigid indenter on a foundation.

    Attributes:
        approach: depth of indentation [L].
        Rx, Ry: principal radii of the indenter; one of them infinite: a line contact [L].
        modulus: K [F/L^2].
        depth: of the foundation, h [L].
        a, b: half widths along x and y, infinite along an infinite radius [L].
        peak_pressure: K approach/h [F/L^2].
        load: [F]; of a line contact per length [F/L].
    """

    approach: float
    Rx: float
    Ry: float
    modulus: float
    depth: float
    a: float
    b: float
    peak_pressure: float
    load: float

    @property
    def stiffness(self) -> float:
        """d load / d approach [F/L]; of a line contact per length [F/L^2]."""
        return (2.0 if math.isfinite(self.a * self.b) else 1.5) * self.load / self.approach

    def displacement(self, x: ArrayLike, y: ArrayLike = 0.0) -> FloatArray | float:
        """u = approach - x^2/(2 Rx) - y^2/(2 Ry) where that is positive, else 0, seed (3.9); scalars or arrays [L]."""
        x, y = checks.points(x, y)
        return np.maximum(self.approach - x**2 / (2 * self.Rx) - y**2 / (2 * self.Ry), 0.0)[()]

    def pressure(self, x: ArrayLike, y: ArrayLike = 0.0) -> FloatArray | float:
        """p = (K/h) u, seed (3.10) and (3.11), corrected; zero outside contact; scalars or arrays [L] -> [F/L^2]."""
        return self.modulus / self.depth * self.displacement(x, y)

    def _figure(self) -> tuple[str, str, list[tuple[Any, ...]]]:
        names = [(name, size) for name, size in (("along x", self.a), ("along y", self.b)) if math.isfinite(size)]
        s = np.linspace(-1.2, 1.2, 481) * max(size for _, size in names)
        curves = [(name, s, self.pressure(*((s, 0.0) if name == "along x" else (0.0, s)))) for name, _ in names]
        return "x, y [L]", "pressure [F/L²]", curves


def winkler(approach: float, Rx: float, Ry: float, modulus: float, depth: float) -> WinklerContact:
    """A rigid indenter pressed into a Winkler foundation, seed (3.9)-(3.12), corrected.

    Half axes sqrt(2 approach R), load pi K approach^2 sqrt(Rx Ry)/h. With one infinite radius it is a line contact with
    the load per length (4/3)(K/h) approach a.

    Args:
        approach: depth of indentation, positive [L].
        Rx, Ry: principal radii of the indenter, positive, at most one of them np.inf [L].
        modulus: K of the foundation, positive [F/L^2].
        depth: h of the foundation, positive [L].

    Returns:
        WinklerContact.

    Raises:
        ValueError: a value outside its range, or two infinite radii. TypeError: no numbers.
    """
    approach = checks.number("approach", approach, "[L]")
    Rx = checks.number("Rx", Rx, "[L]", infinite=True)
    Ry = checks.number("Ry", Ry, "[L]", infinite=True)
    modulus, depth = checks.number("modulus", modulus, "[F/L^2]"), checks.number("depth", depth, "[L]")
    if math.isinf(Rx) and math.isinf(Ry):
        raise ValueError("Rx and Ry are both infinite: a flat indenter touches everywhere; give at least one radius")
    a, b = math.sqrt(2 * approach * Rx), math.sqrt(2 * approach * Ry)
    peak = modulus * approach / depth
    load = 4 / 3 * peak * min(a, b) if math.isinf(a + b) else math.pi / 2 * peak * a * b
    return WinklerContact(approach, Rx, Ry, modulus, depth, a, b, peak, load)
