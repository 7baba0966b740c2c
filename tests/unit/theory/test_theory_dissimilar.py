# SPDX-License-Identifier: MIT
"""Dundurs' constants, contact without slip and free rolling, seed (3.15), (3.16), corrected."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from singular_integrals import cauchy

from dolfinx_impact import theory

# Aluminium on steel as in CONTACT's guide: shear moduli 23 and 82 GPa [N/mm^2].
AL_STEEL = (2 * 23e3 * 1.31, 0.31, 2 * 82e3 * 1.28, 0.28)
BONDED = theory.bonded_indentation(16.20, 50.0, 50.0, *AL_STEEL)
ratios, moduli = st.floats(0.0, 0.5), st.floats(0.1, 10.0)


def test_aluminium_on_steel():
    found = theory.dundurs(*AL_STEEL)
    assert found.beta == pytest.approx(0.14383, abs=5e-6)  # digits printed
    assert 2 * found.beta == pytest.approx(0.2877, abs=5e-5)  # published
    swapped = theory.dundurs(*AL_STEEL[2:], *AL_STEEL[:2])
    assert (swapped.alpha, swapped.beta) == (-found.alpha, -found.beta)


@given(moduli, ratios, moduli, ratios)
def test_other_forms_of_the_constants(E1, nu1, E2, nu2):
    """In plane-strain moduli, and in G and Kolosov's constant kappa = 3 - 4 nu: Dundurs' own."""
    found = theory.dundurs(E1, nu1, E2, nu2)
    M1, M2 = E1 / (1 - nu1**2), E2 / (1 - nu2**2)
    assert found.alpha == pytest.approx((M2 - M1) / (M1 + M2), abs=1e-14)  # round-off of numbers of order 1
    ratio, k1, k2 = (E2 / (1 + nu2)) / (E1 / (1 + nu1)), 3 - 4 * nu1, 3 - 4 * nu2
    beta = (ratio * (k1 - 1) - (k2 - 1)) / (ratio * (k1 + 1) + (k2 + 1))
    assert found.beta == pytest.approx(beta, abs=1e-14)
    # The parallelogram of pairs with nu between 0 and 1/2.
    assert abs(found.alpha) <= 1 and abs(found.alpha - 4 * found.beta) <= 1 + 1e-14


def test_limits():
    assert theory.dundurs(1.0, 0.3, 1.0, 0.3).beta == 0.0
    assert theory.dundurs(1.0, 0.0, np.inf, 0.3).beta == 0.5
    assert theory.dundurs(1.0, 0.5, np.inf, 0.0).beta == 0.0
    # The coupling of a bonded rigid punch: tanh(pi eta) = beta of the half-plane against a rigid body.
    eta = theory.flat_punch(1.0, 1.0, 0.3, "bonded").eta
    assert math.tanh(math.pi * eta) == pytest.approx(theory.dundurs(1.0, 0.3, np.inf, 0.0).beta, rel=1e-14)


def test_numbers_without_slip():
    p0, a, beta = BONDED.peak_pressure, BONDED.half_width, BONDED.beta
    assert a == pytest.approx(0.1, abs=1e-5) and p0 == pytest.approx(103.14, abs=5e-3)  # load printed to 4 digits
    assert BONDED.peak_shear / (beta * p0) == pytest.approx(0.793515, abs=5e-7)
    assert BONDED.shear(0.7071067811865476 * a) == pytest.approx(BONDED.peak_shear, rel=1e-14)
    x = np.linspace(-a, a, 4001)
    assert np.max(BONDED.shear(x)) <= BONDED.peak_shear
    assert BONDED.pressure(0.3 * a) == BONDED.contact.pressure(0.3 * a)


def test_shear_is_odd_outward_and_vanishes_outside():
    x = np.array([0.2, 0.7, 0.99]) * BONDED.half_width
    assert np.all(BONDED.shear(x) > 0)
    assert np.array_equal(BONDED.shear(-x), -BONDED.shear(x))
    assert np.array_equal(BONDED.shear(np.array([0.0, 1.0, -1.0, 2.0]) * BONDED.half_width), np.zeros(4))
    other_way = theory.bonded_indentation(16.20, 50.0, 50.0, *AL_STEEL[2:], *AL_STEEL[:2])
    assert other_way.shear(x) == pytest.approx(-BONDED.shear(x), rel=1e-13)


@pytest.mark.parametrize("x", [0.1, 0.5, 0.9])
def test_sum_of_bonded_increments(x):
    """While the contact grows by dc its load grows by pi E*/(2 R) c dc, as under a bonded flat punch of width 2 c."""
    a, scale = BONDED.half_width, BONDED.contact.bodies.modulus * BONDED.beta / (2 * math.pi * BONDED.contact.radius)
    x *= a
    height = math.sqrt(a * a - x * x)

    def increment(angle):
        # q = P eta ln((c + x)/(c - x))/(pi sqrt(c^2 - x^2)), eta = beta/pi for small beta. With c^2 = x^2 + u^2,
        # u = height sin(angle), the root goes: c dc = u du.
        c = math.hypot(x, height * math.sin(angle))
        return scale * 2 * math.atanh(x / c) * height * math.cos(angle) if c > x else 0.0

    total = quad(increment, 0, math.pi / 2, epsabs=0, epsrel=1e-10, limit=200)[0]
    assert BONDED.shear(x) == pytest.approx(total, rel=1e-8)  # quad at a logarithm


def test_points_stick_where_they_first_touched():
    """Without slip the strains that differ are frozen at first touch, which happened at similar stages of a similar
    contact: (1/pi) PV int q/(x - s) ds + beta p = C |x|, one constant over the whole contact."""
    a = BONDED.half_width
    x = np.array([0.1, 0.3, 0.5, 0.7, 0.85]) * a
    left = [cauchy(BONDED.shear, s, a, breaks=(0.0,)) / math.pi + BONDED.beta * BONDED.pressure(s) for s in x]
    constants = np.array(left) / x
    assert constants == pytest.approx(constants[0], rel=1e-6)  # quad, near a logarithm


def test_free_rolling():
    """Published 5.259e-4 with rounded input; the exact factor is 0.4573855."""
    creep = theory.bentall_johnson(16.20, 50.0, 50.0, *AL_STEEL)
    assert creep == pytest.approx(5.263e-4, abs=5e-8)
    a, R = BONDED.half_width, 25.0
    assert creep / (2 * BONDED.beta * a / R) == pytest.approx(0.4573855, abs=5e-8)
    # Half of the load lies within x0.
    x0 = a * math.sqrt(1 - (2 * 0.4573855) ** 2)
    assert quad(BONDED.pressure, -x0, x0)[0] == pytest.approx(16.20 / 2, rel=1e-6)  # seven digits of the factor
    assert theory.bentall_johnson(16.20, 50.0, 50.0, *AL_STEEL[2:], *AL_STEEL[:2]) == pytest.approx(-creep, rel=1e-13)
