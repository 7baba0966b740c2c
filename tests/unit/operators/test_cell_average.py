# SPDX-License-Identifier: MIT
"""ufl.cell_avg in kernels against projections on constants per cell, assembled by DOLFINx with the same rule: of
values, of the test function, inside a point law, and of what depends on the solution of its local equations."""

import numpy as np
import operator_checks
import point_law_models as models
import pytest
import ufl
from dolfinx import fem
from mpi4py import MPI

from dolfinx_impact.assembly.jit import compile_form
from dolfinx_impact.assembly.operators import Energy, InternalForce
from dolfinx_impact.forms.point_law import PointLaw

# As in test_point_law: both sides sum the same terms in another order.
TOLERANCE = 1e-12
CELLS = ("hexahedron", "quadrilateral", "tetrahedron")


def _average(expression, u, dx):
    """Function that is constant in each cell: the projection of an expression with the rule of dx."""
    space = fem.functionspace(u.function_space.mesh, ("DG", 0))
    t = ufl.TestFunction(space)
    f = fem.Function(space)
    f.x.array[:] = fem.assemble_vector(fem.form(expression * t * dx)).array
    f.x.array[:] /= fem.assemble_vector(fem.form(t * dx)).array
    return f


def _setting(cell):
    domain = operator_checks.body(cell, comm=MPI.COMM_SELF)
    u = operator_checks.displacement(domain, 1)
    return u, ufl.TestFunction(u.function_space), models.measure(domain)


def _bar(w, average):
    """Strain with the volumetric part averaged over the cell (B-bar; Hughes 1987, 4.5.2)."""
    eps = models.strain(w)
    return ufl.dev(eps) + average(ufl.tr(eps)) / 3 * ufl.Identity(3)


def _stress(eps):
    """Not linear, so that its average is none of the strain's."""
    volume = models.BULK * ufl.tr(eps) + 1e5 * ufl.inner(eps, eps)
    return 2 * models.SHEAR * ufl.dev(eps) + volume * ufl.Identity(3)


def _difference(a, b):
    return np.max(np.abs(a - b)) / np.max(np.abs(b))


@pytest.mark.parametrize("width", (1, 4, 8))
@pytest.mark.parametrize("cell", CELLS)
def test_averages_of_values_and_of_the_test_function(cell, width):
    u, v, dx = _setting(cell)
    form = ufl.inner(_stress(_bar(u, ufl.cell_avg)), _bar(v, ufl.cell_avg)) * dx
    stress = _stress(_bar(u, lambda e: _average(e, u, dx)))
    pressure = _average(ufl.tr(stress) / 3, u, dx)
    eps = models.strain(v)
    expected = fem.assemble_vector(fem.form((ufl.inner(ufl.dev(stress), eps) + pressure * ufl.tr(eps)) * dx)).array
    assert _difference(InternalForce(form, width=width).apply().array, expected) < TOLERANCE
    plain = fem.assemble_vector(fem.form(ufl.inner(_stress(models.strain(u)), eps) * dx)).array
    if cell != "tetrahedron":  # constant strain has no other average
        assert _difference(plain, expected) > 1e-3


def test_the_derivative_of_an_averaged_energy_is_its_force():
    u, v, dx = _setting("hexahedron")
    eps = _bar(u, ufl.cell_avg)
    energy = (models.SHEAR * ufl.inner(ufl.dev(eps), ufl.dev(eps)) + models.BULK / 2 * ufl.tr(eps) ** 2) * dx
    force = InternalForce(ufl.derivative(energy, u, v)).apply().array.copy()
    value = Energy(energy)
    direction = np.cos(np.arange(force.size))
    start = u.x.array.copy()
    values = []
    for sign in (1, -1):
        u.x.array[:] = start + sign * 1e-2 * direction
        values.append(value.value())
    # The energy is quadratic: the central difference is exact to round-off of the values, 1e-16 / 1e-2 of them.
    assert abs((values[0] - values[1]) / 2e-2 - force @ direction) < 1e-12 * max(values) / 1e-2


@pytest.mark.parametrize("cell", CELLS[:2])
@pytest.mark.parametrize("average_stress", (False, True))
def test_plasticity_with_averaged_volume(cell, average_stress, rng):
    """Deviatoric return mapping is not touched by the average: history as without; the pressure is that of the average.

    With `average_stress` the test function is averaged, too, and the kernel needs the stresses of all points before it
    computes the force.
    """
    u, v, dx = _setting(cell)
    plain = models.voce(u)
    reference = models.Reference(u, models.HARDENING[models.voce])
    deviatoric = plain.deviatoric
    stress = deviatoric + models.BULK * ufl.cell_avg(ufl.tr(models.strain(u))) * ufl.Identity(3)
    test = _bar(v, ufl.cell_avg) if average_stress else models.strain(v)
    force = InternalForce(ufl.inner(stress, test) * dx, law=plain.law)
    for size in (3e-3, 2e-3):
        u.x.array[:] = size * rng.standard_normal(u.x.array.size)
        _, plastic, p = reference.evaluate()
        theta = _average(ufl.tr(models.strain(u)), u, dx)
        eps = models.strain(v)
        form = (ufl.inner(ufl.dev(reference.stress), eps) + models.BULK * theta * ufl.tr(eps)) * dx
        assert _difference(force.apply().array, fem.assemble_vector(fem.form(form)).array) < TOLERANCE
        assert np.max(np.abs(force.history.values("plastic_strain", True) - plastic)) < TOLERANCE
        assert np.max(np.abs(force.history.values("p", True) - p)) < TOLERANCE
        force.history.commit()
        reference.commit()


def test_averages_inside_local_equations_and_of_their_solution():
    """x * x = cell_avg(a); the force has the average of x times a: three loops over the points."""
    u, _, dx = _setting("hexahedron")
    domain = u.function_space.mesh
    _, _, Q = models.symbols(domain)
    x = ufl.Coefficient(Q)
    w = ufl.TestFunction(fem.functionspace(domain, ("Lagrange", 1)))
    a = 1 + ufl.inner(u, u)
    law = PointLaw({"root": x}, {}, x, x * x - ufl.cell_avg(a) * a, a, 1.0)
    force = InternalForce(ufl.cell_avg(x * a) * w * dx, law=law)
    root = ufl.sqrt(_average(a, u, dx) * a)
    expected = fem.assemble_vector(fem.form(_average(root * a, u, dx) * w * dx)).array
    assert _difference(force.apply().array, expected) < TOLERANCE
    assert force.fault() == ""


def test_what_is_not_supported_says_so():
    u, v, dx = _setting("hexahedron")
    du = ufl.TrialFunction(u.function_space)
    i = ufl.Index()
    for form, words in (
        (ufl.cell_avg(ufl.div(u)) * ufl.dot(u, v) * ufl.ds(u.function_space.mesh), "over cells"),
        (ufl.cell_avg(ufl.cell_avg(ufl.div(v)) * u[0]) * dx, "average of the test function"),
        (ufl.cell_avg(u[i]) * v[i] * dx, "free indices"),
    ):
        with pytest.raises(ValueError, match=words):
            InternalForce(form)
    with pytest.raises(ValueError, match="rank 0 and 1"):
        compile_form(ufl.cell_avg(ufl.div(du)) * ufl.div(v) * dx)
