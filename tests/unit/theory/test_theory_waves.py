# SPDX-License-Identifier: MIT
"""Waves after the impact of bars, and the error of their fronts: conservation, limits, a bar computed in ten lines."""

import numpy as np
import pytest

from dolfinx_impact import theory
from dolfinx_impact.theory import waves

WALL = (10.0, 2.0, 3.0, 12.0)  # c = 2, Z = 6, release at 2
CASES = {"wall": WALL, "equal": (*WALL, 3.0, 12.0), "harder": (*WALL, 5.0, 45.0), "stiffer": (*WALL, 5.0, 200.0)}


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("t", (0.3, 0.9, 1.4, 1.9, 2.3))
def test_momentum_and_energy_are_those_of_the_impact(name, t):
    """Integrals over both bars by the midpoint rule; what jumps is off by a cell."""
    case = CASES[name]
    exact = theory.bar_impact(*case)
    v0, length, rho, E = case[:4]
    # The second bar's wave comes back on the way; in equal bars of equal length it turns round once more.
    length2 = {"stiffer": 20.0, "harder": 4.0}.get(name, 2.0)
    ends = -length, 0.0 if name == "wall" else length2
    impulse = exact.stress * min(t, 2.0) if name == "wall" else 0.0
    x = np.linspace(*ends, 200001)
    x, dx = (x[1:] + x[:-1]) / 2, x[1] - x[0]
    stress, v = waves.bar_waves(x, t, *case, **({} if name == "wall" else {"length2": length2}))
    density, modulus = ((np.where(x < 0, a, b)) for a, b in zip((rho, E), case[4:] or (rho, E)))
    tolerance = 8 * dx / length  # four fronts at most, of twice the speed at the free ends
    assert np.sum(density * v) * dx == pytest.approx(rho * length * v0 - impulse, abs=tolerance * rho * length * v0)
    energy = np.sum(density * v**2 + stress**2 / modulus) * dx / 2
    assert energy == pytest.approx(rho * length * v0**2 / 2, rel=tolerance)


def test_places_behind_the_wall():
    with pytest.raises(ValueError, match="rigid wall"):
        waves.bar_waves([0.1], 0.5, *WALL)


def test_a_pulse_with_a_spring():
    """It opens where (1 + a) exp(-a) = 1/2 on a wall, never with echo 1; it brings the impulse T + lag then."""
    t = np.linspace(0.0, 30.0, 300001)
    wall, one = (waves.contact_pulse(t, 10.0, 0.5, echo) for echo in (2.0, 1.0))
    assert t[np.flatnonzero(wall)[-1]] == pytest.approx(10.0 + 1.678347 * 0.5, abs=2e-4)  # two points
    assert np.trapezoid(one, t) == pytest.approx(10.5, abs=1e-6) and one.min() >= 0.0
    # Solved as an equation: lag p' + p = 1 - 2 p(t - T) until it opens.
    p, dt, delay = np.zeros(120001), 1e-4, 100000
    for i in range(len(p) - 1):
        drive = 1.0 - (2.0 * p[i - delay] if i >= delay else 0.0)
        p[i + 1] = p[i] + dt * (drive - p[i]) / 0.5
    p, t = p[::10], np.arange(12001) * 1e-3
    p[np.logical_or.accumulate((p < 0) & (t > 10.0))] = 0.0
    np.testing.assert_allclose(waves.contact_pulse(t, 10.0, 0.5, 2.0), p, atol=2 * dt / 0.5)  # Euler is of order 1


def test_error_of_a_front_far_from_the_mesh():
    """Orders and sizes of the two limits."""
    for courant in (0.3, 0.9):
        h = 1e-5
        limit = 0.864 * ((1 - courant**2) * 0.7 * h**2 / 24) ** (1 / 6)
        assert waves.front_error(0.7, h, courant) == pytest.approx(limit, rel=0.02)
    # The step of the band's end: with courant 1 nothing is lost but what no mesh can show.
    assert waves.front_error(0.7, 0.01, 1.0) == pytest.approx(0.1 / np.pi, rel=1e-9)
    # The spectrum beyond the band, 1/(pi lag) of a cell each, counts twice at most.
    assert waves.front_error(0.7, 1e-3, 1.0, lag=0.2) == pytest.approx(np.sqrt(0.1), rel=1e-2)


@pytest.mark.parametrize("courant", (0.5, 0.9))
@pytest.mark.parametrize("n", (100, 400, 1600))
def test_error_of_a_front_in_a_bar(courant, n):
    """A bar whose end is moved with the speed 1: strain -1 behind the front."""
    h, distance = 1.0 / n, 0.6
    steps = round(distance * n / courant)
    u, v = np.zeros(n + 1), np.zeros(n + 1)
    v[0] = 1.0
    for _ in range(steps):
        v[1:-1] += courant / h * np.diff(u, 2)
        u += courant * h * v
    x = (np.arange(20 * n) + 0.5) / (20 * n)
    found = np.sqrt(np.mean((np.repeat(np.diff(u) / h, 20) + (x < steps * courant * h)) ** 2))
    # How elements show the end of the band is not said by its modes: as much again as what is beyond it, h/pi^2.
    assert found**2 == pytest.approx(waves.front_error(distance, h, courant) ** 2, abs=2 * h / np.pi**2)


def test_front_of_a_bar_is_that_of_airy():
    """Width and lost impulse by a computed bar: where the stress of the front is half, and what the part of
    1 - 2 stress before that misses of its time."""
    n, courant, distance = 1600, 0.5, 0.5
    h, dt = 1.0 / n, 0.5 / n
    u, v, seen = np.zeros(n + 1), np.zeros(n + 1), []
    v[0] = 1.0
    for _ in range(round(0.55 / dt)):
        v[1:-1] += courant / h * np.diff(u, 2)
        u += courant * h * v
        seen.append(-(u[n // 2 + 1] - u[n // 2 - 1]) / (2 * h))
    t, stress = dt * np.arange(1, len(seen) + 1), np.array(seen)
    width = waves.front_width(distance, h, courant)
    half = np.argmax(stress > 0.5)
    when = np.interp(0.5, stress[half - 1 : half + 1], t[half - 1 : half + 1])
    # The fronts' next terms are smaller by (h/width)^2, 2 %, of a width.
    assert when - distance == pytest.approx(0.42 * width, abs=0.03 * width)
    lost = distance - t[0] - np.trapezoid(1 - 2 * stress[:half], t[:half])
    assert lost == pytest.approx(waves.early_release(2.0) * width, abs=0.03 * width)
    with pytest.raises(ValueError, match="echo"):
        waves.early_release(1.0)
