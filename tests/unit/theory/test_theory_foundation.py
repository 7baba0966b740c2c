# SPDX-License-Identifier: MIT
"""Winkler's foundation, seed (3.9)-(3.12), corrected."""

import math

import numpy as np
import pytest
from scipy.integrate import dblquad, quad

from dolfinx_impact import theory

POINT = theory.winkler(1e-4, 0.46, 0.30, 100e9, 0.01)  # [m, N]
LINE = theory.winkler(1e-4, 0.46, np.inf, 100e9, 0.01)


def test_numbers():
    # Half a unit of the last digit printed.
    assert (POINT.a * 1e3, POINT.b * 1e3) == (pytest.approx(9.59166, abs=5e-6), pytest.approx(7.74597, abs=5e-6))
    assert POINT.peak_pressure == pytest.approx(1000e6, rel=1e-15)
    assert POINT.load == pytest.approx(116704.99, abs=5e-3)
    assert LINE.load == pytest.approx(12.788884e6, abs=0.5)
    assert LINE.a == POINT.a and LINE.b == math.inf
    assert POINT.load == pytest.approx(math.pi * 100e9 * 1e-4**2 * math.sqrt(0.46 * 0.30) / 0.01, rel=1e-14)


def test_pressure_is_a_spring_force_and_carries_the_load():
    x, y = np.array([0.0, 3e-3, 9e-3, 1e-2]), np.array([0.0, -2e-3, 5e-3, 0.0])
    assert POINT.pressure(x, y) == pytest.approx(1e13 * POINT.displacement(x, y), rel=1e-15)
    assert POINT.displacement(x, y)[1] == pytest.approx(1e-4 - 9e-6 / 0.92 - 4e-6 / 0.60, rel=1e-14)
    assert np.all(POINT.pressure(x, y)[2:] == 0)  # outside the ellipse
    # A polynomial up to the edge: the quadratures are good to round-off but for the kink they do not see.
    a, b = POINT.a, POINT.b
    total, _ = dblquad(
        lambda r, t: POINT.pressure(a * r * math.cos(t), b * r * math.sin(t)) * a * b * r, 0, 2 * np.pi, 0, 1
    )
    assert total == pytest.approx(POINT.load, rel=1e-12)
    assert quad(LINE.pressure, -a, a)[0] == pytest.approx(LINE.load, rel=1e-12)


def test_the_printed_plus_sign_is_refuted():
    """Seed (3.11) as printed adds y^2: it would press at y beyond the ellipse."""
    assert POINT.pressure(0.0, 1.01 * POINT.b) == 0.0 and POINT.pressure(0.0, 0.99 * POINT.b) > 0.0


@pytest.mark.parametrize("radii", [(0.46, 0.30), (0.46, np.inf), (np.inf, 0.2)])
def test_stiffness_is_the_slope_of_the_load(radii):
    h = 1e-8
    loads = [theory.winkler(1e-4 + s, *radii, 100e9, 0.01).load for s in (-h, 0, h)]
    slope = (loads[2] - loads[0]) / (2 * h)  # error of order h^2
    assert theory.winkler(1e-4, *radii, 100e9, 0.01).stiffness == pytest.approx(slope, rel=1e-7)


def test_line_along_either_axis():
    other = theory.winkler(1e-4, np.inf, 0.46, 100e9, 0.01)
    assert (other.load, other.b, other.a) == (LINE.load, LINE.a, math.inf)
    assert other.pressure(5.0, 1e-3) == LINE.pressure(1e-3, 5.0) > 0
    with pytest.raises(ValueError, match="both infinite"):
        theory.winkler(1e-4, np.inf, np.inf, 100e9, 0.01)
