# SPDX-License-Identifier: MIT
"""Profiles and relative curvatures, seed (3.1)-(3.3), corrected."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dolfinx_impact import theory

radii = st.floats(0.01, 100.0)


def test_profiles_are_two_parabolas_of_opposite_sign():
    x = np.array([0.0, 0.1, -0.2])
    # Round-off only: the definition itself.
    assert theory.profile(x, 0.3, 2.0, 5.0) == pytest.approx(x**2 / 4 + 0.009, rel=1e-15)
    assert theory.profile(x, 0.3, 2.0, np.inf, body=2) == pytest.approx(-(x**2) / 4, rel=1e-15)
    circle = 2.0 - math.sqrt(2.0**2 - 0.01**2)
    assert theory.profile(0.01, 0.0, 2.0, 2.0) == pytest.approx(circle, rel=1e-5)  # next term of the circle: x^2/4R^2


def test_gap_is_the_difference_of_the_profiles():
    gap = theory.relative_curvature(0.46, np.inf, np.inf, 0.30)
    x, y = np.array([0.0, 1e-3, 2e-3]), np.array([1e-3, -2e-3, 0.0])
    difference = theory.profile(x, y, 0.46, np.inf, body=1) - theory.profile(x, y, np.inf, 0.30, body=2)
    assert gap.gap(x, y) == pytest.approx(difference, rel=1e-14)  # round-off
    assert (gap.Rx, gap.Ry, gap.rotation) == (pytest.approx(0.46), pytest.approx(0.30), 0.0)


def test_concave_bodies_and_planes():
    ball_in_groove = theory.relative_curvature(10.0, 10.0, -12.0, np.inf)
    assert ball_in_groove.Rx == pytest.approx(60.0) and ball_in_groove.Ry == pytest.approx(10.0)
    cylinder = theory.relative_curvature(10.0, np.inf, np.inf, np.inf)
    assert cylinder.B == 0.0 and cylinder.Ry == math.inf


@given(radii, radii, radii, radii, st.floats(-4.0, 4.0))
def test_axes_at_an_angle(r1x, r1y, r2x, r2y, angle):
    """The two formulas of (3.3), and the gap itself as the sum of two rotated quadrics."""
    found = theory.relative_curvature(r1x, r1y, r2x, r2y, angle)
    k = np.array([1 / r1x, 1 / r1y, 1 / r2x, 1 / r2y])
    d1, d2 = k[0] - k[1], k[2] - k[3]
    scale = 1e-13 * k.sum()  # round-off of sums of these sizes
    assert found.A + found.B == pytest.approx(k.sum() / 2, abs=scale)
    # The root of a sum of squares that may cancel: half the digits.
    difference = math.sqrt(max(d1**2 + d2**2 + 2 * d1 * d2 * math.cos(2 * angle), 0.0)) / 2
    assert abs(found.B - found.A) == pytest.approx(difference, abs=1e-7 * k.sum())
    assert abs(found.rotation) <= math.pi / 4 + 1e-12
    for x, y in ((1.0, 0.0), (0.3, -0.7)):  # along the axes of body 1
        c, s = math.cos(angle), math.sin(angle)
        there = (k[0] * x**2 + k[1] * y**2 + k[2] * (c * x + s * y) ** 2 + k[3] * (c * y - s * x) ** 2) / 2
        c, s = math.cos(found.rotation), math.sin(found.rotation)
        assert found.gap(c * x + s * y, c * y - s * x) == pytest.approx(there, abs=10 * scale)


def test_a_right_angle_swaps_the_axes():
    straight = theory.relative_curvature(1.0, 2.0, 5.0, 3.0)
    turned = theory.relative_curvature(1.0, 2.0, 3.0, 5.0, math.pi / 2)
    assert (turned.A, turned.B) == pytest.approx((straight.A, straight.B), rel=1e-14)  # cos(pi/2) is no exact zero
    assert turned.rotation == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize(
    "given_radii", [(10.0, 10.0, -9.0, 20.0), (10.0, np.inf, np.inf, -5.0), (np.inf,) * 4, (5.0, 5.0, -5.0, -5.0)]
)
def test_pairs_that_are_not_convex(given_radii):
    with pytest.raises(ValueError, match="convex"):
        theory.relative_curvature(*given_radii)


def test_a_pair_that_is_convex_or_not_by_its_angle():
    """A saddle in a groove: convex along common axes, not when turned by 90 degrees."""
    assert theory.relative_curvature(1.0, -10.0, 20.0, 5.0).B == pytest.approx(0.05)
    with pytest.raises(ValueError, match="convex"):
        theory.relative_curvature(1.0, -10.0, 20.0, 15.0)
    with pytest.raises(ValueError, match="convex"):
        theory.relative_curvature(1.0, -10.0, 5.0, 20.0)
