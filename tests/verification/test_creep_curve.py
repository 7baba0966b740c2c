# SPDX-License-Identifier: MIT
"""A wheel on a rail in 3D against the program CONTACT: F-5, the creep curve of the locomotive Eurosprinter; F-6, a
transient."""

import math

import numpy as np
import pytest

import dolfinx_impact as di
from impact_studies.creep.model import CreepModel, WheelOnRail

G, NU = 82e9, 0.28
CREEP = np.array([4e-4, 1.2e-3, 2.0e-3, 2.8e-3])
CONTACT = np.array([0.2588, 0.6482, 0.8816, 0.9832])
SLOPE = 3.788  # of the curve at its beginning over G a b, C11; CONTACT


@pytest.fixture(scope="module")
def model():
    """The transverse radius makes the half-axis along the rail half of the one across."""
    data = WheelOnRail(106.7e3, 0.33, 0.625, 1.77672, E=2 * G * (1 + NU), nu=NU, speed=1.0, cells=5, reach=5.0)
    return CreepModel(data)


@pytest.mark.slow
def test_eurosprinter(model):
    """Found: 1.1 % too large at the small creep, 0.7 % above. The grid of CONTACT is 1 to 2 % high."""
    hertz = model.hertz
    assert hertz.a / hertz.b == pytest.approx(0.5, rel=1e-4)
    assert model.contact.force[2] * 2 == pytest.approx(106.7e3, rel=3e-4)
    assert model.contact.pressure.max() == pytest.approx(hertz.peak_pressure, rel=0.01)
    assert abs(model.free_creep) < 1e-4
    curve = model.curve(np.concatenate([[2e-5], CREEP]), progress=False)
    np.testing.assert_allclose(curve["ratio"][1:], CONTACT, rtol=0.03)
    slope = curve["force"][0, 0] / (2e-5 * G * hertz.a * hertz.b)
    assert slope == pytest.approx(SLOPE, rel=0.03)  # found: 1.4 %
    assert np.all(np.diff(curve["torque"]) > 0.0)
    np.testing.assert_allclose(curve["force"][:, 2], 106.7e3, rtol=1e-3)


# F-6: a ball of the curvature 0.002963 twice, in all directions. With the creep of 3.101e-3, after four half-axes of
# rolling, CONTACT has the tangential force 0.657.
BALL, ROLLED = 1.0 / (2 * 0.002963), 4.0
TRANSIENT_CREEP, TRANSIENT_RATIO = 3.101e-3, 0.657


@pytest.mark.slow
def test_a_transient_run_comes_to_the_steady_state():
    """F-6, 5 %. An explicit run begins with the steady state of free rolling; from then on the wheel turns faster.

    Found with 4 cells in the half-axis: steady state +0.9 %, run -4.3 % after four half-axes, -3.2 % after five.
    """
    data = WheelOnRail(
        load=0.4705, friction=0.4013, radius=BALL, crown_radius=math.inf, wheel_crown_radius=BALL, E=2.56, nu=0.28,
        density=1 / 900, speed=1.0, cells=4, path=ROLLED,
    )  # fmt: skip
    model = CreepModel(data, law=di.StVenantKirchhoff)  # shear waves are 30 times faster than the wheel
    a = model.hertz.a
    assert a == pytest.approx(3.49997, rel=1e-4)
    assert model.peak_pressure == pytest.approx(0.0183389, rel=0.02)
    free = model.wheel.omega
    model.wheel.omega = free * (1.0 + TRANSIENT_CREEP)
    run = di.ExplicitProblem.from_rolling(model.problem)
    run.advance(ROLLED * a, progress=False)
    force = run.force_history[0]
    ratio = force[:, 0] / (0.4013 * force[:, 2])
    last = ratio[-len(ratio) // 16 :].mean()  # a quarter of a half-axis: nodes close and open one by one
    assert last == pytest.approx(TRANSIENT_RATIO, rel=0.05)
    first = ratio[: len(ratio) // 8].mean()
    assert first < 0.3 * TRANSIENT_RATIO  # the force has to build up
    model.wheel.omega = free
    steady = model.curve([TRANSIENT_CREEP], progress=False)["ratio"][0]
    assert steady == pytest.approx(TRANSIENT_RATIO, rel=0.05)
