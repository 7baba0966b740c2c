# SPDX-License-Identifier: MIT
"""Wedge and cone, seed (3.14), corrected."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from dolfinx_impact import theory

RIGID_ON_STEEL = (np.inf, 0.0, 207e9, 0.3)
WEDGE = theory.wedge(math.radians(80), *RIGID_ON_STEEL, half_width=5e-3)
CONE = theory.cone(math.radians(80), *RIGID_ON_STEEL, a=5e-3)


def test_numbers():
    # Half a unit of the last digit printed; one unit where that was rounded twice.
    assert WEDGE.bodies.modulus / 1e9 == pytest.approx(227.473, abs=5e-4)
    assert WEDGE.load_per_length / 1e6 == pytest.approx(200.548, abs=5e-4)
    assert WEDGE.pressure(2.5e-3) / 1e9 == pytest.approx(16.8140, abs=1e-4)
    assert CONE.load / 1e3 == pytest.approx(1575.098, abs=5e-4)
    assert CONE.approach * 1e3 == pytest.approx(1.384869, abs=5e-7)
    assert CONE.pressure(2.5e-3) / 1e9 == pytest.approx(26.4113, abs=5e-5)


def test_load_width_and_approach_say_the_same():
    again = theory.wedge(math.radians(80), *RIGID_ON_STEEL, load_per_length=WEDGE.load_per_length)
    assert again.half_width == pytest.approx(5e-3, rel=1e-14)  # round-off
    for given in ({"load": CONE.load}, {"approach": CONE.approach}):
        again = theory.cone(math.radians(80), *RIGID_ON_STEEL, **given)
        assert (again.load, again.a, again.approach) == pytest.approx((CONE.load, 5e-3, CONE.approach), rel=1e-14)
    for given in ({}, {"load": 1.0, "a": 1.0}):
        with pytest.raises(ValueError, match="exactly one"):
            theory.cone(1.5, *RIGID_ON_STEEL, **given)
    with pytest.raises(ValueError, match="exactly one"):
        theory.wedge(1.5, *RIGID_ON_STEEL)


def test_pressure_carries_the_load():
    a = 5e-3  # quad's own error at a logarithm
    assert 2 * quad(WEDGE.pressure, 0, a)[0] == pytest.approx(WEDGE.load_per_length, rel=1e-8)
    assert quad(lambda r: 2 * np.pi * r * CONE.pressure(r), 0, a)[0] == pytest.approx(CONE.load, rel=1e-8)
    for contact in (WEDGE, CONE):
        assert contact.pressure(0.0) == math.inf
        assert np.array_equal(contact.pressure(np.array([-a, a, 1.1 * a])), np.zeros(3))
        assert contact.pressure(-0.3 * a) == contact.pressure(0.3 * a)


def test_both_forms_of_the_wedge():
    """(3.14) with a - s in the denominator is acosh(a/x); as printed, with 2, it is not even without dimension."""
    x, a = 1.5e-3, 5e-3
    s = math.sqrt(a**2 - x**2)
    logarithm = WEDGE.bodies.modulus / math.tan(math.radians(80)) / (2 * math.pi) * math.log((a + s) / (a - s))
    assert WEDGE.pressure(x) == pytest.approx(logarithm, rel=1e-13)  # a - s loses a digit


def test_the_surface_takes_the_shape_of_the_wedge():
    a = WEDGE.half_width
    x = np.array([-0.9, -0.4, 0.2, 0.7, 1.2]) * a
    u = theory.half_plane_displacement(WEDGE.pressure, x, a, 207e9, 0.3)
    profile = -np.abs(x) / math.tan(math.radians(80))
    # quad at the apex, where two logarithms meet.
    assert u[:-1] == pytest.approx(profile[:-1], abs=1e-8 * a)
    assert u[-1] > profile[-1] + 1e-3 * a


def test_the_surface_takes_the_shape_of_the_cone():
    """Rings of pressure, each with the displacement of a ring in terms of the elliptic integral; Johnson 3.8."""
    from scipy.special import ellipk

    a, cot = CONE.a, 1 / math.tan(math.radians(80))

    def displacement(r):
        def ring(t):
            return CONE.pressure(t) * 4 * t / (t + r) * ellipk(4 * t * r / (t + r) ** 2)

        pieces = ((0.0, r), (r, a)) if 0 < r < a else ((0.0, a),)
        return sum(quad(ring, *piece, epsabs=0, epsrel=1e-10)[0] for piece in pieces) * 0.91 / (math.pi * 207e9)

    for r in np.array([0.0, 0.3, 0.8]) * a:
        assert displacement(r) == pytest.approx(CONE.approach - r * cot, rel=1e-7)  # quad at two logarithms
    assert displacement(1.2 * a) > CONE.approach - 1.2 * a * cot


def test_stiffness_and_scaling():
    h = 1e-6 * CONE.approach
    loads = [theory.cone(math.radians(80), *RIGID_ON_STEEL, approach=CONE.approach + s).load for s in (-h, h)]
    assert CONE.stiffness == pytest.approx((loads[1] - loads[0]) / (2 * h), rel=1e-8)  # a parabola: round-off only
    # Loads and pressures go with E* cot(alpha).
    blunt = theory.wedge(math.radians(89), *RIGID_ON_STEEL, half_width=5e-3)
    ratio = math.tan(math.radians(80)) / math.tan(math.radians(89))
    assert blunt.load_per_length / WEDGE.load_per_length == pytest.approx(ratio, rel=1e-14)
    assert blunt.pressure(1e-3) / WEDGE.pressure(1e-3) == pytest.approx(ratio, rel=1e-14)


@pytest.mark.parametrize("angle", [80.0, math.pi / 2, 0.0, -1.0])
def test_angles(angle):
    with pytest.raises(ValueError, match="half_angle"):
        theory.wedge(angle, *RIGID_ON_STEEL, half_width=1.0)
    with pytest.raises(ValueError, match="half_angle"):
        theory.cone(angle, *RIGID_ON_STEEL, a=1.0)
