# SPDX-License-Identifier: MIT
"""Hertz's elliptical contact, seed (3.7), (3.8), corrected."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import dblquad, quad
from scipy.special import ellipe, ellipk

from dolfinx_impact import theory

STEEL = (207e9, 0.3, 207e9, 0.3)


def wheel(load=130e3):
    """Wheel with a rolling radius of 0.46 m on a rail crown of 0.30 m [N, m]."""
    return theory.hertz_elliptic(load, 0.46, np.inf, np.inf, 0.30, *STEEL)


@pytest.mark.parametrize(
    "load, a, b, p0, approach, stiffness",
    [
        (80, 6.68027, 5.02505, 1137.880, 90.5918, 1.32462),
        (100, 7.19611, 5.41307, 1225.744, 105.1225, 1.42691),
        (125, 7.75177, 5.83106, 1320.393, 121.9839, 1.53709),
        (130, 7.85378, 5.90779, 1337.769, 125.2155, 1.55732),
        (150, 8.23749, 6.19642, 1403.127, 137.7495, 1.63340),
    ],
)
def test_wheel_on_rail(load, a, b, p0, approach, stiffness):
    found = wheel(load * 1e3)
    # Half a unit of the last digit printed.
    assert found.a * 1e3 == pytest.approx(a, abs=5e-6) and found.b * 1e3 == pytest.approx(b, abs=5e-6)
    assert found.peak_pressure / 1e6 == pytest.approx(p0, abs=5e-4)
    assert found.approach * 1e6 == pytest.approx(approach, abs=5e-5)
    assert found.stiffness / 1e9 == pytest.approx(stiffness, abs=5e-6)
    assert found.b / found.a == pytest.approx(0.752222, abs=5e-7)


def test_long_axis_along_y():
    """CONTACT's example tractcurv: P = 106.7 kN, G = 82 GPa, nu = 0.28, a/b = 0.5 [N, mm]."""
    E, Ay = 2 * 82e3 * 1.28, 0.0008 * 0.3007  # near the answer; the ratio is matched below

    def contact(Ry):
        return theory.hertz_elliptic(106.7e3, 625.0, Ry, np.inf, np.inf, E, 0.28, E, 0.28)

    low, high = 0.5 / Ay * 0.5, 0.5 / Ay * 2
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if contact(middle).a / contact(middle).b > 0.5 else (low, middle)
    found = contact(low)
    # Exact values to the digits printed; CONTACT's own grid gives 640.7 and 0.07651.
    assert (found.a, found.b) == (pytest.approx(6.30360, abs=5e-6), pytest.approx(12.60719, abs=5e-6))
    assert (found.peak_pressure, found.approach) == (pytest.approx(641.06, abs=5e-3), pytest.approx(0.076517, abs=5e-7))


def integrals(contact):
    """Right-hand sides of the three equations (3.8) by quadrature, z = b^2 t^2 [1/L, 1/L, L]."""
    a2, b2 = (contact.a / contact.b) ** 2, 1.0
    factor = 0.75 * contact.load / (math.pi * contact.bodies.modulus)

    def total(power_a, power_b):
        def value(u):  # t = exp(u): a needle has scales far apart
            t2 = math.exp(2 * u)
            return 2 * math.exp(u) * (a2 + t2) ** -power_a * (b2 + t2) ** -power_b

        return quad(value, -40.0, 40.0 + math.log(a2 + 1.0), epsabs=0, epsrel=1e-11, limit=400)[0]

    b = contact.b
    return factor * total(1.5, 0.5) / b**3, factor * total(0.5, 1.5) / b**3, factor * total(0.5, 0.5) / b


@given(st.floats(-6.0, 6.0), st.floats(-3.0, 3.0), st.floats(-0.9, 0.5))
def test_the_integrals_of_the_seed(log_ratio, log_radius, nu):
    """(3.8) for curvature ratios from 1e-6 to 1e6."""
    Rx, Ry = 10.0**log_radius, 10.0 ** (log_radius + log_ratio)
    contact = theory.hertz_elliptic(2.0, Rx, Ry, np.inf, np.inf, 3.0, nu, 7.0, 0.3)
    A, B, approach = integrals(contact)
    # Quadrature 1e-11, the ratio of the axes is found to about 1e-15, and curvatures hang on its square.
    assert (A * 2 * Rx, B * 2 * Ry) == pytest.approx((1.0, 1.0), rel=1e-9)
    assert approach == pytest.approx(contact.approach, rel=1e-9)
    assert (contact.a - contact.b) * (Rx - Ry) >= 0  # radii that differ by one bit give a circle
    assert contact.peak_pressure == pytest.approx(3.0 / (2 * math.pi * contact.a * contact.b) * 2.0, rel=1e-14)
    swapped = theory.hertz_elliptic(2.0, Ry, Rx, np.inf, np.inf, 3.0, nu, 7.0, 0.3)
    assert (swapped.a, swapped.b, swapped.approach) == (
        contact.b,
        contact.a,
        pytest.approx(contact.approach, rel=1e-15),
    )


def test_complete_elliptic_integrals():
    """The same in Legendre's form, m = 1 - b^2/a^2."""
    c = wheel()
    m = 1 - (c.b / c.a) ** 2
    K, E, scale = ellipk(m), ellipe(m), c.peak_pressure / c.bodies.modulus * c.b
    # K - E cancels to some 3 digits here.
    assert scale * (K - E) / (m * c.a**2) == pytest.approx(1 / 0.92, rel=1e-12)
    assert scale / (m * c.a**2) * (c.a**2 * E / c.b**2 - K) == pytest.approx(1 / 0.60, rel=1e-12)
    assert scale * K == pytest.approx(c.approach, rel=1e-13)


def test_the_circle_is_exact_and_met_smoothly():
    sphere = theory.hertz_point(1e3, 0.01, np.inf, *STEEL)
    circle = theory.hertz_elliptic(1e3, 0.01, 0.01, np.inf, np.inf, *STEEL)
    assert circle.a == circle.b
    found = circle.a, circle.approach, circle.peak_pressure
    assert found == pytest.approx((sphere.a, sphere.approach, sphere.peak_pressure), rel=1e-14)  # round-off
    for e in (1e-15, 1e-13, 1e-12, 1e-11, 1e-9, 1e-6, 1e-4):
        near = theory.hertz_elliptic(1e3, 0.01, 0.01 * (1 + e), np.inf, np.inf, *STEEL)
        # b/a = (Ry/Rx)^(2/3) to first order; the next term is of order e^2.
        assert near.b / near.a == pytest.approx((1 + e) ** (2 / 3), abs=2e-15 + e * e)
        assert near.a == pytest.approx(sphere.a, rel=2e-15 + e)


def test_the_needle_is_a_line_contact():
    """In the middle of a long ellipse the load per length is pi/2 p0 b, and b and p0 are those of hertz_line."""
    for ratio, tolerance in ((1e4, 2e-3), (1e8, 1e-6), (1e14, 1e-10)):  # the rest is of order (b/a)^2 ln(a/b)
        c = theory.hertz_elliptic(1e3, 0.01 * ratio, 0.01, np.inf, np.inf, *STEEL)
        line = theory.hertz_line(math.pi / 2 * c.peak_pressure * c.b, 0.01, np.inf, *STEEL)
        assert line.half_width == pytest.approx(c.b, rel=tolerance)
        assert line.peak_pressure == pytest.approx(c.peak_pressure, rel=tolerance)


def test_pressure_carries_the_load():
    c = wheel()
    total, _ = dblquad(
        lambda r, t: c.pressure(c.a * r * math.cos(t), c.b * r * math.sin(t)) * c.a * c.b * r, 0, 2 * np.pi, 0, 1
    )
    assert total == pytest.approx(130e3, rel=1e-7)  # dblquad at a root
    outside = c.pressure(np.array([c.a, 0.0, 0.8 * c.a]), np.array([0.0, -c.b, 0.8 * c.b]))
    assert outside == pytest.approx(0.0, abs=1e-6 * c.peak_pressure)  # the root of round-off at the edge
    assert c.pressure(1.01 * c.a, 0.0) == 0.0 and c.pressure(0.0, 0.0) == c.peak_pressure


def test_scaling():
    one, eight = wheel(100e3), wheel(800e3)
    assert (eight.a / one.a, eight.b / one.b) == pytest.approx((2.0, 2.0), rel=1e-13)
    assert (eight.peak_pressure / one.peak_pressure, eight.approach / one.approach) == pytest.approx((2, 4), rel=1e-13)
    assert one.load_at(eight.approach) == pytest.approx(800e3, rel=1e-13)


def test_crossed_cylinders():
    """Equal cylinders at a right angle are a sphere on a plane; at an angle the ellipse turns by half of it."""
    crossed = theory.hertz_elliptic(1.0, 2.0, np.inf, 2.0, np.inf, *STEEL, angle=math.pi / 2)
    sphere = theory.hertz_point(1.0, 2.0, np.inf, *STEEL)
    assert (crossed.a, crossed.b) == pytest.approx((sphere.a, sphere.a), rel=1e-14)  # cos(pi) and sin(pi) round off
    askew = theory.hertz_elliptic(1.0, 2.0, np.inf, 2.0, np.inf, *STEEL, angle=math.radians(30))
    assert askew.rotation == pytest.approx(math.radians(15), rel=1e-14)
    assert askew.b > askew.a  # long across the mean direction of curvature, that is along the mean of the axes


def test_flat_along_one_direction():
    with pytest.raises(ValueError, match="hertz_line"):
        theory.hertz_elliptic(1.0, 2.0, np.inf, np.inf, np.inf, *STEEL)
