# SPDX-License-Identifier: MIT
"""Two materials: Goodman's contact without slip."""

import math

import numpy as np
import pytest
from contact_model import Model, enforce, plane_approach

import dolfinx_impact as di
from dolfinx_impact import theory

RADIUS, HALF_WIDTH = 1.0, 0.01
SOFT, STIFF = (2 * 23e9 * 1.31, 0.31), (2 * 82e9 * 1.28, 0.28)  # E from the shear moduli of aluminium and steel


def press(method, soft_above, h, steps):
    """Bodies pressed together without slip in equal steps of the contact's width: problem's model, contact, theory."""
    upper, lower = (SOFT, STIFF) if soft_above else (STIFF, SOFT)
    law = {
        "slave_body": di.LinearElastic(*upper, hypothesis="plane_strain"),
        "master_body": di.LinearElastic(*lower, hypothesis="plane_strain"),
    }
    size = 60 * HALF_WIDTH
    m = Model("cylinder_on_half_plane", law, 1, radius=RADIUS, a=HALF_WIDTH, h=h, width=size, height=size)
    m.hold("bottom")
    m.hold("symmetry_x", 0)
    m.hold("top", 0)
    down = m.hold("top", 1)
    problem = m.problem(enforce(method, m.pair(friction=5.0)))
    contact = problem.contact[0]
    moduli = [e / (1 - nu**2) for e, nu in (upper, lower)]
    load = HALF_WIDTH**2 * math.pi / sum(1 / k for k in moduli) / (4 * RADIUS)
    approach = sum(plane_approach(load, k, RADIUS, HALF_WIDTH) for k in moduli)
    for k in range(1, steps + 1):
        down.value = -approach * (k / steps) ** 2
        problem.solve()
    exact = theory.bonded_indentation(2 * contact.force[1], RADIUS, np.inf, *upper, *lower)
    assert abs(exact.beta) == pytest.approx(0.14383, abs=1e-5)
    return m, contact, exact


@pytest.mark.slow
@pytest.mark.parametrize("soft_above", [True, False])
def test_goodman_by_penalty(soft_above):
    """Shear traction on |x| < 0.8 a: 5 % of its largest at every node, 2 % in the mean; pressure 3 %. 20 steps.

    The traction of a point is that of the slip its neighbours had since it touched: it is a matter of history.
    Means around each node, of the tractions and of the exact ones: points on a facet that is a chord of the circle
    penetrate by different amounts, and what they count of the step in which they close differs as much.
    """
    _, contact, exact = press("Penalty", soft_above, 5e-4, 20)
    x, t, p = contact.points[:, 0], contact.traction[:, 0], contact.pressure
    _, means = contact.nodal(np.column_stack([x, t - exact.shear(x), p - exact.pressure(x)]))
    x, shear, pressure = means[np.abs(means[:, 0]) < 0.8 * exact.half_width].T
    assert len(x) == 16  # a node every 0.05 a
    assert not np.any(contact.status == di.ContactStatus.slip)
    assert np.abs(shear).max() < 0.05 * exact.peak_shear
    assert np.sqrt(np.mean(shear**2)) < 0.02 * exact.peak_shear
    assert np.all(np.abs(pressure) < 0.03 * exact.pressure(x))


@pytest.mark.long_rows(where=lambda soft_above: soft_above)
@pytest.mark.parametrize("soft_above", [True, False])
def test_goodman_by_multipliers(soft_above):
    """Shear traction on |x| < 0.8 a: 3 % of its largest at every node, 1.5 % in the mean; pressure 3 %. 20 steps."""
    m, contact, exact = press("Lagrange", soft_above, 5e-4, 20)
    x, t = m.places(contact)[:, 0], contact.traction[:, 0]
    inside = np.abs(x) < 0.8 * exact.half_width
    assert not np.any(contact.status == di.ContactStatus.slip)
    error = (t - exact.shear(x))[inside] / exact.peak_shear
    assert np.abs(error).max() < 0.03 and np.sqrt(np.mean(error**2)) < 0.015
    np.testing.assert_allclose(contact.pressure[inside], exact.pressure(x[inside]), rtol=0.03)
