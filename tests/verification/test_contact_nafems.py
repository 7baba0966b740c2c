# SPDX-License-Identifier: MIT
"""NAFEMS R0094: the cylinder roller (benchmark 1) and the rounded punch (benchmark 2)."""

import math

import numpy as np
import pytest
from contact_model import Model, assert_coulomb, enforce
from dolfinx import fem
from ufl import Measure

import dolfinx_impact as di
from dolfinx_impact import theory

STEEL, ALUMINIUM, NU = 210e3, 70e3, 0.3


def bodies(hypothesis):
    return {
        "slave_body": di.LinearElastic(STEEL, NU, hypothesis=hypothesis),
        "master_body": di.LinearElastic(ALUMINIUM, NU, hypothesis=hypothesis),
    }


def roller(method, degree, friction=0.0, steps=1):
    """Steel cylinder, radius 50, on an aluminium block, 200 x 200, pressed by 35 kN/mm at its top; half of it."""
    m = Model("cylinder_on_half_plane", bodies("plane_strain"), degree, radius=50.0, a=6.2, h=0.62, width=100.0,
              height=200.0, whole=True, coarse=12.0, gap=-1e-3)  # fmt: skip
    m.hold("bottom")
    m.hold("symmetry_x", 0)
    one = fem.Constant(m.mesh, 1.0) * Measure("ds", m.mesh, subdomain_data=m.facets)(m.tags["load"])
    # The load is spread over the uppermost quarter: far from the contact, it is the same (St. Venant).
    m.pull("load", (0.0, -17500.0 / fem.assemble_scalar(fem.form(one))))
    problem = m.problem(enforce(method, m.pair(friction=friction)))
    report = problem.solve(steps=steps, max_iterations=40)
    return m, problem.contact[0], report


@pytest.mark.long_rows(where=lambda method: method == "Penalty")
@pytest.mark.parametrize("method, degree", [("Lagrange", 1), ("Lagrange", 2), ("Penalty", 1)])
def test_cylinder_roller(method, degree):
    """Half-width within a cell, peak pressure 2 %, load exact, and the sinking of the block's top."""
    m, contact, report = roller(method, degree)
    exact = theory.hertz_line(35e3, 50.0, np.inf, STEEL, NU, ALUMINIUM, NU)
    assert exact.half_width == pytest.approx(6.21463, abs=1e-4) and exact.peak_pressure == pytest.approx(
        3585.36, abs=0.1
    )
    # Penalty finds its way from a single point in one search, or needs a smaller load first.
    assert report.cut_backs == 0 and max(report.iterations) <= (25 if method == "Lagrange" else 40)
    assert contact.force[1] == pytest.approx(17500.0, rel=1e-6)
    x = m.places(contact)[:, 0]
    assert x[contact.pressure > 0].max() == pytest.approx(exact.half_width, abs=0.62)
    inside = x < 0.8 * exact.half_width
    if method == "Lagrange":
        np.testing.assert_allclose(contact.pressure[inside], exact.pressure(x[inside]), rtol=0.02)
    else:  # single quadrature points scatter; means over cells do not
        nodes, p = contact.nodal(contact.pressure)
        x = m.V.tabulate_dof_coordinates()[nodes, 0]
        inside = x < 0.8 * exact.half_width
        np.testing.assert_allclose(p[inside, 0], exact.pressure(x[inside]), rtol=0.02)
    # Small strain with Hertz's pressure applied: -1.2807 mm.
    assert m.at((0.0, 0.0))[1] == pytest.approx(-1.2807, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["Lagrange", "Penalty"])
def test_cylinder_roller_with_friction(method):
    """Friction 0.1: the law holds, and the pressure grows by about a per cent."""
    m, contact, report = roller(method, 1, 0.1, steps=5)
    assert_coulomb(contact)
    assert contact.force[1] == pytest.approx(17500.0, rel=1e-6)
    assert contact.pressure.max() == pytest.approx(3585.36, rel=0.03 if method == "Lagrange" else 0.06)
    assert m.at((0.0, 0.0))[1] == pytest.approx(-1.2807, rel=0.015)


def rounded_punch(method, degree, friction=0.0):
    """Axisymmetric punch, radius 50 with a fillet of 10, on a block of radius 100, under 100 MPa."""
    m = Model("punch", bodies("axisymmetric"), degree, half_width=50.0, height=100.0, block_width=100.0,
              block_height=200.0, fillet=10.0, h=1.5, coarse=8.0)  # fmt: skip
    m.hold("bottom")
    m.hold("symmetry_x", 0)
    m.pull("top", (0.0, -100.0))
    problem = m.problem(enforce(method, m.pair(friction=friction)))
    report = problem.solve(steps=5 if friction else 1)
    contact = problem.contact[0]
    assert report.cut_backs == 0 and max(report.iterations) <= 15
    assert contact.force[1] == pytest.approx(100.0 * math.pi * 50.0**2, rel=1e-6)
    return m, contact


@pytest.mark.parametrize("method, degree", [("Lagrange", 1), ("Lagrange", 2), ("Penalty", 1)])
def test_rounded_punch(method, degree):
    """Sinking of the centre against -0.1340 of a fine mesh (published: -0.13073); contact to r = 40.4 mm."""
    m, contact = rounded_punch(method, degree)
    assert m.at((0.0, 0.0))[1] == pytest.approx(-0.1340, rel=0.01)
    r = m.places(contact)[:, 0]
    assert r[contact.pressure > 0].max() == pytest.approx(40.4, abs=1.5)
    # Pressure near the centre 87.3 MPa; the outermost tenth of the contact does not converge, and is left alone.
    assert np.interp(5.0, *_sorted(r, contact.pressure)) == pytest.approx(87.3, rel=0.03)


@pytest.mark.parametrize("method, degree", [("Lagrange", 1), ("Penalty", 1)])
def test_rounded_punch_with_friction(method, degree):
    """Friction 0.1: the centre sinks 2.15 um less (both sources), and sticks to r = 17 mm."""
    smooth, _ = rounded_punch(method, degree)
    m, contact = rounded_punch(method, degree, 0.1)
    assert_coulomb(contact)
    assert m.at((0.0, 0.0))[1] == pytest.approx(-0.1318, rel=0.01)
    assert m.at((0.0, 0.0))[1] - smooth.at((0.0, 0.0))[1] == pytest.approx(2.15e-3, rel=0.1)
    r = m.places(contact)[:, 0]
    # The edge of the stick zone is where the shear reaches a bound that it follows closely: two cells.
    assert r[contact.status == di.ContactStatus.stick].max() == pytest.approx(17.0, abs=4.0)


def _sorted(x, y):
    order = np.argsort(x)
    return x[order], y[order]
