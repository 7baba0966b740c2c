# SPDX-License-Identifier: MIT
"""Quadrature rules that UFL estimates, stated: what is derived from a form has the form's rules."""

import basix.ufl
import numpy as np
import pytest
import ufl
from ffcx.analysis import analyze_ufl_objects
from ufl.algorithms import expand_derivatives

from dolfinx_impact.forms.quadrature import with_rules

MESH = ufl.Mesh(basix.ufl.element("Lagrange", "hexahedron", 1, shape=(3,)))
V = ufl.FunctionSpace(MESH, basix.ufl.element("Lagrange", "hexahedron", 1, shape=(3,)))
U, TEST, TRIAL = ufl.Coefficient(V), ufl.TestFunction(V), ufl.TrialFunction(V)


def degrees(form):
    """Degree of each rule by kind and tags of the integral, as FFCx finds it."""
    (analysis,) = analyze_ufl_objects([form], np.dtype("float64")).form_data
    found = {}
    for data in analysis.integral_data:
        for integral in data.integrals:
            found.setdefault((data.integral_type, data.subdomain_id), set()).add(
                int(integral.metadata()["quadrature_degree"])
            )
    return found


@pytest.mark.parametrize("geometry_degree", (1, 2))
@pytest.mark.parametrize("cell", ("triangle", "quadrilateral", "tetrahedron", "hexahedron"))
def test_stated_degrees_are_those_of_ffcx(cell, geometry_degree):
    """Over cells and both kinds of facets, whose size has a degree of its own on cells that are not affine."""
    dim = 2 if cell in ("triangle", "quadrilateral") else 3
    mesh = ufl.Mesh(basix.ufl.element("Lagrange", cell, geometry_degree, shape=(dim,)))
    space = ufl.FunctionSpace(mesh, basix.ufl.element("Lagrange", cell, 1, shape=(dim,)))
    u, v = ufl.Coefficient(space), ufl.TestFunction(space)
    form = ufl.inner(u, v) * ufl.dx + ufl.inner(ufl.exp(u[0]) * u, v) * ufl.ds
    form += ufl.inner(ufl.jump(u), ufl.jump(v)) * ufl.dS
    assert degrees(with_rules(form)) == degrees(form)


@pytest.mark.parametrize("dx", [ufl.dx, ufl.dx(2), ufl.dx((1, 3)), ufl.dx(degree=3)], ids=repr)
def test_derivatives_have_the_rules_of_their_form(dx):
    J = ufl.det(ufl.Identity(3) + ufl.grad(U))
    residual = ufl.derivative(J ** (-2 / 3) * dx, U, TEST) + ufl.dot(U, U) * ufl.dot(U, TEST) * ufl.ds(4)
    residual -= ufl.dot(U, TEST) * dx
    stated = with_rules(residual)
    assert degrees(stated) == degrees(residual)
    tangent = expand_derivatives(ufl.derivative(stated, U, TRIAL))
    assert degrees(tangent) == degrees(residual)
    assert stated.arguments() == residual.arguments() and stated.coefficients() == residual.coefficients()
    if "degree" not in dx.metadata() and dx.metadata().get("quadrature_degree", -1) < 0:
        # Without it, another rule of many more points.
        assert degrees(expand_derivatives(ufl.derivative(residual, U, TRIAL))) != degrees(residual)


def test_tags_stay_with_their_integrals():
    """A load on ds(2) is over the facets that its tags say, beside integrals without tags."""
    tags = object()
    ds = ufl.Measure("ds", domain=MESH, subdomain_data=tags)
    residual = ufl.dot(U, TEST) * ufl.dx + ufl.dot(U, U) * ufl.dot(U, TEST) * ds(2) + ufl.dot(U, TEST) * ds
    for form in (with_rules(residual), expand_derivatives(ufl.derivative(with_rules(residual), U, TRIAL))):
        data = form.subdomain_data()[MESH]
        assert {id(t) for t in data["exterior_facet"]} == {id(tags)}
        assert all(t is None for t in data.get("cell", []))
