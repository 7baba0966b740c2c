# SPDX-License-Identifier: MIT
"""Each class of results by what its fields must add up to: loads are integrals of tractions, jumps keep momentum.

Integrals are done by quadrature that knows nothing of the closed forms; the results are those of `theory_calls.call`.
"""

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import dblquad, quad
from singular_integrals import integral_of_punch
from theory_calls import CALLS, call

from dolfinx_impact import theory
from dolfinx_impact.theory.result import Result


def given(name, *arguments):
    return [CALLS[name][0][argument][0] for argument in arguments]


def line(field, size):
    """Integral over -size < x < size of a field with square roots at the ends, x = size sin(angle), apex at zero."""

    def half(low, high):
        return quad(lambda t: field(size * math.sin(t)) * size * math.cos(t), low, high, limit=400)[0]

    return half(-math.pi / 2, 0.0) + half(0.0, math.pi / 2)


def disc(field, size):
    """Integral over the disc r < size of a field of the radius."""
    return quad(lambda t: field(size * math.sin(t)) * math.pi * size**2 * math.sin(2 * t), 0, math.pi / 2, limit=400)[0]


def ellipse(result):
    """Integral of a pressure over the ellipse of a result."""

    def ring(t, angle):
        x, y = result.a * math.sin(t) * math.cos(angle), result.b * math.sin(t) * math.sin(angle)
        return result.pressure(x, y) * result.a * result.b * math.sin(2 * t) / 2

    return 4 * dblquad(ring, 0, math.pi / 2, 0, math.pi / 2, epsrel=1e-9)[0]


def relative_curvature(r):
    # Sections of the gap are parabolas with the radii R' and R''.
    return [(r.gap(2.0, 0.0), 4.0 / (2 * r.Rx)), (r.gap(0.0, 3.0), 9.0 / (2 * r.Ry))]


def dundurs(r):
    E1, nu1, E2, nu2 = given("dundurs", "E1", "nu1", "E2", "nu2")
    M1, M2 = E1 / (1 - nu1**2), E2 / (1 - nu2**2)
    return [(r.alpha, (M2 - M1) / (M1 + M2))]


def bonded_indentation(r):
    # The peak is the largest shear, and the pressure is that of the frictionless contact with its load.
    peak = max(abs(r.shear(x)) for x in np.linspace(0.0, r.half_width, 20001))
    return [(peak, r.peak_shear), (line(r.pressure, r.half_width), given("bonded_indentation", "load_per_length")[0])]


def hertz_impact(r):
    # The impulse turns the relative velocity round.
    return [(quad(r.force, 0.0, r.duration, epsrel=1e-11)[0], 2 * r.mass * r.velocity)]


def bar_impact(r):
    # The impulse of the contact is the striker's momentum that is lost.
    length, density, velocity = given("bar_impact", "length", "density", "velocity")
    return [(r.stress * r.release_time, density * length * (velocity - r.rear_velocity))]


def yield_velocity(r):
    density, E, nu = given("yield_velocity", "density", "E", "nu")
    rod, plate = math.sqrt(E / density), math.sqrt(E * (1 - nu) / (density * (1 + nu) * (1 - 2 * nu)))
    return [
        (theory.impact_stress(density, rod, r.bar), r.yield_stress),
        (theory.impact_stress(density, rod, r.two_bars, density, rod), r.yield_stress),
        (theory.impact_stress(density, plate, r.uniaxial_strain), r.hugoniot),
    ]


def press_fit(r):
    # Half of the ring is pulled apart by the pressure on its bore.
    return [(quad(r.hoop_stress, r.radius, r.outer_radius)[0], r.pressure * r.radius)]


def bar_pull(r):
    stretch = quad(lambda x: r.tension(x) / r.axial_stiffness, 0.0, r.slip_length)[0]
    return [(stretch, r.end_displacement), (r.friction_per_length * r.slip_length, r.force)]


def vessel(weight):
    """Equilibrium along the radius: what the hoop carries is the pressure inside."""

    def balance(r):
        def hoop(x):
            return weight * (r.hoop_stress(x) - r.radial_stress(x)) / x

        low, high = given("plastic_sphere", "inner_radius", "outer_radius")
        return [(quad(hoop, low, r.front)[0] + quad(hoop, r.front, high)[0], r.pressure)]

    return balance


def line_shakedown(r):
    # The contact whose peak pressure is that of first yield has Y as its largest equivalent stress.
    Y, nu = given("line_shakedown", "yield_stress", "nu")
    contact = theory.hertz_line(1.0, 1.0, math.inf, 1e3, nu, 1e3, nu)
    mises, depth = contact.largest_mises()
    return [
        (r.first_yield * mises / contact.peak_pressure, Y),
        (r.depth, depth / contact.half_width),
        (math.sqrt(3) * r.shear_yield_stress, Y),
    ]


def plastic_cycle(r):
    # Trapezoidal rule over the loop: its branches are curves, elastic lines close it.
    strain, stress = r.loop(20001)
    return [
        (np.trapezoid(stress, strain), r.work),
        (np.ptp(stress), 2 * r.stress_amplitude),
        (np.ptp(strain), 2 * r.strain_amplitude),
    ]


def plastic_bar_impact(r):
    # Momentum over both fronts: the first takes the bar to Y, the second stops it.
    (density,) = given("plastic_bar_impact", "density")
    stopped = r.velocity - r.yield_velocity
    time = 1e-6
    x = (np.arange(200000) + 0.5) / 200000 * 1.5 * r.wave_speed * time
    _, v = r.waves(x, time)
    lost = density * np.sum(r.velocity - v) * (x[1] - x[0])
    return [
        (density * r.wave_speed * r.yield_velocity, r.precursor),
        (r.precursor + density * r.plastic_speed * stopped, r.stress),
        (lost / time, r.stress),
    ]


# class: (name of its call, what must agree: pairs of numbers, relative tolerance). Quadrature has 1e-8 and better; a
# grid finds a smooth peak to its step squared, a jump to its step.
BALANCES = {
    theory.HertzLine: ("hertz_line", lambda r: [(line(r.pressure, r.half_width), r.load_per_length)], 1e-9),
    theory.HertzPoint: ("hertz_point", lambda r: [(disc(r.pressure, r.a), r.load)], 1e-9),
    theory.HertzElliptic: ("hertz_elliptic", lambda r: [(ellipse(r), r.load)], 1e-8),
    theory.RelativeCurvature: ("relative_curvature", relative_curvature, 1e-12),
    theory.WinklerContact: ("winkler", lambda r: [(ellipse(r), r.load)], 1e-8),
    theory.FlatPunch: (
        "flat_punch",
        lambda r: [
            (integral_of_punch(r.pressure, r.half_width), r.load_per_length),
            (integral_of_punch(r.shear, r.half_width), r.tangential_load_per_length),
        ],
        1e-6,
    ),
    theory.CircularPunch: ("circular_punch", lambda r: [(disc(r.pressure, r.radius), r.load)], 1e-8),
    theory.Wedge: ("wedge", lambda r: [(line(r.pressure, r.half_width), r.load_per_length)], 1e-6),
    theory.Cone: ("cone", lambda r: [(disc(r.pressure, r.a), r.load)], 1e-8),
    theory.Dundurs: ("dundurs", dundurs, 1e-12),
    theory.BondedIndentation: ("bonded_indentation", bonded_indentation, 1e-7),
    theory.CattaneoMindlin: ("cattaneo_mindlin", lambda r: [(disc(r.traction, r.contact.a), r.tangential_load)], 1e-7),
    theory.CattaneoMindlinLine: (
        "cattaneo_mindlin_line",
        lambda r: [(line(r.traction, r.contact.half_width), r.tangential_load_per_length)],
        1e-7,
    ),
    theory.Carter: (
        "carter",
        lambda r: [(line(r.traction, r.contact.half_width), r.tangential_load_per_length)],
        1e-7,
    ),
    theory.BarImpact: ("bar_impact", bar_impact, 1e-12),
    theory.YieldVelocity: ("yield_velocity", yield_velocity, 1e-12),
    theory.HertzImpact: ("hertz_impact", hertz_impact, 1e-8),
    theory.PressFit: ("press_fit", press_fit, 1e-9),
    theory.BarPull: ("bar_pull", bar_pull, 1e-9),
    theory.PlasticSphere: ("plastic_sphere", vessel(2.0), 1e-9),
    theory.PlasticCylinder: ("plastic_cylinder", vessel(1.0), 1e-6),
    theory.LineShakedown: ("line_shakedown", line_shakedown, 1e-6),
    theory.PlasticCycle: ("plastic_cycle", plastic_cycle, 1e-6),
    theory.PlasticBarImpact: ("plastic_bar_impact", plastic_bar_impact, 2e-5),
}


def test_every_class_of_results_has_a_balance():
    assert set(BALANCES) == {kind for kind in Result.__subclasses__() if kind.__module__.startswith("dolfinx_impact.")}


@pytest.mark.parametrize("kind", BALANCES, ids=lambda kind: kind.__name__)
def test_fields_add_up(kind):
    name, balance, tolerance = BALANCES[kind]
    result = call(name)
    assert type(result) is kind and dataclasses.is_dataclass(kind)
    for found, expected in balance(result):
        assert found == pytest.approx(expected, rel=tolerance)
