# SPDX-License-Identifier: MIT
"""Derivatives of energies become a stress times the gradient of the test function: as few operations as by hand."""

import pytest
import ufl
import user_forms

from dolfinx_impact import compat
from dolfinx_impact.forms.compiler import emit, frontend
from dolfinx_impact.forms.compiler.stress_form import by_test_gradient

DX = ufl.dx(metadata={"quadrature_degree": 2})


def setting(cell="hexahedron"):
    mesh = user_forms.mesh_of(cell)
    V = user_forms.space(mesh, shape=(compat.geometric_dimension(mesh),))
    return mesh, ufl.Coefficient(V), ufl.TestFunction(V)


def mooney_rivlin(F):
    C, J = F.T * F, ufl.det(F)
    second = (ufl.tr(C) ** 2 - ufl.tr(C * C)) / 2
    return J ** (-2 / 3) * ufl.tr(C) + J ** (-4 / 3) * second + (J - 1) ** 2


def fibres(F):
    stretch = F[0, 0] ** 2 + F[1, 0] ** 2 + F[2, 0] ** 2 - 1
    return ufl.tr(F.T * F) - ufl.ln(ufl.det(F)) + ufl.conditional(ufl.gt(stretch, 0), ufl.exp(stretch**2), 1.0)


def operations(form):
    (integral,) = frontend.form_integrals(form, "form", {})
    assert integral.num_points == 0 and integral.rank == 1
    return emit.flops(emit._tree(integral))


@pytest.mark.parametrize("energy", [mooney_rivlin, fibres])
def test_derivative_of_an_energy_costs_what_its_stress_does(energy):
    _, u, v = setting()
    F = ufl.variable(ufl.Identity(3) + ufl.grad(u))
    stress = ufl.diff(energy(F), F)
    derivative = operations(ufl.derivative(energy(F) * DX, u, v))
    assert derivative <= 1.02 * operations(ufl.inner(stress, ufl.grad(v)) * DX)


def test_rules_are_those_of_the_form_as_it_was_written():
    """Also where UFL estimates the degree, which a stress by itself would have another of."""
    _, u, v = setting("tetrahedron")
    energy = mooney_rivlin(ufl.Identity(3) + ufl.grad(u)) + ufl.dot(u, u) ** 2
    for dx in (DX, ufl.dx, ufl.dx(3, degree=4), ufl.dx((1, 2))):
        form = ufl.derivative(energy * dx, u, v) + ufl.dot(u, v) * ufl.ds
        (written, other) = frontend.form_integrals(form, "form", {})
        changed = by_test_gradient(form)
        assert changed is not form and changed.arguments() == form.arguments()
        data = [frontend.analyze_ufl_objects([f], "float64").form_data[0] for f in (form, changed)]
        found = [
            [
                (d.integral_type, d.subdomain_id, [i.metadata()["quadrature_degree"] for i in d.integrals])
                for d in one.integral_data
            ]
            for one in data
        ]
        assert found[0] == found[1]
        assert {written.integral_type, other.integral_type} == {"cell", "exterior_facet"}


def test_other_forms_stay_as_they_are():
    mesh, u, v = setting()
    w = ufl.TrialFunction(u.ufl_function_space())
    scalar = ufl.TestFunction(user_forms.space(mesh))
    energy = mooney_rivlin(ufl.Identity(3) + ufl.grad(u)) * DX
    force = ufl.derivative(energy, u, v)
    tangent = ufl.derivative(force, u, w)
    for form in (energy, tangent, ufl.dot(u, v) * DX, scalar * DX, ufl.inner(ufl.grad(u), ufl.grad(v)) * DX):
        assert by_test_gradient(form) is form


def test_second_derivatives_of_the_test_function_stay():
    mesh = user_forms.mesh_of("triangle")
    V = user_forms.space(mesh, degree=2)
    u, v = ufl.Coefficient(V), ufl.TestFunction(V)
    energy = ufl.tr(ufl.grad(ufl.grad(u))) ** 2 * DX
    form = ufl.derivative(energy, u, v)
    assert by_test_gradient(form) is form
