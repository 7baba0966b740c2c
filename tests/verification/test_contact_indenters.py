# SPDX-License-Identifier: MIT
"""Indenters with a corner or a tip on a half-plane and a half-space: flat punch, circular punch, wedge, cone."""

import math

import numpy as np
import pytest
from contact_model import Model, enforce

import dolfinx_impact as di
from dolfinx_impact import theory

E, NU, HALF_WIDTH = 207e9, 0.3, 0.01


class Punch:
    """A nearly rigid punch (1000 times stiffer: 0.1 % of the displacements) with a square corner, half of it."""

    def __init__(self, method, degree, hypothesis, h, far, friction=0.0, depth=1e-6):
        a = HALF_WIDTH
        law = {
            "master_body": di.LinearElastic(E, NU, hypothesis=hypothesis),
            "slave_body": di.LinearElastic(1e3 * E, NU, hypothesis=hypothesis),
        }
        size = dict(half_width=a, height=a, block_width=far * a, block_height=far * a, h=h, coarse=far * a / 10)
        m = Model("punch", law, degree, **size)
        m.hold("bottom")
        m.hold("symmetry_x", 0)
        m.hold("top", 0)
        m.hold("top", 1, value=-depth)
        problem = m.problem(enforce(method, m.pair(friction=friction)))
        self.report, self.contact = problem.solve(), problem.contact[0]
        self.distance = HALF_WIDTH - m.places(self.contact)[:, 0]  # from the corner
        self.load = abs(self.contact.force[1])
        # Bodies that touch all over from the start: one linear problem.
        assert max(self.report.iterations) <= 4 and np.all(self.contact.status > 0)


@pytest.mark.covering(1)
@pytest.mark.parametrize("friction", [0.0, 20.0], ids=["frictionless", "bonded"])
@pytest.mark.parametrize("method, degree, h", [("Lagrange", 1, 1e-4), ("Lagrange", 2, 2e-4), ("Penalty", 1, 2e-4)])
def test_flat_punch(method, degree, h, friction):
    """Pressure on |x| <= 0.8 a within 2 % of the half-plane's; a large friction coefficient bonds.

    The block is 40 a wide and deep: its bounds change the load that goes with a displacement, not the pressure.
    """
    p = Punch(method, degree, "plane_strain", h, far=40, friction=friction)
    exact = theory.flat_punch(2 * p.load, HALF_WIDTH, NU, "bonded" if friction else "frictionless")
    inside = p.distance > 0.2 * HALF_WIDTH
    expected = exact.pressure(HALF_WIDTH - p.distance[inside])
    np.testing.assert_allclose(p.contact.pressure[inside], expected, rtol=0.02)
    if friction:
        assert np.all(p.contact.status == di.ContactStatus.stick)
        shear = p.contact.traction[:, 0]  # on the punch; on the half-plane the opposite
        found = -shear[inside] - exact.shear(HALF_WIDTH - p.distance[inside])
        assert np.abs(found).max() < 0.04 * exact.pressure(0.0)  # cells at 0.8 a are a/10 long


def test_singularity_at_the_corner():
    """The pressure grows with the inverse square root of the distance from the corner; exponent to 0.03."""
    h = 5e-5
    p = Punch("Lagrange", 2, "plane_strain", h, far=40)
    near = (p.distance > 3 * h) & (p.distance < 0.1 * HALF_WIDTH)
    assert np.count_nonzero(near) >= 6
    s = p.distance[near]
    exact = theory.flat_punch(2 * p.load, HALF_WIDTH)
    slope, expected = (
        np.polyfit(np.log(s), np.log(v), 1)[0] for v in (p.contact.pressure[near], exact.pressure(HALF_WIDTH - s))
    )
    assert slope == pytest.approx(expected, abs=0.03) and slope == pytest.approx(-0.5, abs=0.06)
    # sqrt(2 a s) p tends to P/pi: its value there.
    near_edge = np.sqrt(2 * HALF_WIDTH * s) * p.contact.pressure[near]
    np.testing.assert_allclose(near_edge, 2 * p.load / math.pi, rtol=0.06)


@pytest.mark.long_rows(where=lambda method, friction: (method, friction) != ("Lagrange", 20.0))
@pytest.mark.parametrize("friction", [0.0, 20.0], ids=["frictionless", "bonded"])
@pytest.mark.parametrize("method", ["Lagrange", "Penalty"])
def test_circular_punch(method, friction):
    """Load of a displacement, 1 %; the block of 200 a leaves an error of about 0.8 a/L, the mesh the rest."""
    far, depth = 200, 1e-6
    p = Punch(method, 2, "axisymmetric", 1e-4, far, friction, depth)
    exact = theory.circular_punch(depth, HALF_WIDTH, E, NU, "bonded" if friction else "frictionless")
    assert p.load == pytest.approx(exact.load, rel=0.01)
    if not friction:
        inside = p.distance > 0.2 * HALF_WIDTH
        expected = exact.pressure(HALF_WIDTH - p.distance[inside])
        np.testing.assert_allclose(p.contact.pressure[inside], expected, rtol=0.03)


TIP, ANGLE = 5e-3, math.radians(89)


def tip(method, degree, hypothesis, far=60):
    """A blunt wedge (axisymmetric: cone) 100 times stiffer than the block, pressed to a half-width of TIP.

    The block carries the points: where the flank leaves it, its facets are the finer ones. The tip starts
    inside, by a facet's width of contact, so that there is something for the load to act against.
    """
    laws = [di.LinearElastic(k * E, NU, hypothesis=hypothesis) for k in (1, 100)]
    law = dict(zip(("master_body", "slave_body"), laws))
    m = Model(
        "wedge",
        law,
        degree,
        angle=ANGLE,
        a=TIP,
        width=3 * TIP,
        block_width=far * TIP,
        block_height=far * TIP,
        gap=-1e-5,
    )
    m.hold("bottom")
    m.hold("symmetry_x", 0)
    m.hold("top", 0)
    if hypothesis == "axisymmetric":
        exact = theory.cone(ANGLE, E, NU, 100 * E, NU, a=TIP)
        load, area = exact.load, math.pi * (3 * TIP) ** 2
    else:
        exact = theory.wedge(ANGLE, E, NU, 100 * E, NU, half_width=TIP)
        load, area = exact.load_per_length / 2, 3 * TIP
    m.pull("top", (0.0, -load / area))
    problem = m.problem(enforce(method, m.pair("master_surface", "slave_surface")))
    report, contact = problem.solve(max_iterations=40), problem.contact[0]
    assert max(report.iterations) <= 30
    assert contact.force[1] == pytest.approx(-load, rel=1e-6)
    return m, contact, exact


@pytest.mark.covering(1)
@pytest.mark.parametrize("hypothesis", ["plane_strain", "axisymmetric"])
@pytest.mark.parametrize("method, degree", [("Lagrange", 1), ("Lagrange", 2), ("Penalty", 1), ("Penalty", 2)])
def test_wedge_and_cone(method, degree, hypothesis):
    """Pressure at 0.2 a ... 0.9 a: 3 % in the mean over cells of a/10, 5 % at each point; half-width to a cell."""
    m, contact, exact = tip(method, degree, hypothesis)
    x = m.places(contact)[:, 0]
    inside = (x > 0.2 * TIP) & (x < 0.9 * TIP)
    ratio = contact.pressure[inside] / exact.pressure(x[inside])
    np.testing.assert_allclose(ratio, 1.0, atol=0.05)
    bins = np.floor((x[inside] / TIP - 0.2) / 0.1 + 1e-9)
    means = [np.average(ratio[bins == b], weights=contact.weight[inside][bins == b]) for b in np.unique(bins)]
    np.testing.assert_allclose(means, 1.0, atol=0.03)
    assert x[contact.pressure > 0].max() == pytest.approx(TIP, abs=0.1 * TIP)
