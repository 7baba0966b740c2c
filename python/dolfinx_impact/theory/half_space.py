# SPDX-License-Identifier: MIT
"""Surface displacement of a half-space, or half-plane, under any pressure: seed (3.6), corrected, by quadrature.

It shares nothing with the closed forms of the contacts, so these can be checked by it.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import scipy

from . import checks
from ..common.types import ArrayLike, FloatArray


def half_space_displacement(
    pressure: Callable[..., Any],
    x: ArrayLike,
    y: ArrayLike,
    a: float,
    b: float,
    E: float,
    nu: float,
    num: int | None = None,
) -> FloatArray | float:
    """u_z(x, y) = (1 - nu^2)/(pi E) iint p(s, t)/sqrt((x - s)^2 + (y - t)^2) ds dt, seed (3.6), corrected.

    The pressure acts on the ellipse with semi-axes a, b about the origin. Integrated along rays from (x, y), where the
    1/r of the kernel meets the r of the area element; nodes crowd at the edge, so p may vanish there like a root or
    grow like one over a root. Exponential convergence for pressures that are smooth but for that.

    Args:
        pressure: function of arrays (x, y) [L] -> [F/L^2]; called inside the ellipse only.
        x, y: where, inside or outside; scalars or arrays [L].
        a, b: semi-axes along x and y, positive [L].
        E, nu: elastic constants of the body; E = np.inf gives zero [F/L^2; 1].
        num: nodes along a ray and number of rays; default 48, and 16 per unit of axis ratio.

    Returns:
        Displacement, positive into the body [L].

    Raises:
        ValueError: a value outside its range. TypeError: no numbers.
    """
    x, y = checks.points(x, y)
    a, b = checks.number("a", a, "[L]"), checks.number("b", b, "[L]")
    E, nu = checks.number("Young's modulus E", E, "[F/L^2]", infinite=True), checks.poisson("Poisson's ratio nu", nu)
    num = 48 + math.ceil(16 * max(a / b, b / a)) if num is None else int(checks.number("num", num, low=3, closed=True))
    nodes, weights = np.polynomial.legendre.leggauss(num)
    nodes, weights = nodes * math.pi / 2, weights * math.pi / 2
    u = np.empty(x.shape)
    for index, X in np.ndenumerate(x):
        # In coordinates scaled by a and b the ellipse is a circle and the chord of a ray symmetric about its middle.
        X, Y = X / a, y[index] / b
        distance = math.hypot(X, Y)
        if distance <= 1.0:
            angle, rays = np.arange(num) * (math.pi / num), np.full(num, math.pi / num)
        else:
            width = math.asin(1.0 / distance)  # half of the angle the circle is seen under
            angle, rays = math.atan2(Y, X) + width * np.sin(nodes), width * weights * np.cos(nodes)
        cos, sin = np.cos(angle)[:, None], np.sin(angle)[:, None]
        half = checks.root(1.0 - (X * sin - Y * cos) ** 2)
        along = half * np.sin(nodes) - (X * cos + Y * sin)
        p = pressure(a * (X + along * cos), b * (Y + along * sin))
        chord = np.sum(p * half * np.cos(nodes) * weights, axis=1)
        u[index] = np.sum(rays * chord / np.hypot(a * cos, b * sin)[:, 0]) * a * b
    return ((1.0 - nu**2) / (math.pi * E) * u)[()]


def half_plane_displacement(
    pressure: Callable[..., Any], x: ArrayLike, half_width: float, E: float, nu: float
) -> FloatArray | float:
    """u_z(x) - u_z(0) = -2 (1 - nu^2)/(pi E) int p(s) ln|(x - s)/s| ds: (3.6) in plane strain, Johnson 2.3.

    Args:
        pressure: function of x [L] -> [F/L^2] on -half_width < x < half_width.
        x: where; scalar or array [L].
        half_width: positive [L].
        E, nu: elastic constants of the body; E = np.inf gives zero [F/L^2; 1].

    Returns:
        Displacement relative to the origin, positive into the body [L]; the absolute one is not determined.

    Raises:
        ValueError: a value outside its range. TypeError: no numbers.
    """
    x = checks.points(x)
    a = checks.number("half_width", half_width, "[L]")
    E, nu = checks.number("Young's modulus E", E, "[F/L^2]", infinite=True), checks.poisson("Poisson's ratio nu", nu)

    def integral(X: float) -> float:
        if X == 0.0:
            return 0.0
        # s = a sin(angle) takes the roots at the edges; the pieces end at the logarithms' singular points.
        ends = sorted({-math.pi / 2, 0.0, math.asin(max(-1.0, min(1.0, X / a))), math.pi / 2})

        def value(angle: float) -> float:
            s = a * math.sin(angle)
            kernel = math.log(abs((X - s) / s)) if s != 0.0 and s != X else 0.0  # nodes that fall on the singular point
            return float(pressure(s)) * math.cos(angle) * a * kernel

        pieces = zip(ends[:-1], ends[1:])
        return sum(
            scipy.integrate.quad(value, low, high, epsabs=0.0, epsrel=1e-10, limit=200)[0] for low, high in pieces
        )

    u = np.array([integral(X) for X in x.ravel()]).reshape(x.shape)
    return (-2.0 * (1.0 - nu**2) / (math.pi * E) * u)[()]
