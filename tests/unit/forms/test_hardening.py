# SPDX-License-Identifier: MIT
"""Hardening of J2 plasticity in UFL: slopes are derivatives, and the first increment is the root of its equation."""

import numpy as np
import pytest
import ufl
from scipy.optimize import brentq

from dolfinx_impact.forms.hardening import (
    KinematicHardening,
    LinearHardening,
    TableHardening,
    VoceHardening,
    first_increment,
    first_increment_error,
)

STRAINS, STRESSES = (0.0, 0.1, 0.3, 0.6), (2.0, 2.6, 2.9, 3.5)
LINEAR = LinearHardening(2.0, 3.0)
VOCE = VoceHardening(2.0, 5.0, 4.0, 0.5)
TABLE = TableHardening(ufl.as_vector(STRAINS), ufl.as_vector(STRESSES))


def value(expression):
    """Number of an expression without coefficients."""
    return float(ufl.as_ufl(expression)((0.0,)))


@pytest.mark.parametrize("alpha", [0.0, 0.07, 0.2, 0.55, 0.8])
@pytest.mark.parametrize(
    "hardening, law",
    [
        (LINEAR, lambda a: 2.0 + 3.0 * a),
        (VOCE, lambda a: 5.0 - 3.0 * np.exp(-4.0 * a) + 0.5 * a),
        (TABLE, lambda a: np.interp(a, STRAINS, STRESSES)),
    ],
    ids=["linear", "Voce", "table"],
)
def test_yield_stress_and_its_slope(hardening, law, alpha):
    assert value(hardening.stress(alpha)) == pytest.approx(law(alpha), rel=1e-14)
    h = 1e-6  # forwards: at the first point of a table the slope is that of the segment to the right
    difference = (law(alpha + h) - law(alpha)) / h
    assert value(hardening.slope(alpha)) == pytest.approx(difference, rel=1e-5, abs=1e-8)


def test_each_derivative_of_voces_slope_is_minus_the_rate_times_the_one_before():
    h = 1e-4
    slopes = [value(VOCE.slope(0.2 + k * h)) for k in (-1, 0, 1)]
    fading = value(VOCE.fading_slope(0.2))
    assert slopes[1] == pytest.approx(VOCE.modulus + fading, rel=1e-15)
    assert -VOCE.rate * fading == pytest.approx((slopes[2] - slopes[0]) / (2 * h), rel=1e-6)
    assert VOCE.rate**2 * fading == pytest.approx((slopes[2] - 2 * slopes[1] + slopes[0]) / h**2, rel=1e-5)


def test_which_laws_have_a_closed_form():
    assert LINEAR.linear and not LinearHardening(2.0, -1.0, falls_to_zero=True).linear
    assert not VOCE.linear and not TABLE.linear and value(TABLE.yield_stress) == 2.0
    assert KinematicHardening(10.0).linear and not KinematicHardening(10.0, 5.0).linear


def test_back_stress_is_shortened_by_backward_euler():
    """(1 + gamma d alpha) beta = what there was: the pole on the side of negative increments is left out."""
    law = KinematicHardening(10.0, 5.0)
    assert value(law.fading(0.1)) * 1.5 == pytest.approx(1.0, rel=1e-15)
    assert value(law.fading(-0.2)) == 1.0
    assert value(KinematicHardening(10.0).fading(0.1)) == 1.0


@pytest.mark.parametrize("excess, digits", [(1e-3, 1e-11), (1e-2, 1e-8)])
def test_first_increment_is_a_root_to_the_third_order(excess, digits):
    alpha, stiffness = 0.1, 6.0

    def left(x):
        return stiffness * x + value(VOCE.stress(alpha + x)) - value(VOCE.stress(alpha)) - excess

    root = brentq(left, 0.0, 1.0, xtol=1e-15)
    assert value(first_increment(excess, stiffness, VOCE, alpha)) == pytest.approx(root, rel=digits)
    slope = stiffness + value(VOCE.slope(alpha))
    assert abs(excess / slope - root) > 10 * digits * root  # the first term alone is not as near


def test_first_increment_where_the_series_is_no_use():
    slope = 6.0 + value(VOCE.slope(0.1))
    assert value(first_increment(1e3, 6.0, VOCE, 0.1)) == pytest.approx(1e3 / slope, rel=1e-15)


@pytest.mark.parametrize("excess", [1e-3, 1e-2, 0.1])
def test_the_error_of_the_first_increment_is_bounded(excess):
    """By the sizes of the fourth term's parts, which nearly cancel here: the bound is of the fourth power."""
    stiffness, alpha = 6.0, 0.1
    first = value(VOCE.stress(alpha))
    root = brentq(lambda x: stiffness * x + value(VOCE.stress(alpha + x)) - first - excess, 0.0, 1.0, xtol=1e-16)
    error = abs(value(first_increment(excess, stiffness, VOCE, alpha)) - root)
    bound, smaller = (value(first_increment_error(e, stiffness, VOCE, alpha)) for e in (excess, 0.1 * excess))
    assert error <= bound + 4e-16 * root  # what the search for the root leaves
    assert bound == pytest.approx(1e4 * smaller, rel=1e-12) and bound < 1e3 * excess**4
    assert value(first_increment_error(1e3, stiffness, VOCE, alpha)) == 1.0  # the series is no use
