# SPDX-License-Identifier: MIT
"""Plastic answers: published numbers, equilibrium, yield condition, Hooke's law, shakedown, loops, fronts."""

import numpy as np
import pytest
from scipy.optimize import minimize

from dolfinx_impact import theory
from dolfinx_impact.theory import Stress, plasticity

VESSEL = (100.0, 200.0, 210.0, 0.3, 0.24)  # mm, GPa


@pytest.mark.parametrize(
    "front, pressure, outer, inner",
    [
        (100.0, 0.140000, 0.020000, 0.053333),
        (120.0, 0.212954, 0.034560, 0.097677),
        (150.0, 0.287123, 0.067500, 0.215310),
        (180.0, 0.325498, 0.116640, 0.404560),
    ],
)
def test_numbers_of_the_sphere(front, pressure, outer, inner):
    sphere = theory.plastic_sphere(*VESSEL, front=front)
    found = sphere.pressure, sphere.outer_displacement, sphere.inner_displacement
    assert found == pytest.approx((pressure, outer, inner), abs=5.1e-7)  # printed digits
    assert sphere.limit == pytest.approx(0.332711, abs=5e-7)
    assert sphere.first_yield == pytest.approx(0.14, rel=1e-14)
    # The other way round.
    again = theory.plastic_sphere(*VESSEL, pressure=sphere.pressure)
    assert again.front == pytest.approx(front, rel=1e-12)


@pytest.mark.parametrize("front, pressure, outer", [(120.0, 0.139207, 0.086464), (150.0, 0.172988, 0.135100)])
def test_numbers_of_the_cylinder(front, pressure, outer):
    cylinder = theory.plastic_cylinder(*VESSEL, front=front)
    assert (cylinder.pressure, cylinder.outer_displacement) == pytest.approx((pressure, outer), abs=5.1e-7)
    assert cylinder.limit == pytest.approx(0.192091, abs=5e-7)
    assert theory.plastic_cylinder(*VESSEL, pressure=cylinder.pressure).front == pytest.approx(front, rel=1e-12)


VESSELS = {"sphere": theory.plastic_sphere, "cylinder": theory.plastic_cylinder}


@pytest.mark.parametrize("name", VESSELS)
@pytest.mark.parametrize("given", [{"front": 130.0}, {"front": 200.0}, {"pressure": 0.05}])
def test_equations_of_the_vessels(name, given):
    """Equilibrium, boundary values, yield condition inside the front, elastic volume, Hooke's law outside."""
    vessel = VESSELS[name](*VESSEL, **given)
    a, b, E, nu, Y = VESSEL
    k = 2 if name == "sphere" else 1  # number of hoop stresses in the plane of equilibrium
    reached = Y if name == "sphere" else 2 * Y / np.sqrt(3)
    assert vessel.radial_stress(a) == pytest.approx(-vessel.pressure, rel=1e-12)
    assert vessel.radial_stress(b) == pytest.approx(0.0, abs=1e-15)
    for r in (105.0, 125.0, 131.0, 160.0, 195.0):
        h = 1e-3  # errors of central differences, h^2/r^2 = 1e-10
        radial, hoop, u = vessel.radial_stress(r), vessel.hoop_stress(r), vessel.displacement(r)
        slope = (vessel.radial_stress(r + h) - vessel.radial_stress(r - h)) / (2 * h)
        assert slope == pytest.approx(k * (hoop - radial) / r, rel=1e-7)
        strain = (vessel.displacement(r + h) - vessel.displacement(r - h)) / (2 * h)
        axial = hoop if name == "sphere" else nu * (radial + hoop)
        total = radial + hoop + axial
        assert strain + k * u / r == pytest.approx((1 - 2 * nu) / E * total, abs=1e-7 * Y / E)
        if "pressure" not in given and r < vessel.front:
            assert hoop - radial == pytest.approx(reached, rel=1e-12)
        else:
            assert hoop - radial < reached
            assert u / r == pytest.approx((hoop - nu * (radial + axial)) / E, rel=1e-9)
    assert np.isnan(vessel.radial_stress(99.0)) and np.isnan(vessel.displacement([201.0])[0])
    if vessel.front > a:
        assert vessel.hoop_stress(vessel.front) == pytest.approx(
            vessel.hoop_stress(vessel.front * (1 - 1e-13)), rel=1e-9
        )


def test_elastic_vessels_are_lames():
    """A pressure below first yield: u_a of Lame's thick cylinder and sphere."""
    a, b, E, nu, _ = VESSEL
    p = 0.03
    cylinder = theory.plastic_cylinder(*VESSEL, pressure=p)
    expected = (1 + nu) / E * p * a * ((1 - 2 * nu) * a**2 + b**2) / (b**2 - a**2)
    assert cylinder.inner_displacement == pytest.approx(expected, rel=1e-13) and cylinder.front == a
    sphere = theory.plastic_sphere(*VESSEL, pressure=p)
    expected = p * a / E * ((1 - 2 * nu) * a**3 + (1 + nu) * b**3 / 2) / (b**3 - a**3)
    assert sphere.inner_displacement == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize("name", VESSELS)
def test_refusals_of_the_vessels(name):
    call = VESSELS[name]
    with pytest.raises(ValueError, match="exactly one"):
        call(*VESSEL)
    with pytest.raises(ValueError, match="exactly one"):
        call(*VESSEL, pressure=0.1, front=120.0)
    with pytest.raises(ValueError, match="not be above"):
        call(*VESSEL, pressure=0.34)
    with pytest.raises(ValueError, match="not be above"):
        call(*VESSEL, front=201.0)
    with pytest.raises(ValueError, match="greater"):
        call(100.0, 100.0, *VESSEL[2:], front=100.0)


def test_prandtl():
    assert theory.prandtl_pressure(1.0) == pytest.approx(2.968500, abs=5e-7)


def test_line_rolling():
    """J-4: Y = 780 MPa: k = 450.33, first yield at 1399, shakedown at 1801 MPa."""
    found = theory.line_shakedown(780.0)
    assert found.shear_yield_stress == pytest.approx(450.33, abs=5e-3)
    assert found.first_yield == pytest.approx(1399.0, abs=0.5)
    assert found.shakedown == pytest.approx(1801.0, abs=0.5)
    assert found.depth == pytest.approx(0.7043, abs=1e-4)


def test_shakedown_is_melans():
    """Melan's theorem: with the best residual stresses, functions of the depth alone, no point of any depth yields in a
    pass at 4 k; beyond it the orthogonal shear p0/4 alone does, and without residual stresses first yield is sooner."""
    found = theory.line_shakedown(780.0)
    contact = theory.hertz_line(1.0, 1.0, np.inf, 1.0, 0.3, 1.0, 0.3)
    x = np.linspace(-4.0, 4.0, 1601) * contact.half_width
    scale, needed, without = found.shakedown / contact.peak_pressure, [], []
    for z in np.linspace(0.02, 1.5, 75):
        s = contact.stress(z * contact.half_width, x)

        def peak(residual):
            moved = Stress(s.sigma_x + residual[0], s.sigma_y + residual[1], s.sigma_z, s.tau_xz)
            return scale * np.max(moved.mises)

        start = -0.1 * contact.peak_pressure * np.ones(2)
        best = minimize(peak, start, method="Nelder-Mead", options={"xatol": 1e-6 * -start[0], "fatol": 1e-6 * 780})
        needed.append(best.fun)
        without.append(peak([0.0, 0.0]))
    assert max(needed) == pytest.approx(780.0, rel=1e-3)  # depths in steps of a/50
    assert max(without) == pytest.approx(780.0 * found.shakedown / found.first_yield, rel=1e-3)
    shear = np.abs(contact.stress(0.5 * contact.half_width, x).tau_xz).max()
    assert scale * shear == pytest.approx(found.shear_yield_stress, rel=1e-4)


def test_uniaxial_paths():
    """J-5: sigma = Y + H eps_p; Prager's and Armstrong and Frederick's loops against their differential equation."""
    strain, stress = plasticity.uniaxial_path([0.0, 0.01, 0.02], 210e3, 250.0, hardening=5e3)
    assert stress == pytest.approx([250.0, 300.0, 350.0], rel=1e-14)
    assert strain == pytest.approx([250 / 210e3, 0.01 + 300 / 210e3, 0.02 + 350 / 210e3], rel=1e-14)
    _, stress = plasticity.uniaxial_path([0.01, -0.01, 0.0], 210e3, 250.0, kinematic=2e4)
    assert stress == pytest.approx([200 + 250.0, -200 - 250.0, 0 + 250.0], rel=1e-12)
    path, C, gamma, Y, H = [0.02, -0.01, 0.03], 4e4, 150.0, 250.0, 2e3
    X = e = a = 0.0
    found = []
    for end in path:  # Heun's rule, an error of the square of the steps
        h = (end - e) / 20000
        for _ in range(20000):
            slope = C - gamma * X * np.sign(h)
            X += h * (slope + C - gamma * (X + h * slope) * np.sign(h)) / 2
        a, e = a + abs(end - e), end
        found.append(X + np.sign(h) * (Y + H * a))
    _, stress = plasticity.uniaxial_path(path, 210e3, Y, H, C, gamma)
    assert stress == pytest.approx(found, rel=1e-6)


@pytest.mark.parametrize("recall", [0.0, 90.0])
def test_stable_cycle(recall):
    """Many cycles of a path end in the loop; its area by the trapezoidal rule; saturation at Y + C/gamma."""
    A, E, Y, C = 0.01, 207e3, 400.0, 4e4
    cycle = theory.plastic_cycle(A, E, Y, C, recall)
    path = A * (-1.0) ** np.arange(41)
    strain, stress = plasticity.uniaxial_path(path, E, Y, kinematic=C, recall=recall)
    assert stress[-1] == pytest.approx(cycle.stress_amplitude, rel=1e-12)
    assert strain[-1] == pytest.approx(cycle.strain_amplitude, rel=1e-12)
    e, s = cycle.loop(20001)
    assert s.max() == pytest.approx(cycle.stress_amplitude, rel=1e-12) and s.min() == pytest.approx(-s.max())
    assert np.trapezoid(s, e) == pytest.approx(cycle.work, rel=1e-6)
    if recall:
        wide = theory.plastic_cycle(1.0, E, Y, C, recall)
        assert wide.stress_amplitude == pytest.approx(Y + C / recall, rel=1e-12)
        assert theory.plastic_cycle(A, E, Y, C, 1e-7).work == pytest.approx(4 * Y * A, rel=1e-5)  # Prager's


def test_elastic_plastic_bar():
    """I-7a, and momentum and the work of the wall."""
    v, rho, E, Y, Et = 40.0, 7800.0, 207e9, 780e6, 20.7e9
    bar = theory.plastic_bar_impact(v, rho, E, Y, Et)
    assert bar.wave_speed == pytest.approx(5151.55, abs=5e-3) and bar.plastic_speed == pytest.approx(1629.06, abs=5e-3)
    assert bar.stress == pytest.approx(1041.61e6, abs=5e3) and bar.precursor == Y
    assert bar.strain == pytest.approx(0.01640628, abs=5e-9) and bar.plastic_strain == pytest.approx(
        0.01137435, abs=5e-9
    )
    x = (np.arange(200000) + 0.5) * 1e-5
    stress, left = bar.waves(x, 3e-4)
    assert np.sum(rho * (v - left)) * 1e-5 == pytest.approx(bar.stress * 3e-4, rel=1e-4)  # cells at the fronts
    # What is shortened came into the wall's side: v t.
    strain = np.where(stress > 1.01 * Y, bar.strain, stress / E)
    assert np.sum(strain) * 1e-5 == pytest.approx(v * 3e-4, rel=1e-3)
    assert left[0] == 0 and left[-1] == v and stress[-1] == 0


def test_slow_bar_stays_elastic():
    v = 10.0
    bar = theory.plastic_bar_impact(v, 7800.0, 207e9, 780e6, 20.7e9)
    exact = theory.bar_impact(v, 1.0, 7800.0, 207e9)
    assert not bar.plastic and bar.stress == pytest.approx(exact.stress, rel=1e-14) and bar.plastic_strain == 0.0
    stress, left = bar.waves([0.1, 2.0], 1e-4)
    assert stress == pytest.approx([exact.stress, 0.0]) and left == pytest.approx([0.0, v])
    limit = theory.yield_velocity(780e6, 7800.0, 207e9, 0.3).bar
    assert bar.yield_velocity == pytest.approx(limit, rel=1e-14)
    for velocity in (limit * (1 - 1e-9), limit * (1 + 1e-9)):
        fast = theory.plastic_bar_impact(velocity, 7800.0, 207e9, 780e6, 20.7e9)
        assert fast.stress == pytest.approx(780e6, rel=1e-8)
    with pytest.raises(ValueError, match="tangent_modulus"):
        theory.plastic_bar_impact(v, 7800.0, 207e9, 780e6, 208e9)
