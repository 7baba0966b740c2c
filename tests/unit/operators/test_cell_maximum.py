# SPDX-License-Identifier: MIT
"""cell_max in kernels against NumPy's maximum over the points of each cell."""

import numpy as np
import operator_checks
import point_law_models as models
import pytest
import ufl
from dolfinx import fem
from mpi4py import MPI

from dolfinx_impact.assembly.jit import compile_form
from dolfinx_impact.assembly.operators import Energy, InternalForce
from dolfinx_impact.forms.cell_maximum import cell_max
from dolfinx_impact.forms.point_law import PointLaw

TOLERANCE = 1e-12  # both sides sum the same terms in another order
CELLS = ("hexahedron", "quadrilateral", "tetrahedron", "triangle")


def setting(cell):
    domain = operator_checks.body(cell, comm=MPI.COMM_SELF)
    u = operator_checks.displacement(domain, 1)
    return u, ufl.TestFunction(u.function_space), models.measure(domain)


def maximum(expression, u):
    """Function that is constant in each cell: NumPy's maximum over the points of the rule."""
    domain = u.function_space.mesh
    _, _, Q = models.symbols(domain)
    points = Q.ufl_element().custom_quadrature()[0]
    cells = np.arange(domain.topology.index_map(domain.topology.dim).size_local, dtype=np.int32)
    values = fem.Expression(expression, points).eval(domain, cells)
    f = fem.Function(fem.functionspace(domain, ("DG", 0)))
    f.x.array[f.function_space.dofmap.list[cells, 0]] = values.max(axis=1)
    assert np.ptp(values, axis=1).max() > 1e-6  # points differ
    return f


def difference(a, b):
    return np.max(np.abs(a - b)) / np.max(np.abs(b))


@pytest.mark.parametrize("width", (1, 4, 8))
@pytest.mark.parametrize("cell", CELLS)
def test_maximum_of_values(cell, width):
    """Of a scalar of either sign, and of a vector by components."""
    u, v, dx = setting(cell)
    a = u[0] + 0.1 * ufl.SpatialCoordinate(u.function_space.mesh)[1]
    for e in (a, a - 10.0):
        form = cell_max(e) * ufl.div(v) * dx
        expected = fem.assemble_vector(fem.form(maximum(e, u) * ufl.div(v) * dx)).array
        assert difference(InternalForce(form, width=width).apply().array, expected) < TOLERANCE
    vector = ufl.as_vector([maximum(u[i], u) for i in range(len(u))])
    expected = fem.assemble_vector(fem.form(ufl.inner(vector, v) * dx)).array
    assert difference(InternalForce(ufl.inner(cell_max(u), v) * dx, width=width).apply().array, expected) < TOLERANCE


def test_maximum_and_average_of_the_same_expression():
    u, v, dx = setting("hexahedron")
    a = u[0] * u[1]
    form = (cell_max(a) - ufl.cell_avg(a)) * v[0] * dx
    space = fem.functionspace(u.function_space.mesh, ("DG", 0))
    mean, t = fem.Function(space), ufl.TestFunction(space)
    mean.x.array[:] = fem.assemble_vector(fem.form(a * t * dx)).array / fem.assemble_vector(fem.form(t * dx)).array
    expected = fem.assemble_vector(fem.form((maximum(a, u) - mean) * v[0] * dx)).array
    assert difference(InternalForce(form).apply().array, expected) < TOLERANCE
    inner = maximum(a - mean, u)
    expected = fem.assemble_vector(fem.form(inner * v[0] * dx)).array
    form = cell_max(a - ufl.cell_avg(a)) * v[0] * dx
    assert difference(InternalForce(form).apply().array, expected) < TOLERANCE


def test_maximum_in_a_law_and_of_its_solution():
    """x * x = cell_max(a) a; the history has the maximum of x, the force that of x a."""
    u, _, dx = setting("quadrilateral")
    domain = u.function_space.mesh
    _, _, Q = models.symbols(domain)
    x = ufl.Coefficient(Q)
    w = ufl.TestFunction(fem.functionspace(domain, ("Lagrange", 1)))
    a = 1 + ufl.inner(u, u)
    law = PointLaw({"largest": cell_max(x)}, {}, x, x * x - cell_max(a) * a, a, 1.0)
    force = InternalForce(cell_max(x * a) * w * dx, law=law)
    root = ufl.sqrt(maximum(a, u) * a)
    expected = fem.assemble_vector(fem.form(maximum(root * a, u) * w * dx)).array
    assert difference(force.apply().array, expected) < TOLERANCE
    largest = np.asarray(force.history.values("largest", True))
    largest = largest.reshape(len(largest), -1)
    assert np.ptp(largest, axis=1).max() == 0.0
    assert difference(np.sort(largest[:, 0]), np.sort(maximum(root, u).x.array)) < TOLERANCE
    assert force.fault() == ""


def test_a_derivative_by_something_else_is_that_of_a_constant():
    """d/du of cell_max(f) u:u, where f does not depend on u."""
    u, v, dx = setting("hexahedron")
    f = fem.Function(u.function_space, name="f")
    f.x.array[:] = np.cos(np.arange(f.x.array.size))
    energy = cell_max(f[0]) * ufl.inner(u, u) * dx
    expected = fem.assemble_vector(fem.form(2 * maximum(f[0], u) * ufl.inner(u, v) * dx)).array
    assert difference(InternalForce(ufl.derivative(energy, u, v)).apply().array, expected) < TOLERANCE
    value = fem.assemble_scalar(fem.form(maximum(f[0], u) * ufl.inner(u, u) * dx))
    assert abs(Energy(energy).value() / value - 1.0) < TOLERANCE


def test_what_is_not_supported_says_so():
    u, v, dx = setting("hexahedron")
    domain = u.function_space.mesh
    i, du = ufl.Index(), ufl.TrialFunction(u.function_space)
    _, _, Q = models.symbols(domain)
    x = ufl.Coefficient(Q)
    for form, words in (
        (cell_max(ufl.div(u)) * ufl.dot(u, v) * ufl.ds(domain), "cell_max.*over cells"),
        (cell_max(ufl.div(v)) * dx, "not linear"),
        (cell_max(u[i]) * v[i] * dx, "free indices"),
        (ufl.derivative(cell_max(ufl.inner(u, u)) * dx, u, v), "has no derivative"),
    ):
        with pytest.raises(ValueError, match=words):
            InternalForce(form)
    with pytest.raises(ValueError, match="rank 0 and 1"):
        compile_form(cell_max(ufl.div(u)) * ufl.div(v) * ufl.div(du) * dx)
    law = PointLaw({"x": x}, {}, x, x * x - cell_max(x), ufl.as_ufl(1.0) + u[0], 1.0)
    with pytest.raises(ValueError, match="has no derivative"):
        InternalForce(x * v[0] * dx, law=law)
