# SPDX-License-Identifier: MIT
"""Waves in bars after an impact, and what springs, lumped masses and central differences make of their fronts.

Johnson 11.1; seed (3.82). A computation of an impact is judged by these: the solution jumps, so that its error has an
order and a size that are known beforehand.
"""

import numpy as np
import scipy

from . import checks
from ..common.types import ArrayLike, FloatArray
from .impact import bar_impact


def bar_waves(
    x: ArrayLike,
    t: ArrayLike,
    velocity: float,
    length: float,
    density: float,
    E: float,
    density2: float | None = None,
    E2: float | None = None,
    length2: float = np.inf,
) -> tuple[FloatArray, FloatArray]:
    """Stress and velocity in a bar that strikes a rigid wall or the end of another bar at rest, at x = 0.

    Sums of the waves that leave the contact and of what comes back from the free ends. Until the second bar's wave has
    been at its ends once more, 4 length2/c2; until its release is at the contact if the bars have not separated then.

    Args:
        x: places in the undeformed bars: below zero in the striker, above zero in the second bar [L].
        t: time after first touch; broadcast against x [T].
        velocity, length, density, E, density2, E2: as for bar_impact; the striker moves towards positive x.
        length2: of the second bar [L].

    Returns:
        Stress, positive in compression [F/L^2], and velocity [L/T].

    Raises:
        ValueError: as bar_impact; places in a second bar that is none.
    """
    exact = bar_impact(velocity, length, density, E, density2, E2)
    x, t = np.asarray(x, dtype=float), np.asarray(t, dtype=float)
    second = x > 0
    if density2 is None and np.any(second):
        raise ValueError("x is positive: a bar on a rigid wall has places below zero only")
    c2, Z2 = (np.sqrt(E2 / density2), np.sqrt(E2 * density2)) if density2 is not None and E2 is not None else (1.0, 1.0)
    c, Z, end = np.where(second, c2, exact.wave_speed), np.where(second, Z2, -np.sqrt(E * density)), np.abs(x)
    # The second bar's wave ends with the contact, the striker's is kept up by its own echo.
    lasts = np.where(second & exact.separates, exact.release_time, np.inf)
    far = 2 * np.where(second, length2, length)
    # What comes back to an end that is free by then turns round there; the striker's is in its echo.
    ways = (end, far - end, np.where(second, far + end, np.inf))
    out, back, again = (((t > way / c) & (t - way / c < lasts)).astype(float) for way in ways)
    v = np.where(second, 0.0, velocity) + exact.stress / Z * (out + back + again)
    return exact.stress * (out - back + again), v


def contact_pulse(t: FloatArray | float, release_time: float, lag: float, echo: float) -> FloatArray | float:
    """Contact stress over that of bar_impact where a spring is between the bars; zero from where it opens.

    With H = 1/(1 + s lag): the step's answer H less, from `release_time` on, `echo` times H^2, as the release has
    passed the spring before. Valid until 2 release_time.

    Args:
        t: time after first touch [T].
        release_time: 2 L/c [T].
        lag: 1/(chi (1/Z1 + 1/Z2)), chi the stiffness per area, Z = rho c; a wall has 1/Z2 = 0 [T].
        echo: 2 Z2/(Z1 + Z2): 2 on a wall; for each bar whose release is back at `release_time` [1].
    """
    a, b = np.maximum(t, 0.0) / lag, np.maximum(t - release_time, 0.0) / lag
    pulse = 1 - np.exp(-a) - echo * (1 - (1 + b) * np.exp(-b))
    return np.where(np.logical_or.accumulate((pulse < 0) & (b > 0)), 0.0, pulse)


def front_error(distance: float, h: float, courant: float, lag: float = 0.0) -> float:
    """L2 error of a jump of 1 that has run through a bar of linear elements, lumped masses, central differences.

    By Parseval from the phase that every wave number k loses, k c - omega times the time, with
    sin(omega dt/2) = courant sin(k h/2), and from the spectrum 1/k of the jump. As long as the front is many cells
    wide this is 0.864 ((1 - courant^2) distance h^2/24)^(1/6): order 1/3. A spring in the contact, whose answer is
    1/(1 + i k lag), leaves sqrt(lag/2) alone, of order 1/2 where the lag is some cells.

    Args:
        distance: that the front has come [L].
        h: length of the cells [L].
        courant: c dt/h, at most 1 [1].
        lag: of the spring times c [L].

    Returns:
        The error over the jump [L^(1/2)].
    """
    distance, h = checks.number("distance", distance, "[L]", closed=True), checks.number("h", h, "[L]")
    courant = checks.number("courant", courant, high=1.0)
    lag = checks.number("lag", lag, "[L]", closed=True)
    # Enough points for the fastest turning phase, pi distance/h at the end of the band.
    count = 4000 + 50 * int(distance / h)
    x = (np.arange(count) + 0.5) * (np.pi / count)  # k h
    phase = distance / h * (x - 2 / courant * np.arcsin(courant * np.sin(x / 2)))
    lost = np.abs(1 - np.exp(-1j * phase) / (1 + 1j * x * lag / h)) ** 2 / x**2
    # Beyond the band of the mesh the jump is missing altogether: 1/pi times the integral of 1/x^2 from pi on.
    return float(np.sqrt(h / np.pi * (lost.sum() * np.pi / count + 1 / np.pi)))


def front_width(distance: float, h: float, courant: float) -> float:
    """Width of a front of front_error without spring: far from the mesh it is the integral of Airy's function of
    (place - c t)/width; half its height is 0.42 widths behind its place [L].

    Args:
        distance, h, courant: as for front_error.
    """
    distance, h = checks.number("distance", distance, "[L]", closed=True), checks.number("h", h, "[L]")
    return (distance * h**2 * (1 - checks.number("courant", courant, high=1.0) ** 2) / 8) ** (1 / 3)


def early_release(echo: float) -> float:
    """Impulse that a contact without spring lacks, as its release comes by such a front: in units of stress times
    width over c.

    The contact stress falls as 1 - echo F, F the integral of Airy's function from infinity; where it is zero the
    contact opens and takes no part in the rest of the front.

    Args:
        echo: as for contact_pulse, more than 1 [1].
    """
    echo = checks.number("echo", echo, low=1.0)

    def front(xi: float) -> float:
        """Integral of Ai from xi to infinity; itairy's are from 0 to abs(xi)."""
        return 1 / 3 - scipy.special.itairy(xi)[0] if xi >= 0 else 1 / 3 + scipy.special.itairy(-xi)[2]

    # Up to the first zero of Ai the integral rises.
    xi = scipy.optimize.brentq(lambda xi: front(xi) - 1 / echo, -2.338, 10.0)
    return float(-echo * scipy.special.airy(xi)[1])
