# SPDX-License-Identifier: MIT
"""Shaft pressed into a ring (Lame): the interference is an overlap of the meshes, as a shrink fit is computed."""

import math

import numpy as np
import pytest
from contact_model import Model, enforce
from shaft_in_ring_mesh import shaft_in_ring

import dolfinx_impact as di

E, NU, RADIUS, OUTER, INTERFERENCE = 210e3, 0.3, 50.0, 100.0, 0.05


def fit(method, degree, num_shaft, num_ring, **options):
    steel = di.LinearElastic(E, NU, hypothesis="plane_stress")
    m = Model(shaft_in_ring(RADIUS, OUTER, INTERFERENCE, num_shaft, num_ring, degree), steel, degree)
    m.hold("symmetry_x", 0)
    m.hold("bottom", 1)
    problem = m.problem(enforce(method, m.pair(), **options))
    report, contact = problem.solve(), problem.contact[0]
    assert report.cut_backs == 0 and max(report.iterations) <= 8
    exact = di.theory.press_fit(INTERFERENCE, RADIUS, OUTER, E, NU, E, NU)
    assert exact.pressure == pytest.approx(78.75, rel=1e-12)
    mean = np.sum(contact.weight * contact.pressure) / np.sum(contact.weight)
    # On a quarter of the circle the forces of an even pressure are radius times pressure along both axes.
    np.testing.assert_allclose(np.abs(contact.force), exact.pressure * RADIUS, rtol=0.03)
    return m, contact, mean / exact.pressure, contact.pressure / exact.pressure


@pytest.mark.parametrize("num_shaft, num_ring", [(12, 17), (24, 35)])
def test_curved_facets_by_multipliers(num_shaft, num_ring):
    """Quadratic facets on the circle, not matching: 1 % in the mean and at every node."""
    m, contact, mean, pressure = fit("Lagrange", 2, num_shaft, num_ring)
    assert mean == pytest.approx(1.0, abs=0.01)
    np.testing.assert_allclose(pressure, 1.0, atol=0.01)
    # Lame's stress in the ring shows in the displacement of its outer face: u = p b^2/(c^2 - b^2) 2 c/E.
    outer = 2 * 78.75 * RADIUS**2 / (OUTER**2 - RADIUS**2) * OUTER / E
    assert m.at((OUTER, 0.0))[0] == pytest.approx(outer, rel=0.01)


@pytest.mark.parametrize("augmented", [False, True])
def test_curved_facets_by_penalty(augmented):
    """1 % in the mean; a quadratic facet leaves the circle by a tenth of the penetration, so that single points do not
    say much."""
    _, contact, mean, pressure = fit("Penalty", 2, 12, 17, augmented=augmented)
    assert mean == pytest.approx(1.0, abs=0.01)
    assert 0.8 < pressure.min() and pressure.max() < 1.2


@pytest.mark.parametrize("method", ["Lagrange", "Penalty"])
def test_straight_facets(method):
    """3 % with chords so short that their height over the arc is below 5 % of the interference."""
    num_shaft, num_ring = 80, 111
    assert RADIUS / 8 * (math.pi / 2 / num_shaft) ** 2 < 0.05 * INTERFERENCE
    _, contact, mean, pressure = fit(method, 1, num_shaft, num_ring)
    assert mean == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("method", ["Lagrange", "Penalty"])
@pytest.mark.parametrize("degree", [1, 2])
def test_ring_on_a_rigid_shaft(method, degree):
    """Section of the ring in (r, z), held between rigid plates: a plane r = const is a rigid cylinder."""
    exact = di.theory.press_fit(INTERFERENCE, RADIUS, OUTER, np.inf, NU, E, NU, hypothesis="plane_strain")
    steel, size = di.LinearElastic(E, NU, hypothesis="axisymmetric"), (OUTER - RADIUS, 10.0)
    m = Model("block", steel, degree, size=size, cells=(25, 5), origin=(RADIUS, 0.0))
    m.hold("bottom", 1)
    m.hold("top", 1)
    shaft = di.RigidPlane((RADIUS + INTERFERENCE, 0.0), (1.0, 0.0))
    problem = m.problem(enforce(method, m.pair("left", shaft)))
    problem.solve()
    contact = problem.contact[0]
    # Linear cells, two millimetres: 0.1 %. The penalty gives way by a tenth of what the outermost cells do.
    tolerance = 1e-3 if method == "Lagrange" else 0.01
    np.testing.assert_allclose(contact.pressure, exact.pressure, rtol=tolerance)
    assert contact.force[0] == pytest.approx(exact.pressure * 2 * math.pi * RADIUS * 10.0, rel=tolerance)
    assert contact.area == pytest.approx(2 * math.pi * RADIUS * 10.0, rel=1e-12)
