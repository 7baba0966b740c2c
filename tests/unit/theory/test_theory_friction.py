# SPDX-License-Identifier: MIT
"""Partial slip, Carter's rolling and the pulled bar."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from singular_integrals import cauchy, tangential_displacement

from dolfinx_impact import theory

E = 2 * 200.0 * 1.42  # G = 200, nu = 0.42 [N/mm^2]
P = 9.19540
POINT = theory.cattaneo_mindlin(P, 7 / 8 * 0.4 * P, 0.4, 50.0, np.inf, E, 0.42, E, 0.42)  # CONTACT's example cattaneo
E_RAIL = 2 * 82e3 * 1.28
ROLLERS = (500.0, np.inf, E_RAIL, 0.28, E_RAIL, 0.28)  # CONTACT's example carter2d [mm, N]


def test_point_numbers():
    # The load is printed to 6 digits; results as far as printed.
    assert POINT.stick_radius / POINT.contact.a == pytest.approx(0.5, rel=1e-14)
    assert POINT.contact.peak_pressure == pytest.approx(4.39048, abs=5e-6)
    assert POINT.contact.approach == pytest.approx(0.0200, abs=5e-5)
    assert POINT.shift == pytest.approx(0.00817241, abs=1e-8)
    assert POINT.first_dissipation == pytest.approx(2.7554e-3, abs=5e-8)
    assert POINT.cycle_dissipation == pytest.approx(1.10218e-2, abs=5e-8)
    # The start of rolling in CONTACT's catt_to_cart: shift 0.01774 there, 0.0177458 in closed form.
    start = theory.cattaneo_mindlin(
        0.4705, 0.657 * 0.4013 * 0.4705, 0.4013, 0.5 / 0.002963, np.inf, 2.56, 0.28, 2.56, 0.28
    )
    assert start.contact.a == pytest.approx(3.49997, abs=5e-6)
    assert start.contact.peak_pressure == pytest.approx(0.0183389, abs=5e-8)
    assert start.shift == pytest.approx(0.0177458, abs=5e-8)


def test_point_traction():
    c, a = POINT.stick_radius, POINT.contact.a
    pieces = [quad(lambda r: 2 * math.pi * r * POINT.traction(r), *ends)[0] for ends in ((0, c), (c, a))]
    assert sum(pieces) == pytest.approx(POINT.tangential_load, rel=1e-8)  # quad at roots
    r = np.array([0.2, 0.9]) * a
    limit = 0.4 * POINT.contact.pressure(r)
    assert POINT.traction(r)[0] < limit[0] and POINT.traction(r)[1] == limit[1]
    assert POINT.traction(1.5 * a) == 0.0 == POINT.traction(-a)


@pytest.mark.parametrize("nu", [0.42, 0.0])
def test_the_stick_zone_moves_as_one(nu):
    """Displacement by quadrature of the half-space's integral: the shift in the stick zone, less than it beyond."""
    G = 200.0
    contact = theory.cattaneo_mindlin(P, 0.3 * P, 0.4, 50.0, np.inf, 2 * G * (1 + nu), nu, 2 * G * (1 + nu), nu)
    c, a = contact.stick_radius, contact.contact.a
    both = 2 / (2 * math.pi * G)

    def mean(r):  # it varies like cos(2 angle): the mean of three angles is the mean of the circle
        angles = np.array([0, 1, 2]) * math.pi / 3
        values = [
            tangential_displacement(contact.traction, (c,), a, nu, r * math.cos(t), r * math.sin(t)) for t in angles
        ]
        return both * np.array(values)

    # Rays that graze the circle r = c see a root there: the sum over 400 rays is good to 1e-5.
    for r in (0.0, 0.3 * c, 0.9 * c):
        assert mean(r) == pytest.approx(contact.shift, rel=2e-5)
    for r in ((c + a) / 2, 0.95 * a):
        assert contact.shift - np.mean(mean(r)) == pytest.approx(contact.slip(r), abs=2e-5 * contact.shift)
        assert contact.slip(r) > 0


def test_slip():
    c, a = POINT.stick_radius, POINT.contact.a
    assert np.array_equal(POINT.slip(np.array([0.0, c])), [0.0, 0.0])
    r = np.linspace(c, a, 50)
    assert np.all(np.diff(POINT.slip(r)) > 0) and np.isnan(POINT.slip(1.1 * a))
    # Incipient sliding: Hertz's shape, full shift times r^2/(2 a^2).
    sliding = theory.cattaneo_mindlin(P, 0.4 * P, 0.4, 50.0, np.inf, E, 0.42, E, 0.42)
    assert sliding.stick_radius == pytest.approx(0.0, abs=1e-5)  # cube root of round-off
    assert sliding.shift == pytest.approx(sliding.full_shift, rel=1e-10)
    assert sliding.slip(0.5 * a) == pytest.approx(sliding.full_shift / 8, rel=1e-4)


@pytest.mark.parametrize("ratio", [0.02, 0.3, 0.875, 1.0])
def test_work_of_slip(ratio):
    """Once a point slips its traction stays friction p: the work is the integral of friction p times the final slip.
    And in a cycle it is the area of the loop of load and shift, whose branches are the first loading doubled."""
    contact = theory.cattaneo_mindlin(P, ratio * 0.4 * P, 0.4, 50.0, np.inf, E, 0.42, E, 0.42)
    c, a = contact.stick_radius, contact.contact.a

    def work(r):
        return 2 * math.pi * r * 0.4 * contact.contact.pressure(r) * contact.slip(r)

    total = quad(work, c, a, epsabs=0, epsrel=1e-10, limit=200)[0]
    # The slip is a small difference: at ratio 0.02 it is 1e-4 of its terms.
    assert contact.first_dissipation == pytest.approx(total, rel=1e-7)
    # Branch: Q(shift) = friction P [1 - (1 - shift/full)^1.5].
    y = contact.shift / contact.full_shift
    area = y - 0.4 * (1 - (1 - y) ** 2.5)  # int Q d shift over friction P full_shift
    loop = 8 * 0.4 * P * contact.full_shift * (area - ratio * y / 2)
    assert contact.cycle_dissipation == pytest.approx(loop, rel=1e-8)  # cancels to some 1e-5 of its terms
    assert contact.cycle_dissipation == pytest.approx(4 * contact.first_dissipation, rel=1e-15)


def test_small_loads_do_not_cancel():
    """The work in a cycle goes with Q^3: (9/10)(5/162) = 1/36 of friction^2 P^2 k^3 C/a; the shift with Q."""
    tiny = theory.cattaneo_mindlin(P, 1e-6 * 0.4 * P, 0.4, 50.0, np.inf, E, 0.42, E, 0.42)
    compliance = tiny.contact.bodies.tangential_compliance
    assert tiny.cycle_dissipation == pytest.approx((0.4 * P) ** 2 * compliance / tiny.contact.a * 1e-18 / 36, rel=2e-6)
    assert tiny.shift == pytest.approx(compliance * 1e-6 * 0.4 * P / (8 * tiny.contact.a), rel=1e-6)
    # The series and the closed form meet at 0.1.
    below, above = (
        theory.cattaneo_mindlin(P, k * 0.4 * P, 0.4, 50.0, np.inf, E, 0.42, E, 0.42).cycle_dissipation
        for k in (0.1 - 1e-9, 0.1 + 1e-9)
    )
    assert below == pytest.approx(above, rel=1e-7) and below < above


@pytest.mark.parametrize("ratio, stick", [(0.25, 0.866025), (0.5, 0.707107), (0.75, 0.5)])
def test_line_partial_slip(ratio, stick):
    line = theory.cattaneo_mindlin_line(178.896, ratio * 0.3 * 178.896, 0.3, *ROLLERS)
    a, c = line.contact.half_width, line.stick_half_width
    assert c / a == pytest.approx(stick, abs=5e-7)
    total = sum(quad(line.traction, *ends)[0] for ends in ((-a, -c), (-c, c), (c, a)))
    assert total == pytest.approx(line.tangential_load_per_length, rel=1e-8)  # quad at roots
    # No strain difference in the stick zone, slip the right way beyond it.
    for x in np.array([-0.9, 0.0, 0.6]) * c:
        assert cauchy(line.traction, x, a, breaks=(-c, c)) == pytest.approx(0.0, abs=1e-6 * line.traction(0.0))
    assert cauchy(line.traction, (a + c) / 2, a, breaks=(-c, c)) > 1e-2 * line.traction(0.0)
    assert line.traction(1.1 * a) == 0.0 and line.traction(-0.99 * a) == 0.3 * line.contact.pressure(-0.99 * a)


def test_carter_numbers():
    by_creep = theory.carter(178.896, 0.3, *ROLLERS, creep=2.4e-4)
    # The load is printed to six digits.
    assert by_creep.tangential_load_per_length / (0.3 * 178.896) == pytest.approx(0.64, abs=1e-6)
    assert by_creep.stick_half_width / by_creep.contact.half_width == pytest.approx(0.6, abs=1e-6)
    assert by_creep.contact.peak_pressure == pytest.approx(113.889, abs=5e-4)
    by_load = theory.carter(178.896, 0.3, *ROLLERS, tangential_load_per_length=0.64 * 0.3 * 178.896)
    assert by_load.creep == pytest.approx(2.4e-4, rel=1e-6)
    assert by_load.stick_half_width / by_load.contact.half_width == pytest.approx(0.6, rel=1e-13)


@pytest.mark.parametrize("ratio", [0.01, 0.1, 0.64, 0.95])
def test_carter_strains(ratio):
    """In the stick strip the strains of the bodies differ by the creep, behind it by more: they slip against q."""
    Q = ratio * 0.3 * 178.896
    rolling = theory.carter(178.896, 0.3, *ROLLERS, tangential_load_per_length=Q)
    a, d, modulus = rolling.contact.half_width, rolling.stick_half_width, rolling.contact.bodies.modulus
    edge = a - 2 * d
    total = sum(quad(rolling.traction, *ends)[0] for ends in ((-a, edge), (edge, a)))
    assert total == pytest.approx(Q, abs=1e-8 * 178.896)  # quad at roots
    assert rolling.traction(edge + 0.3 * d) < 0.3 * rolling.contact.pressure(edge + 0.3 * d)
    for x in edge + 2 * d * np.array([0.05, 0.5, 0.9]):
        strain = -2 / (math.pi * modulus) * cauchy(rolling.traction, x, a, breaks=(edge,))
        assert strain == pytest.approx(-rolling.creep, abs=1e-8)  # quad at roots, strains of 1e-4
    x = (edge - a) / 2
    assert rolling.traction(x) == 0.3 * rolling.contact.pressure(x)
    # Slip velocity over rolling speed: creep plus strain difference; its sign opposes the traction.
    slip = rolling.creep - 2 / (math.pi * modulus) * cauchy(rolling.traction, x, a, breaks=(edge,))
    assert slip > 1e-3 * rolling.creep
    assert np.all(rolling.traction(np.linspace(-1.5, 1.5, 301) * a) >= 0)


def test_carter_limits():
    full = 0.3 * theory.hertz_line(178.896, *ROLLERS).half_width / 500.0
    for creep in (full, 2 * full):
        sliding = theory.carter(178.896, 0.3, *ROLLERS, creep=creep)
        assert (sliding.stick_half_width, sliding.creep) == (0.0, creep)
        assert sliding.tangential_load_per_length == pytest.approx(0.3 * 178.896, rel=1e-15)
    assert theory.carter(178.896, 0.3, *ROLLERS, tangential_load_per_length=0.3 * 178.896).creep == full
    # Little creep: Q = 2 friction P creep/full, slope 2 P R/a.
    small = theory.carter(178.896, 0.3, *ROLLERS, creep=1e-6 * full)
    assert small.tangential_load_per_length == pytest.approx(2e-6 * 0.3 * 178.896, rel=1e-6)
    again = theory.carter(178.896, 0.3, *ROLLERS, tangential_load_per_length=small.tangential_load_per_length)
    assert again.creep == pytest.approx(1e-6 * full, rel=1e-9)
    free = theory.carter(178.896, 0.3, *ROLLERS, creep=0.0)
    assert free.stick_half_width == free.contact.half_width and free.tangential_load_per_length == 0.0
    x = np.linspace(-1.5, 1.5, 301)
    assert free.traction(x) == pytest.approx(0.0, abs=1e-6 * free.contact.peak_pressure)  # roots of round-off at edges
    for wrong in ({}, {"creep": 1e-4, "tangential_load_per_length": 1.0}):
        with pytest.raises(ValueError, match="exactly one"):
            theory.carter(178.896, 0.3, *ROLLERS, **wrong)


def test_more_than_friction_holds():
    for function in (theory.cattaneo_mindlin, theory.cattaneo_mindlin_line):
        with pytest.raises(ValueError, match="slide"):
            function(1.0, 0.31, 0.3, *ROLLERS)
        with pytest.raises(ValueError, match="friction"):
            function(1.0, 0.0, 0.0, *ROLLERS)
    with pytest.raises(ValueError, match="slide"):
        theory.carter(1.0, 0.3, *ROLLERS, tangential_load_per_length=0.31)


def test_pulled_bar():
    bar = theory.bar_pull(1e3, 1e4, 0.3, 210e9, 1e-4)
    assert bar.slip_length == pytest.approx(1 / 3, rel=1e-15)
    # As many digits as are printed.
    assert bar.end_displacement == pytest.approx(7.93651e-6, abs=5e-12)
    assert bar.residual_displacement == pytest.approx(3.96825e-6, abs=5e-12)
    x = np.array([0.0, 0.1, 0.3, 0.5])
    h = 1e-5  # strain by central differences of a parabola: round-off only
    strain = (bar.displacement(x[1:3] - h) - bar.displacement(x[1:3] + h)) / (2 * h)
    assert bar.tension(x)[1:3] == pytest.approx(210e9 * 1e-4 * strain, rel=1e-8)
    assert bar.tension(x)[0] == 1e3 and bar.tension(x)[1] == pytest.approx(1e3 - 0.3 * 1e4 * 0.1, rel=1e-14)
    assert bar.tension(x)[3] == bar.displacement(x)[3] == 0.0
    assert bar.displacement(0.0) == bar.end_displacement
