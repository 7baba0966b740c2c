# SPDX-License-Identifier: MIT
"""The hand-written laws of the interface by themselves, against closed forms."""

import math

import impact_reference as ref
import numpy as np
import pytest


def trapezoid(y, x):
    return float(np.sum(0.5 * (y[1:] + y[:-1]) * np.diff(x)))


def test_the_spring_only_pushes():
    assert ref.spring_pressure(0.1, 5.0) == (0.0, 0.0)
    assert ref.spring_pressure(-0.2, 5.0) == (1.0, 0.5 * 5.0 * 0.04)


def test_exponential_pressure_begins_at_the_clearance_and_has_its_value_at_zero():
    p, e = ref.exponential_pressure(0.0, 7.0, 0.1)
    # The area under p0/(e - 1) y (exp(y) - 1), y from 0 to 1, times the clearance: p0 c (1 - 1/2)/(e - 1).
    assert p == pytest.approx(7.0, rel=1e-15) and e == pytest.approx(7.0 * 0.1 * 0.5 / (math.e - 1), rel=1e-14)
    assert ref.exponential_pressure(0.1, 7.0, 0.1) == (0.0, 0.0)
    h = 1e-6  # the pressure is minus the slope of the energy
    up, down = (ref.exponential_pressure(-0.05 + s * h, 7.0, 0.1)[1] for s in (1, -1))
    assert (down - up) / (2 * h) == pytest.approx(ref.exponential_pressure(-0.05, 7.0, 0.1)[0], rel=1e-8)


def test_adhesion_takes_its_work():
    gaps = np.linspace(0.0, 4.0, 40001)
    pressures = np.array([ref.adhesive_pressure(g, 0.3, 0.1)[0] for g in gaps])
    assert -trapezoid(pressures, gaps) == pytest.approx(0.3, rel=1e-6)
    assert ref.adhesive_pressure(0.0, 0.3, 0.1) == (0.0, -0.3)
    assert pressures.min() == pytest.approx(-0.3 / 0.1 / math.e, rel=1e-9)


def test_damped_pressure_takes_energy():
    assert ref.damped_pressure(-0.1, -2.0, 10.0, 0.5) == (2.0, pytest.approx(0.05))
    assert ref.damped_pressure(-0.1, 4.0, 10.0, 0.5)[0] == 0.0  # it does not pull
    assert ref.damped_pressure(0.1, -2.0, 10.0, 0.5) == (0.0, 0.0)


def test_friction_loads_slips_and_turns_back():
    slips = np.zeros((6, 2))
    slips[:, 0] = [0.1, 0.3, 0.5, 0.4, 0.2, 0.2]
    answer = ref.friction_history(np.full(6, -1.0), slips, lambda g: (-g, 0.0), 10.0, lambda v: 0.2, 1.0)
    # The limit is 0.2: the spring of 10 reaches it at a slip of 0.02, and takes twice that to turn.
    assert np.allclose(answer.shear[:, 0], [-0.2, -0.2, -0.2, 0.2, 0.2, 0.2]) and not answer.shear[:, 1].any()
    assert np.allclose(answer.energy, 0.2**2 / 20.0)


def test_friction_depends_on_the_velocity():
    slips = np.array([[1.0, 0.0], [3.0, 0.0]])
    answer = ref.friction_history(np.full(2, -1.0), slips, lambda g: (-g, 0.0), 10.0, lambda v: 1 / v, 0.5)
    assert np.allclose(answer.shear[:, 0], [-0.5, -0.25])


@pytest.mark.parametrize("angle", [0.0, 0.4, 0.9, math.pi / 2])
def test_a_bond_spends_its_energy_of_fracture(angle):
    """At a fixed mode the work of separation is that of Benzeggagh and Kenane."""
    k, strengths, energies, exponent = 1e6, (300.0, 400.0), (0.2, 0.35), 1.6
    d = np.linspace(0.0, 3e-3, 60001)
    slips = np.column_stack([d * math.sin(angle), 0 * d])
    answer = ref.cohesive_history(d * math.cos(angle), slips, k, strengths, energies, exponent)
    work = -trapezoid(answer.pressure, d * math.cos(angle)) - trapezoid(answer.shear[:, 0], slips[:, 0])
    expected = energies[0] + (energies[1] - energies[0]) * math.sin(angle) ** (2 * exponent)
    assert work == pytest.approx(expected, rel=1e-5) and answer.state[-1] == 1.0
    assert all(b >= a for a, b in zip(answer.state, answer.state[1:]))


def test_a_bond_unloads_to_the_origin_and_bears_pressure():
    gaps = np.array([8e-4, 4e-4, 0.0, -1e-4])
    answer = ref.cohesive_history(gaps, np.zeros((4, 2)), 1e6, (300.0, 300.0), (0.2, 0.2), 1.0)
    assert answer.pressure[1] == pytest.approx(0.5 * answer.pressure[0]) and answer.pressure[0] < 0.0
    assert answer.pressure[2] == 0.0 and answer.pressure[3] == pytest.approx(100.0)
    assert len(set(answer.state)) == 1
