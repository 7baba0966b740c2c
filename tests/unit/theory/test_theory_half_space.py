# SPDX-License-Identifier: MIT
"""The contact conditions, seed (3.4) and (3.5), from pressures put through the integrals (3.6), corrected."""

import math

import numpy as np
import pytest
from scipy.integrate import dblquad

from dolfinx_impact import theory

CONSTANTS = (210e3, 0.3, 70e3, 0.2)
POINT = theory.hertz_point(1e3, 10.0, -40.0, *CONSTANTS)
WHEEL = theory.hertz_elliptic(130e3, 460.0, np.inf, np.inf, 300.0, *CONSTANTS)
NEEDLE = theory.hertz_elliptic(1e3, 10.0, 2000.0, np.inf, np.inf, *CONSTANTS)
LINE = theory.hertz_line(4e3, 460.0, np.inf, *CONSTANTS)
ROLLER = theory.hertz_line(4e3, 460.0, -500.0, 210e3, 0.3, np.inf, 0.3)


def curvatures(contact):
    half = 0.5 / contact.radius if hasattr(contact, "radius") else None
    return (half, half) if half else (contact.curvature.A, contact.curvature.B)


@pytest.mark.parametrize("contact", [POINT, WHEEL, NEEDLE], ids=["point", "wheel", "needle"])
def test_both_bodies_touch_inside_and_part_outside(contact, rng):
    """(3.6) for each body with its own constants, added; then (3.4) in contact and the inequality (3.5) outside."""
    E1, nu1, E2, nu2 = CONSTANTS
    A, B = curvatures(contact)
    r = np.concatenate([np.sqrt(rng.uniform(0, 1, 12)), [1.0, 1.001, 1.1], rng.uniform(1, 3, 8)])
    angle = rng.uniform(0, 2 * np.pi, len(r))
    x, y = contact.a * r * np.cos(angle), contact.b * r * np.sin(angle)
    u1 = theory.half_space_displacement(contact.pressure, x, y, contact.a, contact.b, E1, nu1)
    u2 = theory.half_space_displacement(contact.pressure, x, y, contact.a, contact.b, E2, nu2)
    gap = u1 + u2 - (contact.approach - A * x**2 - B * y**2)
    # The quadrature converges exponentially; 1e-10 leaves room for needles, 1e-6 was asked for.
    tolerance = 1e-10 * contact.approach
    assert gap[r <= 1.0] == pytest.approx(0.0, abs=tolerance)
    assert np.all(gap[r > 1.0] > 0)
    # The closed forms of displacement and gap say the same.
    assert contact.displacement(x, y) == pytest.approx(u1 + u2, abs=tolerance)
    assert contact.displacement(x, y, body=1) == pytest.approx(u1, abs=tolerance)
    assert contact.displacement(x, y, body=2) == pytest.approx(u2, abs=tolerance)
    assert contact.gap(x, y) == pytest.approx(gap, abs=tolerance)
    assert np.all(contact.gap(x, y)[r < 1.0] == 0.0)


def test_printed_inequality_is_refuted():
    """The number of the errata: just outside, at r = 1.1 a, the sum of displacements is above the parabola."""
    sphere = theory.hertz_point(1.0, 1.0, np.inf, 1.0, 0.0, np.inf, 0.0)
    u = theory.half_space_displacement(sphere.pressure, 1.1 * sphere.a, 0.0, sphere.a, sphere.a, 1.0, 0.0)
    assert u > sphere.approach - (1.1 * sphere.a) ** 2 / 2
    # delta (1 - 1.21/2) = 0.395 delta against 0.4328 delta.
    assert u / sphere.approach == pytest.approx(0.4328, abs=5e-5)


@pytest.mark.parametrize("contact", [LINE, ROLLER], ids=["two bodies", "rigid roller in a bore"])
def test_line_contact(contact):
    x = np.array([-2.5, -1.2, -1.001, -0.9, -0.3, 0.0, 0.2, 0.99, 1.05, 3.0]) * contact.half_width
    b, a = contact.bodies, contact.half_width
    u1 = theory.half_plane_displacement(contact.pressure, x, a, b.E1, b.nu1)
    u2 = theory.half_plane_displacement(contact.pressure, x, a, b.E2, b.nu2)
    gap = u1 + u2 + x**2 / (2 * contact.radius)
    tolerance = 1e-9 * a**2 / contact.radius  # quad is asked for 1e-10 per piece
    inside = np.abs(x) < a
    assert gap[inside] == pytest.approx(0.0, abs=tolerance)
    assert np.all(gap[~inside] > 0)
    assert contact.gap(x) == pytest.approx(gap, abs=tolerance)
    assert contact.displacement(x) == pytest.approx(u1 + u2, abs=tolerance)
    assert contact.displacement(x, body=1) == pytest.approx(u1, abs=tolerance)
    assert np.all(contact.displacement(x, body=2) == 0) == (b.E2 == math.inf)


def test_far_away_it_is_a_point_load():
    """Boussinesq: u = (1 - nu^2) P/(pi E r); the next term is of order (a/r)^2."""
    r = 1e3 * POINT.a
    u = theory.half_space_displacement(POINT.pressure, r, 0.0, POINT.a, POINT.a, 210e3, 0.3)
    assert u == pytest.approx(0.91 * 1e3 / (math.pi * 210e3 * r), rel=1e-6)


def test_uniform_pressure_on_a_circle():
    """Love: 2 (1 - nu^2) p a/E in the middle, 2/pi of that at the edge; Johnson (3.25)."""
    u = theory.half_space_displacement(lambda x, y: np.ones_like(x), [0.0, 2.0], 0.0, 2.0, 2.0, 5.0, 0.3, num=200)
    # The chord's length has a corner where the point lies on the edge: the rays' error there falls with 1/num^2.
    assert u == pytest.approx([2 * 0.91 * 2.0 / 5.0, 4 * 0.91 * 2.0 / (math.pi * 5.0)], rel=1e-4)


def test_one_sided_pressure_on_a_strip():
    """Pressure p (1 + x/a), whose integral of logarithms is elementary: an oracle that is not symmetric."""
    a, E, nu = 2.0, 3.0, 0.25

    def potential(x):
        """int (1 + s/a) ln|x - s| ds over the strip: with t = x - s, int (1 + x/a - t/a) ln|t| dt."""

        def upto(t):
            return (1 + x / a) * t * (math.log(abs(t)) - 1) - t * t / a * (math.log(abs(t)) / 2 - 0.25)

        return upto(x + a) - upto(x - a)

    x = np.array([-3.0, -1.2, 0.7, 1.9, 5.0])
    expected = [-2 * (1 - nu**2) / (math.pi * E) * 7.0 * (potential(s) - potential(0.0)) for s in x]
    found = theory.half_plane_displacement(lambda s: 7.0 * (1 + s / a), x, a, E, nu)
    assert found == pytest.approx(expected, rel=1e-8)  # quad is asked for 1e-10 per piece


def test_against_cartesian_quadrature():
    """An unsymmetric pressure, far enough outside for the kernel to be smooth, in the plainest way there is."""

    def pressure(x, y):
        return (1 + 0.5 * x - 0.2 * y) * np.maximum(1 - x**2 / 4 - y**2, 0.0)

    x, y = 3.0, 1.5
    total, _ = dblquad(
        lambda t, s: pressure(s, t) / math.hypot(x - s, y - t),
        -2,
        2,
        lambda s: -math.sqrt(1 - s * s / 4),
        lambda s: math.sqrt(1 - s * s / 4),
    )
    found = theory.half_space_displacement(pressure, x, y, 2.0, 1.0, 3.0, 0.25)
    assert found == pytest.approx((1 - 0.0625) / (3 * math.pi) * total, rel=1e-7)  # dblquad's own


def test_flat_circular_punch_is_flat():
    """A pressure that is infinite at the edge: displacement equal under the punch, (2/pi) asin(a/r) of it outside."""
    punch = theory.circular_punch(1e-3, 2.0, 200.0, 0.3)
    r = np.array([0.0, 0.7, 1.5, 1.99, 2.2, 5.0])
    u = theory.half_space_displacement(lambda x, y: punch.pressure(np.hypot(x, y)), r, 0.0, 2.0, 2.0, 200.0, 0.3)
    assert u == pytest.approx(punch.displacement(r), rel=1e-8)  # 1 - r^2 loses digits at nodes next to the edge
    assert u[:4] == pytest.approx(1e-3, rel=1e-8)


def test_displacements_take_scalars_and_arrays():
    value = theory.half_space_displacement(POINT.pressure, 0.1, 0.0, POINT.a, POINT.a, 1.0, 0.0)
    array = theory.half_space_displacement(POINT.pressure, np.full((2, 2), 0.1), 0.0, POINT.a, POINT.a, 1.0, 0.0)
    assert np.ndim(value) == 0 and np.array_equal(array, np.full((2, 2), value))
    assert theory.half_space_displacement(POINT.pressure, 0.1, 0.0, POINT.a, POINT.a, np.inf, 0.3) == 0.0
    assert theory.half_plane_displacement(LINE.pressure, 0.0, LINE.half_width, 1.0, 0.3) == 0.0
