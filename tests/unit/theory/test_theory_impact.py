# SPDX-License-Identifier: MIT
"""Waves, yield velocities and Hertz's impact, seed (3.82), (3.83), corrected."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from dolfinx_impact import theory

BAR_SPEED = math.sqrt(207e9 / 7800)


def test_stress_of_an_impact():
    assert theory.impact_stress(7800.0, 5900.0, 16.949) == pytest.approx(780e6, rel=1e-4)  # the seed's example
    assert theory.impact_stress(1.0, 30.0, 10.0) == pytest.approx(300.0, rel=1e-15)
    assert theory.impact_stress(7800.0, 5900.0, 0.0) == 0.0
    aluminium = math.sqrt(70e9 / 2700)
    two = theory.impact_stress(2700.0, aluminium, 10.0, 7800.0, BAR_SPEED)
    assert two / 1e6 == pytest.approx(102.4317, abs=5e-5)  # digits printed
    assert two == pytest.approx(theory.impact_stress(7800.0, BAR_SPEED, 10.0, 2700.0, aluminium), rel=1e-15)
    # Equal bars take half the closing speed each; against something much heavier it is a wall.
    equal = theory.impact_stress(7800.0, 5000.0, 2.0, 7800.0, 5000.0)
    assert equal == pytest.approx(theory.impact_stress(7800.0, 5000.0, 1.0), rel=1e-15)
    wall = theory.impact_stress(7800.0, 5000.0, 1.0, 7800e12, 5000.0)
    assert wall == pytest.approx(theory.impact_stress(7800.0, 5000.0, 1.0), rel=2e-12)
    for half in ({"density2": 1.0}, {"c2": 1.0}):
        with pytest.raises(ValueError, match="both density2 and c2"):
            theory.impact_stress(1.0, 1.0, 1.0, **half)


def test_bar_on_a_rigid_wall():
    """Carpenter, Taylor and Katona 1991; inches, pounds, seconds."""
    bar = theory.bar_impact(202.2, 10.0, 7.3e-4, 3e7)
    # As many digits as are printed.
    assert bar.wave_speed == pytest.approx(202721.2, abs=0.05)
    assert bar.stress == pytest.approx(29922.9, abs=0.05)
    assert bar.shortening == pytest.approx(0.00997429, abs=5e-9)
    assert 0.01 / 202.2 + bar.release_time == pytest.approx(1.481136e-4, abs=5e-11)
    assert bar.rear_velocity == -202.2 and bar.interface_velocity == 0.0 and bar.separates
    # Momentum: the force over the contact turns the speed round.
    assert bar.stress * bar.release_time == pytest.approx(2 * 7.3e-4 * 10.0 * 202.2, rel=1e-14)
    # The bar of Doyen, Ern and Piperno: contact 2/3 long, pressure 300.
    bar = theory.bar_impact(10.0, 10.0, 1.0, 900.0)
    assert (bar.stress, bar.release_time) == (pytest.approx(300.0, rel=1e-15), pytest.approx(2 / 3, rel=1e-15))


def test_two_bars():
    bar = theory.bar_impact(10.0, 0.2, 2700.0, 70e9, 7800.0, 207e9)
    assert bar.interface_velocity == pytest.approx(2.549189, abs=5e-7)  # digits printed
    assert bar.rear_velocity == pytest.approx(-4.901623, abs=5e-7)
    assert bar.release_time * 1e6 == pytest.approx(78.558, abs=5e-4)
    assert bar.stress == pytest.approx(theory.impact_stress(2700, bar.wave_speed, 10, 7800, BAR_SPEED), rel=1e-14)
    equal = theory.bar_impact(10.0, 0.2, 2700.0, 70e9, 2700.0, 70e9)
    assert equal.interface_velocity == pytest.approx(5.0, rel=1e-15) and equal.rear_velocity == pytest.approx(
        0, abs=1e-14
    )
    assert equal.separates and not theory.bar_impact(10.0, 0.2, 7800.0, 207e9, 2700.0, 70e9).separates
    with pytest.raises(ValueError, match="both density2 and E2"):
        theory.bar_impact(1.0, 1.0, 1.0, 1.0, density2=1.0)


def test_yield_velocities():
    found = theory.yield_velocity(780e6, 7800.0, 207e9, 0.3, c=5900.0)
    # As many digits as are printed.
    assert found.printed == pytest.approx(16.949, abs=5e-4)
    assert found.bar == pytest.approx(19.4116, abs=5e-5)
    assert found.two_bars == 2 * found.bar
    assert found.hugoniot / 1e6 == pytest.approx(1365.0, rel=1e-14)
    assert found.uniaxial_strain == pytest.approx(29.2788, abs=5e-5)
    assert found.sphere == pytest.approx(0.0758, abs=5e-5)
    # Each is the speed whose wave has just the stress that yields in its state.
    assert theory.impact_stress(7800.0, BAR_SPEED, found.bar) == pytest.approx(780e6, rel=1e-14)
    dilatational = 5977.03  # as printed
    assert theory.impact_stress(7800.0, dilatational, found.uniaxial_strain) == pytest.approx(1365e6, rel=2e-6)
    # Mises in uniaxial strain: sigma - sigma nu/(1 - nu) = Y.
    assert found.hugoniot * (1 - 0.3 / 0.7) == pytest.approx(780e6, rel=1e-14)
    # Without a speed of its own the printed form takes the dilatational one.
    default = theory.yield_velocity(780e6, 7800.0, 207e9, 0.3)
    assert default.printed == pytest.approx(780e6 / (7800 * dilatational), rel=2e-6)
    with pytest.raises(ValueError, match="0.5"):
        theory.yield_velocity(780e6, 7800.0, 207e9, 0.5)


def test_a_sphere_yields_at_the_peak_of_its_impact():
    found = theory.yield_velocity(780e6, 7800.0, 207e9, 0.3)
    R = 0.02
    hit = theory.hertz_impact(found.sphere_mises, 4 / 3 * math.pi * R**3 * 7800, np.inf, R, np.inf, *(207e9, 0.3) * 2)
    static = theory.hertz_point(hit.peak_force, R, np.inf, *(207e9, 0.3) * 2)
    assert static.peak_pressure == pytest.approx(hit.peak_pressure, rel=1e-12)
    assert static.largest_mises()[0] == pytest.approx(780e6, rel=1e-9)  # a search for the largest value
    # Johnson rounds the factor 26.6 of this nu to 26, from p0 = 1.60 Y.
    assert found.sphere == pytest.approx(found.sphere_mises, rel=0.015)


MASS = 4 / 3 * math.pi * 0.01**3 * 7800.0
STEEL = (207e9, 0.3, 207e9, 0.3)
SPHERES = theory.hertz_impact(1.0, MASS, MASS, 0.01, 0.01, *STEEL)
DROP = theory.hertz_impact(1.0, MASS, np.inf, 0.01, np.inf, *STEEL)


@pytest.mark.parametrize(
    "hit, approach, duration, force, pressure",
    [(SPHERES, 20.5067, 60.3569, 995.788, 4.637), (DROP, 23.5560, 69.3319, 1733.77, 3.514)],
    ids=["two spheres", "sphere on half-space"],
)
def test_hertz_impact_numbers(hit, approach, duration, force, pressure):
    # Half a unit of the last digit printed.
    assert hit.max_approach * 1e6 == pytest.approx(approach, abs=5e-5)
    assert hit.duration * 1e6 == pytest.approx(duration, abs=5e-5)
    assert hit.peak_force == pytest.approx(force, abs=5e-3)
    assert hit.peak_pressure / 1e9 == pytest.approx(pressure, abs=5e-4)
    # The static contact under the peak force has the same approach and radius.
    radii = (0.01, 0.01) if hit is SPHERES else (0.01, np.inf)
    static = theory.hertz_point(hit.peak_force, *radii, *STEEL)
    assert (static.approach, static.a) == pytest.approx((hit.max_approach, hit.max_radius), rel=1e-13)


@pytest.mark.parametrize("hit", [SPHERES, DROP], ids=["two spheres", "sphere on half-space"])
def test_hertz_impact_balances(hit):
    """Energy and momentum, and the duration as the integral of dx/v, of which the curve in time knows nothing."""
    factor = hit.peak_force / hit.max_approach**1.5
    assert hit.mass * hit.velocity**2 / 2 == pytest.approx(0.4 * factor * hit.max_approach**2.5, rel=1e-13)
    assert 2 * quad(lambda s: 1 / math.sqrt(1 - s**2.5), 0, 1)[0] == pytest.approx(
        hit.duration * hit.velocity / hit.max_approach, rel=1e-7
    )  # quad at 1/sqrt
    impulse = quad(hit.force, 0, hit.duration, epsabs=0, epsrel=1e-9)[0]
    assert impulse == pytest.approx(2 * hit.mass * hit.velocity, rel=1e-8)
    # 2.868266 (m^2/(R E*^2 V))^(1/5)
    scale = (hit.mass**2 / (hit.radius * hit.bodies.modulus**2 * hit.velocity)) ** 0.2
    assert hit.duration / scale == pytest.approx(2.868266, abs=5e-7)


def test_force_history():
    t, force = DROP.history(101)
    assert len(t) == len(force) == 101 and t[-1] == DROP.duration
    assert force[0] == 0.0 and force[-1] == pytest.approx(0.0, abs=1e-9 * DROP.peak_force)
    assert force[50] == pytest.approx(DROP.peak_force, rel=1e-10) and np.argmax(force) == 50  # the curve's own error
    assert force == pytest.approx(force[::-1], rel=1e-8, abs=1e-9 * DROP.peak_force)
    assert np.array_equal(DROP.force(np.array([-1.0, 2 * DROP.duration])), [0.0, 0.0])
    # Newton's law by second differences: error ~ h^2.
    h = DROP.duration / 2000
    for s in np.array([0.2, 0.4, 0.7]) * DROP.duration:
        acceleration = (DROP.approach(s - h) - 2 * DROP.approach(s) + DROP.approach(s + h)) / h**2
        assert -DROP.mass * acceleration == pytest.approx(DROP.force(s), rel=1e-5)
    speed = (DROP.approach(1e-3 * h) - DROP.approach(0.0)) / (1e-3 * h)
    assert speed == pytest.approx(1.0, rel=1e-6)


def test_hertz_impact_refuses():
    with pytest.raises(ValueError, match="masses"):
        theory.hertz_impact(1.0, np.inf, np.inf, 0.01, np.inf, *STEEL)
    with pytest.raises(ValueError, match="at least|not be below|greater"):
        DROP.history(1)
