# SPDX-License-Identifier: MIT
"""Hertz's line and point contacts: numbers, stresses against point-load integrals, scaling."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from dolfinx_impact import theory

STEEL = dict(E1=207e3, nu1=0.3, E2=207e3, nu2=0.3)  # [N/mm^2]
LINE = theory.hertz_line(35e3, 50.0, np.inf, 210e3, 0.3, 70e3, 0.3)  # NAFEMS R0094 benchmark 1 [N, mm]
POINT = theory.hertz_point(1e3, 10.0, np.inf, **STEEL)


def test_line_numbers_of_nafems_r0094():
    # Half a unit of the last digit printed; one unit where that was rounded twice.
    assert LINE.bodies.modulus == pytest.approx(57692.3, abs=0.05)
    assert LINE.half_width == pytest.approx(6.21463, abs=5e-6)
    assert LINE.peak_pressure == pytest.approx(3585.36, abs=5e-3)
    wheel = theory.hertz_line(4e3, 460.0, np.inf, **STEEL)
    assert (wheel.half_width, wheel.peak_pressure) == (
        pytest.approx(4.538523, abs=1e-6),
        pytest.approx(561.081, abs=5e-4),
    )


def test_point_numbers():
    assert POINT.a == pytest.approx(0.404006, abs=5e-7) and POINT.b == POINT.a
    assert POINT.peak_pressure == pytest.approx(2925.27, abs=5e-3)
    assert POINT.approach == pytest.approx(16.3221e-3, abs=5e-8)
    # Two spheres pressed together by 4 mm (code_aster SSNV104).
    spheres = theory.hertz_point(1.0, 50.0, 50.0, 2e4, 0.3, 2e4, 0.3)
    load = spheres.load_at(4.0)
    assert load == pytest.approx(586080.6, abs=0.05)
    pressed = theory.hertz_point(load, 50.0, 50.0, 2e4, 0.3, 2e4, 0.3)
    assert pressed.a == pytest.approx(10.0, rel=1e-12)  # round-off
    assert pressed.peak_pressure == pytest.approx(2798.33, abs=5e-3)


def test_rigid_bodies_concave_bodies_and_the_order_of_bodies():
    rigid = theory.hertz_line(1.0, 10.0, np.inf, 207e3, 0.3, np.inf, 0.3)
    assert rigid.bodies.modulus == pytest.approx(207e3 / 0.91, rel=1e-15)
    swapped = theory.hertz_line(1.0, np.inf, 10.0, np.inf, 0.3, 207e3, 0.3)
    assert swapped.half_width == rigid.half_width and swapped.peak_pressure == rigid.peak_pressure
    bore = theory.hertz_point(1.0, 10.0, -20.0, **STEEL)
    assert bore.a == theory.hertz_point(1.0, 20.0, np.inf, **STEEL).a


@pytest.mark.parametrize("contact", [LINE, POINT], ids=["line", "point"])
def test_pressure_carries_the_load_and_vanishes_outside(contact):
    size = getattr(contact, "half_width", None) or contact.a
    if contact is LINE:
        total, load = quad(contact.pressure, -size, size)[0], contact.load_per_length
    else:
        total, load = quad(lambda r: 2 * np.pi * r * contact.pressure(r), 0, size)[0], contact.load
    assert total == pytest.approx(load, rel=1e-8)  # quad's own error at a root
    assert contact.pressure(0.0) == contact.peak_pressure
    assert np.array_equal(contact.pressure(np.array([-2.0, -1.0, 1.0, 1.0001]) * size), np.zeros(4))
    assert contact.pressure(np.zeros((2, 3))).shape == (2, 3) and np.ndim(contact.pressure(0.1)) == 0


def test_scaling_with_the_load():
    twice = theory.hertz_line(2 * 35e3, 50.0, np.inf, 210e3, 0.3, 70e3, 0.3)
    assert twice.half_width / LINE.half_width == pytest.approx(2**0.5, rel=1e-14)  # round-off
    eight = theory.hertz_point(8e3, 10.0, np.inf, **STEEL)
    ratios = eight.a / POINT.a, eight.peak_pressure / POINT.peak_pressure, eight.approach / POINT.approach
    assert ratios == pytest.approx((2.0, 2.0, 4.0), rel=1e-14)
    # The stiffness is the derivative of the load: central difference, error ~ h^2.
    h = 1e-4 * POINT.approach
    slope = (POINT.load_at(POINT.approach + h) - POINT.load_at(POINT.approach - h)) / (2 * h)
    assert POINT.stiffness == pytest.approx(slope, rel=1e-7)


def test_line_stress_is_the_sum_of_line_loads():
    """Flamant's stresses of a line load, summed over the pressure; Johnson (2.23)."""
    a, p = LINE.half_width, LINE.pressure
    for x, z in ((0.0, 0.5), (0.3, 0.2), (0.9, 0.4), (-1.3, 0.7), (2.0, 0.05), (-0.5, 3.0)):
        x, z = x * a, z * a

        def total(power):  # s = a sin: the roots at the edges go
            def value(angle):
                d, s = x - a * math.sin(angle), a * math.cos(angle)
                return p(a * math.sin(angle)) * d**power * z ** (3 - power) / (d**2 + z**2) ** 2 * s

            return -2 / np.pi * quad(value, -np.pi / 2, np.pi / 2, epsabs=1e-11 * LINE.peak_pressure, limit=200)[0]

        found = LINE.stress(z, x)
        tolerance = dict(abs=1e-9 * LINE.peak_pressure)  # the quadrature's
        assert found.sigma_z == pytest.approx(total(0), **tolerance)
        assert found.tau_xz == pytest.approx(total(1), **tolerance)
        assert found.sigma_x == pytest.approx(total(2), **tolerance)
        assert found.sigma_y == pytest.approx(0.3 * (total(0) + total(2)), **tolerance)


def test_line_stress_at_the_surface():
    x = np.array([-2.0, -1.0, -0.6, 0.0, 0.8, 1.0, 1.5]) * LINE.half_width
    found = LINE.stress(0.0, x)
    round_off = 1e-12 * LINE.peak_pressure
    assert found.sigma_z == pytest.approx(-LINE.pressure(x), abs=round_off)
    assert found.sigma_x == pytest.approx(-LINE.pressure(x), abs=round_off)
    assert found.tau_xz == pytest.approx(0.0, abs=round_off)


def test_point_stress_is_the_sum_of_point_loads():
    """Boussinesq's stresses on the axis of a ring of load; Johnson (3.19)."""
    a, nu = POINT.a, 0.3
    for z in np.array([0.05, 0.481, 1.0, 3.0]) * a:

        def ring(kernel):
            def value(angle):
                r, jacobian = a * math.sin(angle), a * math.cos(angle)
                return POINT.pressure(r) * kernel(r, math.hypot(r, z)) * r * jacobian

            return quad(value, 0, np.pi / 2, epsabs=0, epsrel=1e-11, limit=200)[0]

        sigma_z = ring(lambda r, rho: -3 * z**3 / rho**5)
        sigma_x = ring(lambda r, rho: ((1 - 2 * nu) * z / rho**3 - 3 * z * r**2 / rho**5) / 2)
        found = POINT.stress(z)
        assert (found.sigma_x, found.sigma_z) == pytest.approx((sigma_x, sigma_z), rel=1e-8)  # the quadrature's
        assert found.sigma_y == found.sigma_x and found.tau_xz == 0.0


def test_where_bodies_yield_first():
    (shear, depth), (mises, at) = LINE.largest_shear(), LINE.largest_mises()
    p0, a = LINE.peak_pressure, LINE.half_width
    # As many digits as are printed; the place of a maximum is known to half the digits of its value.
    assert (shear / p0, depth / a) == (pytest.approx(0.30028, abs=5e-6), pytest.approx(0.7862, abs=5e-5))
    assert (mises / p0, at / a) == (pytest.approx(0.55752, abs=5e-6), pytest.approx(0.7043, abs=5e-5))
    mises, at = POINT.largest_mises()
    assert (POINT.peak_pressure / mises, at / POINT.a) == (
        pytest.approx(1.613, abs=5e-4),
        pytest.approx(0.481, abs=5e-4),
    )
    assert POINT.largest_shear()[0] == pytest.approx(mises / 2, rel=1e-12)  # two equal principal stresses
    # Body 1 is meant unless told otherwise.
    two = theory.hertz_line(1.0, 1.0, np.inf, 1.0, 0.4, 1.0, 0.1)
    assert two.largest_shear() == two.largest_shear(1) != two.largest_shear(2)
    assert two.largest_mises() == two.largest_mises(1) != two.largest_mises(2)
    two = theory.hertz_point(1.0, 1.0, np.inf, 1.0, 0.4, 1.0, 0.1)
    assert two.largest_shear() == two.largest_shear(1) != two.largest_shear(2)
    assert two.largest_mises() == two.largest_mises(1) != two.largest_mises(2)
    assert two.stress(0.1) == two.stress(0.1, 1) != two.stress(0.1, 2)
    # The search goes as deep as the contact asks for, whatever the unit of length.
    for unit in (1e-6, 1e6):
        line = theory.hertz_line(1.0, unit, np.inf, 1.0 / unit, 0.3, np.inf, 0.3)
        assert line.largest_shear()[1] == pytest.approx(0.7862 * line.half_width, rel=1e-4)
        point = theory.hertz_point(1.0, unit, np.inf, 1.0 / unit**2, 0.3, np.inf, 0.3)
        assert point.largest_shear()[1] == pytest.approx(0.481 * point.a, rel=1e-3)
    # Without lateral contraction a line contact is sheared most at its surface, across the plane.
    flat = theory.hertz_line(1.0, 1.0, np.inf, 1.0, 0.0, 1.0, 0.0)
    assert flat.largest_shear() == (pytest.approx(flat.peak_pressure / 2, rel=1e-14), 0.0)


def test_deep_stresses_do_not_cancel():
    """Far below, the contact is a line load: sigma_z = -2 P/(pi z), sigma_x = -p0 (a/z)^3/4."""
    z = 1e4 * LINE.half_width
    found = LINE.stress(z)
    assert found.sigma_z == pytest.approx(-2 * LINE.load_per_length / (np.pi * z), rel=1e-7)  # next term (a/z)^2
    # sigma_x is 1e-8 of the sum it is found from.
    assert found.sigma_x == pytest.approx(-LINE.peak_pressure * 1e-12 / 4, abs=1e-3 * LINE.peak_pressure * 1e-12)


def test_stress_refuses():
    rigid = theory.hertz_line(1.0, 10.0, np.inf, 207e3, 0.3, np.inf, 0.3)
    with pytest.raises(ValueError, match="rigid"):
        rigid.stress(1.0, body=2)
    with pytest.raises(ValueError, match="bodies are 1 and 2"):
        rigid.stress(1.0, body=3)
    for contact in (rigid, POINT):
        with pytest.raises(ValueError, match="negative"):
            contact.stress(-1.0)
