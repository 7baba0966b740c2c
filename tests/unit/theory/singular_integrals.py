# SPDX-License-Identifier: MIT
"""Integrals of half-plane theory, done by quadrature that knows nothing of the closed forms."""

import math

import numpy as np
from scipy.integrate import quad


def cauchy(q, x, a, breaks=()):
    """Principal value of the integral of q(s)/(x - s) over -a < s < a, for |x| < a and q with roots at the ends.

    The singular part is taken out, PV int ds/(x - s) = ln((a + x)/(a - x)); breaks: where q has kinks.
    """
    qx = float(q(x))

    def value(angle):
        s = a * math.sin(angle)
        return (float(q(s)) - qx) / (x - s) * a * math.cos(angle) if s != x else 0.0

    ends = sorted({-math.pi / 2, math.pi / 2, *(math.asin(b / a) for b in (x, *breaks))})
    total = sum(quad(value, low, high, epsabs=0, epsrel=1e-9, limit=300)[0] for low, high in zip(ends[:-1], ends[1:]))
    return total + qx * math.log((a + x) / (a - x))


def integral_of_punch(q, a):
    """Integral of q(s) over -a < s < a for q that grows like 1/sqrt at the ends.

    s = a tanh(t) makes it decay exponentially; then the trapezoidal rule converges exponentially, too. Cut at
    |t| = 17.5, where tanh still differs from 1.
    """
    t = np.linspace(-17.5, 17.5, 1401)
    return np.sum(q(a * np.tanh(t)) * a / np.cosh(t) ** 2) * (t[1] - t[0])


def cauchy_of_punch(q, x, a):
    """Principal value of the integral of q(s)/(x - s) for the same q, |x| < a.

    With s = a tanh(t), x = a tanh(t0) it is q/cosh(t) cosh(t0)/sinh(t0 - t) dt. Both sides of t0 are taken together
    with nodes between the singular point: an even integrand, and again the trapezoidal rule.
    """
    t0 = math.atanh(x / a)
    step = 0.025
    u = (np.arange(int((17.5 - abs(t0)) / step)) + 0.5) * step
    difference = [q(a * np.tanh(t)) / np.cosh(t) for t in (t0 - u, t0 + u)]
    return math.cosh(t0) * np.sum((difference[0] - difference[1]) / np.sinh(u)) * step


def tangential_displacement(traction, kinks, a, nu, x, y, num=60):
    """2 pi G u_x(x, y) inside under a traction q(r) along x on r < a: int q [1 - nu + nu cos^2(angle)] d rho d angle.

    Johnson (3.87) in polar coordinates about (x, y). kinks: radii where q is not smooth; nodes crowd at them and at a.
    """
    nodes, weights = np.polynomial.legendre.leggauss(num)
    shape, weights = np.sin(nodes * np.pi / 2), weights * np.cos(nodes * np.pi / 2) * np.pi / 2
    total, rays = 0.0, 400
    for angle in np.arange(rays) * np.pi / rays:
        c, s = math.cos(angle), math.sin(angle)
        middle, off = -(x * c + y * s), x * s - y * c
        halves = [math.sqrt(r * r - off * off) for r in (*kinks, a) if r > abs(off)]
        ends = sorted({middle + sign * half for half in halves for sign in (-1, 1)})
        chord = 0.0
        for low, high in zip(ends[:-1], ends[1:]):
            rho = (low + high) / 2 + (high - low) / 2 * shape
            chord += np.sum(traction(np.hypot(x + rho * c, y + rho * s)) * weights) * (high - low) / 2
        total += chord * (1 - nu + nu * c * c) * np.pi / rays
    return total
