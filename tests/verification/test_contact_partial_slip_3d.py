"""Cattaneo and Mindlin's sphere, pressed and pushed: shift, stick radius."""

import numpy as np
import pytest
from contact_model import Model, assert_coulomb, enforce

import dolfinx_impact as di
from dolfinx_impact import theory

RADIUS, A, G, NU, FRICTION = 50.0, 1.0, 200.0, 0.42, 0.4


@pytest.mark.slow
def test_cattaneo_mindlin_sphere():
    """Two loads Q, one after the other, on 13,000 nodes: shift 3 %, of which the bounds at 12 a take a part.

    The stick radius is that of the sticking area; to half a cell.
    """
    E, h, size = 2 * G * (1 + NU), 0.2 * A, 12 * A
    grid = dict(radius=RADIUS, a=A, h=h, core=1.3 * A, width=size, height=size, symmetry="half", coarse=size)
    m = Model("sphere_on_half_space", di.LinearElastic(E, NU), **grid)
    m.hold("bottom")
    m.hold("symmetry_y", 1)
    down, along = m.hold("top", 2), m.hold("top", 0)
    m.hold("top", 1)
    problem = m.problem(enforce("Penalty", m.pair(friction=FRICTION)))
    contact = problem.contact[0]
    down.value = -0.02
    problem.solve(max_iterations=40)
    for shift in (0.004, 0.007):
        along.value = shift
        report = problem.solve()
        assert report.cut_backs == 0 and max(report.iterations) <= 15
        assert_coulomb(contact)
        P, Q = 2 * contact.force[2], -2 * contact.force[0]  # half of the bodies
        exact = theory.cattaneo_mindlin(P, Q, FRICTION, RADIUS, np.inf, E, NU, E, NU)
        assert shift == pytest.approx(exact.shift, rel=0.03)
        area = 2 * contact.weight[contact.status == di.ContactStatus.stick].sum()
        assert np.sqrt(area / np.pi) == pytest.approx(exact.stick_radius, abs=h / 2)
