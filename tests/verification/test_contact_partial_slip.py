# SPDX-License-Identifier: MIT
"""Bodies that partly stick: Cattaneo and Mindlin in the plane."""

import math

import numpy as np
import pytest
from contact_model import Model, assert_coulomb, enforce, plane_approach

import dolfinx_impact as di
from dolfinx_impact import theory

E, NU, RADIUS, HALF_WIDTH, FRICTION = 210e9, 0.3, 1.0, 0.01, 0.3


def pressed(method, degree, h, size):
    """A cylinder pressed on a block of its material, both of a size, h the cells in the contact: model, contact,
    problem, its displacement along the block, which is zero so far, and the approach."""
    law = di.LinearElastic(E, NU, hypothesis="plane_strain")
    grid = dict(radius=RADIUS, a=HALF_WIDTH, h=h, width=size, height=size, symmetry="none")
    m = Model("cylinder_on_half_plane", law, degree, **grid)
    m.hold("bottom")
    down, along = m.hold("top", 1), m.hold("top", 0)
    problem = m.problem(enforce(method, m.pair(friction=FRICTION)))
    load = HALF_WIDTH**2 * math.pi * E / (1 - NU**2) / (8 * RADIUS)
    approach = 2 * plane_approach(load, E / (1 - NU**2), RADIUS, HALF_WIDTH)
    down.value = -approach
    problem.solve(max_iterations=40)
    return m, problem.contact[0], problem, along, approach


@pytest.mark.parametrize(
    "method, degree, h",
    [
        ("Lagrange", 1, 1e-3),
        pytest.param("Penalty", 1, 1e-3, marks=pytest.mark.slow),
        pytest.param("Penalty", 1, 5e-4, marks=pytest.mark.slow),
        pytest.param("Lagrange", 1, 5e-4, marks=pytest.mark.slow),
        pytest.param("Lagrange", 2, 1e-3, marks=pytest.mark.slow),
    ],
)
def test_cattaneo_mindlin_line(method, degree, h):
    """A cylinder pressed on a block of its material, then pushed along it; three loads Q, one after the other.

    Stick half-width to a cell; traction: 2 % of its bound where the exact one is smooth: more than 1.5 cells from
    the edges of stick and contact, where its slope is infinite. (Penalty: nodal means; it slips elastically.)
    """
    m, contact, problem, along, approach = pressed(method, degree, h, 100 * HALF_WIDTH)
    for part in (0.25, 0.5, 0.9):
        along.value = part * FRICTION * approach
        report = problem.solve()
        assert report.cut_backs == 0 and max(report.iterations) <= 12
        assert_coulomb(contact)
        P, Q = contact.force[1], -contact.force[0]
        exact = theory.cattaneo_mindlin_line(P, Q, FRICTION, RADIUS, np.inf, E, NU, E, NU)
        a, c, bound = exact.contact.half_width, exact.stick_half_width, FRICTION * exact.contact.peak_pressure
        assert 0.15 < Q / (FRICTION * P) < 0.75
        x = m.places(contact)[:, 0]
        stick = x[contact.status == di.ContactStatus.stick]
        # Between the last point that sticks and the first that slips lies a cell at most.
        assert abs(stick.max() - c) < 1.2 * h and abs(stick.min() + c) < 1.2 * h
        t = contact.traction[:, 0]
        if method == "Penalty":
            nodes, t = contact.nodal(t)
            x, t = m.V.tabulate_dof_coordinates()[nodes, 0], t[:, 0]
        # The load moves the middle of the contact a little: the half disc is no half-plane.
        middle = np.sum(contact.weight * contact.pressure * m.places(contact)[:, 0]) / np.sum(
            contact.weight * contact.pressure
        )
        x = x - middle
        smooth = (np.abs(np.abs(x) - c) > 1.5 * h) & (np.abs(np.abs(x) - a) > 1.5 * h)
        error = np.abs(t + exact.traction(x))[smooth].max() / bound
        assert error < (0.02 if method == "Lagrange" else 0.05)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["Lagrange", "Penalty"])
def test_unloading_leaves_tractions_of_both_signs(method):
    """Pushed and let back to Q = 0: the traction that is left, is Cattaneo's full one less twice that of half the way.

    q = q(Q) - 2 q(Q/2) (Mindlin and Deresiewicz 1953): it changes sign inside the contact, its sum is zero.
    """
    h = 5e-4
    m, contact, problem, along, approach = pressed(method, 1, h, 60 * HALF_WIDTH)
    along.value = 0.9 * FRICTION * approach
    problem.solve()
    first, P = -contact.force[0], contact.force[1]
    values, forces = [along.value.item()], [first]
    along.value = 0.0
    problem.solve(steps=2)
    assert_coulomb(contact)
    values, forces = values + [0.0], forces + [-contact.force[0]]
    # A secant to Q = 0.
    along.value = np.interp(0.0, forces[::-1], values[::-1])
    problem.solve()
    last = -contact.force[0]
    assert abs(last) < 0.1 * first
    up, back = (
        theory.cattaneo_mindlin_line(P, Q, FRICTION, RADIUS, np.inf, E, NU, E, NU) for Q in (first, (first - last) / 2)
    )
    x, t = m.places(contact)[:, 0], contact.traction[:, 0]
    if method == "Penalty":
        nodes, t = contact.nodal(t)
        x, t = m.V.tabulate_dof_coordinates()[nodes, 0], t[:, 0]
    exact = -(up.traction(x) - 2 * back.traction(x))
    edges = [up.stick_half_width, back.stick_half_width, up.contact.half_width]
    smooth = np.all([np.abs(np.abs(x) - e) > 2 * h for e in edges], axis=0)
    error = np.abs(t - exact)[smooth].max() / (FRICTION * up.contact.peak_pressure)
    assert error < 0.03
