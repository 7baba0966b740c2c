# SPDX-License-Identifier: MIT
"""Flat punches, seed (3.13), corrected: loads, the integral equations of the half-plane, the edge."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from singular_integrals import cauchy_of_punch, integral_of_punch

from dolfinx_impact import theory

A = 2.0


def punches():
    yield theory.flat_punch(3.0, A)
    for nu in (0.0, 0.3, 0.5, -0.4):
        yield theory.flat_punch(3.0, A, nu, "bonded")
        yield theory.flat_punch(3.0, A, nu, "bonded", tangential_load_per_length=-1.3)
        yield theory.flat_punch(3.0, A, nu, "sliding", friction=0.6)


@pytest.mark.parametrize(
    "punch", punches(), ids=lambda p: f"{p.condition}, nu={p.nu}, Q={p.tangential_load_per_length}"
)
def test_loads_and_integral_equations(punch):
    """int p = P, int q = Q; and a flat base: both surface slopes vanish where the punch holds them, Johnson (2.25):

    du_x/dx = -(1 + nu)/E [(1 - 2 nu) p + 2 (1 - nu)/pi PV int q/(x - s) ds],
    du_z/dx = -(1 + nu)/E [2 (1 - nu)/pi PV int p/(x - s) ds - (1 - 2 nu) q].
    """
    # The cut of the integrals: the integrand falls like exp(-(1 - 2 gamma) |t|), and |t| reaches 16 for every x here.
    cut = 30 * math.exp(-16 * (1 - 2 * punch.gamma))
    for traction, load in ((punch.pressure, punch.load_per_length), (punch.shear, punch.tangential_load_per_length)):
        assert integral_of_punch(traction, A) == pytest.approx(load, abs=cut)
    nu = punch.nu or 0.0  # without friction it does not matter
    for x in (-1.5, -0.2, 0.0, 0.74, 1.7):
        p, q = punch.pressure(x), punch.shear(x)
        conjugate_p, conjugate_q = (cauchy_of_punch(t, x, A) for t in (punch.pressure, punch.shear))
        assert 2 * (1 - nu) / math.pi * conjugate_p - (1 - 2 * nu) * q == pytest.approx(0.0, abs=cut)
        if punch.condition == "bonded":
            assert (1 - 2 * nu) * p + 2 * (1 - nu) / math.pi * conjugate_q == pytest.approx(0.0, abs=cut)


@pytest.mark.parametrize(
    "nu, eta, middle, first", [(0.3, 0.0935492, 1.0434984, 1.02e-7), (0.0, 0.1748496, 1.1547005, 2.51e-4)]
)
def test_numbers_of_the_bonded_punch(nu, eta, middle, first):
    punch = theory.flat_punch(1.0, A, nu, "bonded")
    # As many digits as are printed.
    assert punch.eta == pytest.approx(eta, abs=5e-8)
    assert punch.pressure(0.0) * math.pi * A == pytest.approx(middle, abs=5e-8)
    assert punch.first_sign_change == pytest.approx(first, rel=5e-3)
    s = punch.first_sign_change * A
    assert punch.near_edge_pressure(1.01 * s) > 0 > punch.near_edge_pressure(0.99 * s)
    assert punch.pressure(A - 1.01 * s) > 0 > punch.pressure(A - 0.99 * s)


def test_the_printed_factor_is_refuted():
    """With 3 - 4 nu for its root the pressure carries 0.745 of the load at nu = 0.3."""
    assert 1 / math.sqrt(3 - 4 * 0.3) == pytest.approx(0.745, abs=5e-4)
    punch = theory.flat_punch(1.0, 1.0, 0.3, "bonded")
    s = 0.01
    printed = 2 * 0.7 / (math.pi * 1.8) * (2 * s) ** -0.5 * math.cos(punch.eta * math.log(2 / s))
    assert printed / punch.near_edge_pressure(s) == pytest.approx(0.7454, abs=5e-5)


@pytest.mark.parametrize(
    "punch", punches(), ids=lambda p: f"{p.condition}, nu={p.nu}, Q={p.tangential_load_per_length}"
)
def test_near_the_edge(punch):
    """The leading term of (3.13): its relative error falls in proportion to s."""
    for s in (1e-3, 1e-5):
        near = punch.near_edge_pressure(s * A)
        # a - s loses 1e-16/s of s; the next term is of order s.
        assert near == pytest.approx(punch.pressure(A - s * A), rel=2 * s + 1e-15 / s)
    with pytest.raises(ValueError, match="positive"):
        punch.near_edge_pressure(0.0)


def test_frictionless_and_sliding_numbers():
    free = theory.flat_punch(1.0, A)
    x = np.array([-1.5, 0.0, 1.0])
    assert free.pressure(x) == pytest.approx(1 / (math.pi * np.sqrt(A**2 - x**2)), rel=1e-14)  # round-off
    assert np.array_equal(free.shear(x), np.zeros(3)) and free.first_sign_change is None
    sliding = theory.flat_punch(1.0, A, 0.3, "sliding", friction=0.3)
    assert sliding.gamma == pytest.approx(0.0272172, abs=5e-8)
    assert sliding.shear(x) == pytest.approx(0.3 * sliding.pressure(x), rel=1e-15)
    assert sliding.pressure(-1.0) > sliding.pressure(1.0)  # the rear is pressed harder
    # Incompressible: no coupling, every condition gives the frictionless pressure.
    for condition, friction in (("bonded", 0.0), ("sliding", 0.8)):
        assert theory.flat_punch(1.0, A, 0.5, condition, friction).pressure(x) == pytest.approx(
            free.pressure(x), rel=1e-14
        )


def test_outside_and_at_the_edges():
    for punch in punches():
        assert np.array_equal(punch.pressure(np.array([-3.0, 2.1])), [0.0, 0.0])
        assert np.array_equal(punch.shear(np.array([-3.0, 2.1])), [0.0, 0.0])
        assert punch.pressure(A) == punch.pressure(-A) == math.inf


def test_circular_punch():
    punch = theory.circular_punch(10e-6, 10e-3, 207e9, 0.3)
    assert punch.load == pytest.approx(45494.5, abs=0.05)  # digits printed
    assert punch.stiffness * punch.approach == pytest.approx(punch.load, rel=1e-15)
    total = quad(
        lambda t: 2 * np.pi * 10e-3 * math.sin(t) * punch.pressure(10e-3 * math.sin(t)) * 10e-3 * math.cos(t),
        0,
        np.pi / 2,
    )
    assert total[0] == pytest.approx(punch.load, rel=1e-8)  # digits of cos next to the edge
    assert punch.pressure(10e-3) == math.inf and punch.pressure(11e-3) == 0.0
    assert punch.displacement(5e-3) == punch.approach and punch.displacement(20e-3) == pytest.approx(
        10e-6 / 3, rel=1e-14
    )


@pytest.mark.parametrize("nu, ratio", [(0.0, 1.098612), (0.25, 1.039721), (0.3, 1.028627), (0.5, 1.0)])
def test_bonded_circular_punch(nu, ratio):
    free, bonded = (theory.circular_punch(1.0, 1.0, 1.0, nu, c) for c in ("frictionless", "bonded"))
    assert bonded.load / free.load == pytest.approx(ratio, abs=5e-7)  # digits printed
    for what in (bonded.pressure, bonded.displacement):
        with pytest.raises(ValueError, match="bonded"):
            what(0.0)


def test_the_incompressible_limit_is_met_smoothly():
    near, at = (theory.circular_punch(1.0, 1.0, 1.0, nu, "bonded").load for nu in (0.5 - 1e-9, 0.5))
    assert near == pytest.approx(at, rel=1e-8)  # the slope there is of order 1
