# SPDX-License-Identifier: MIT
"""A soft block pressed by a rigid cylinder to thirty per cent of its height: Newton's method stays quadratic."""

import numpy as np
import pytest
from contact_model import Model, assert_coulomb, enforce

import dolfinx_impact as di

HEIGHT, DEPTH = 1.0, 0.3


def pressed(method, degree, friction=0.0, num=24, steps=6):
    """Neo-Hookean block, 3 x 1, on a rough floor; cylinder of radius 1. Returns (model, problem, report)."""
    m = Model(
        "block", di.NeoHookean(1.0, 0.3, hypothesis="plane_strain"), degree, size=(3.0, HEIGHT), cells=(num, num // 3)
    )
    m.hold("bottom")
    cylinder = di.RigidCylinder((1.5, HEIGHT + 1.0), 1.0)
    problem = m.problem(enforce(method, m.pair("top", cylinder, friction=friction)))
    cylinder.displacement = (0.0, -DEPTH)
    return m, problem, problem.solve(steps=steps, rtol=1e-13)


def assert_quadratic(report):
    """Once the contact has settled, each residual is at most a constant times the square of the one before.

    Relative to the force on the block (0.5); the constant belongs to the law and the mesh, and is the same for
    every step: with linear convergence the ratios would grow without bound as the residual falls.
    """
    seen = 0
    for norms, changes in zip(report.residual_norms, report.contact_changes):
        # The first is of the new load; an iteration behind a change of the contact, or at round-off, says nothing.
        for a, b, changed in zip(norms[1:], norms[2:], changes[2:]):
            if changed == 0 and 1e-6 < a < 2e-3 and b > 1e-14:
                assert b <= 200 * a**2, norms
                seen += 1
    assert seen >= 3, report.residual_norms


@pytest.mark.parametrize("method, degree", [("Lagrange", 1), ("Lagrange", 2), ("Penalty", 1), ("Penalty", 2)])
def test_quadratic_convergence(method, degree):
    m, problem, report = pressed(method, degree)
    # Penalty of degree 2 comes to a load where points go to and fro between facets: it is searched, not cut.
    assert max(report.iterations) <= (9 if (method, degree) != ("Penalty", 2) else 15)
    assert_quadratic(report)
    contact = problem.contact[0]
    # The middle follows the cylinder, to the penetration of a penalty.
    assert m.at((1.5, HEIGHT))[1] == pytest.approx(-DEPTH, abs=1e-9 if method == "Lagrange" else 0.01)
    np.testing.assert_allclose(m.support(problem, "bottom"), -contact.force, rtol=0, atol=1e-10)
    assert abs(contact.force[0]) < 1e-9 * abs(contact.force[1])  # symmetric
    # Stiffer than the same block in small strain by Hertz would be, softer than confined: measured once on meshes of
    # 24 to 96 cells, 0.4867 to 0.490.
    assert contact.force[1] == pytest.approx(-0.489, rel=0.02)


@pytest.mark.parametrize("method", ["Lagrange", "Penalty"])
def test_with_friction(method):
    """The law holds at the end of a large sliding path, and friction makes the block stiffer."""
    _, problem, report = pressed(method, 1, friction=0.1, steps=10)
    contact = problem.contact[0]
    assert_coulomb(contact)
    assert np.any(contact.status == di.ContactStatus.stick) and np.any(contact.status == di.ContactStatus.slip)
    assert 0.49 < -contact.force[1] < 0.56
