# SPDX-License-Identifier: MIT
"""Which part of a body's assembly takes which load, and that all parts together are the work of all loads."""

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.statics.load_forms import LoadForms, load_forms


class Square:
    """Unit square of two cells along each side, with a displacement."""

    def __init__(self):
        self.mesh = mesh.create_unit_square(MPI.COMM_SELF, 2, 2)
        self.u = fem.Function(fem.functionspace(self.mesh, ("Lagrange", 1, (2,))), name="u")
        self.u.interpolate(lambda x: 0.01 * np.array([np.sin(x[0] + x[1]), x[0] * x[1]]))
        facets = mesh.locate_entities_boundary(self.mesh, 1, lambda x: np.isclose(x[1], 1.0))
        self.tags = mesh.meshtags(self.mesh, 1, np.sort(facets), np.full(len(facets), 1, dtype=np.int32))
        self.material = di.LinearElastic(10.0, 0.3, 2.0, "plane_strain")
        self.x = ufl.SpatialCoordinate(self.mesh)

    def load(self, name):
        return {
            "traction": lambda: di.Traction(self.tags, 1, (1.0, 2.0)),
            "gravity": lambda: di.BodyForce((0.0, -9.81)),
            "foundation": lambda: di.Foundation(self.tags, 1, stiffness=5.0),
            "pressure": lambda: di.FollowerPressure(self.tags, 1, 3.0),
            "varying traction": lambda: di.Traction(self.tags, 1, self.x[0] * ufl.as_vector((1.0, 2.0))),
            "varying foundation": lambda: di.Foundation(self.tags, 1, stiffness=1.0 + self.x[0]),
            "mass": lambda: di.AddedMass(self.tags, 1, mass=2.0),
        }[name]()


# Numbers of dead loads and of springs, whether there is another form, whether springs may hold the bodies.
PLACES = {
    "traction": (1, 0, False, False),
    "gravity": (1, 0, False, False),
    "foundation": (0, 1, False, True),
    "pressure": (0, 0, True, False),
    "varying traction": (0, 0, True, False),
    "varying foundation": (0, 0, True, True),
    "mass": (0, 0, False, False),
}


@pytest.mark.parametrize("name", PLACES)
def test_each_load_has_its_place(name):
    s = Square()
    forms = load_forms(s.u, s.material, [s.load(name)])
    place = len(forms.dead), len(forms.springs), forms.other is not None, forms.has_springs
    assert place == PLACES[name] and len(forms.spring_tangents) == len(forms.springs)
    assert (forms.work() is None) == (name == "mass")


def test_the_work_is_that_of_all_loads():
    s = Square()
    loads = [s.load(name) for name in PLACES if name != "mass"]
    v = ufl.TestFunction(s.u.function_space)
    whole = fem.assemble_vector(fem.form(load_forms(s.u, s.material, loads).work())).array
    parts = sum(fem.assemble_vector(fem.form(load.form(s.u, v, s.material))).array for load in loads)
    np.testing.assert_allclose(whole, parts, rtol=1e-13, atol=1e-15)


def test_a_load_of_ones_own_needs_a_form_alone():
    class Own:
        def form(self, u, v, material):
            return ufl.inner(ufl.as_vector((1.0, 2.0)), v) * ufl.dx

    s = Square()
    forms = load_forms(s.u, s.material, [Own()])
    assert not forms.dead and forms.other == Own().form(s.u, ufl.TestFunction(s.u.function_space), s.material)


def test_no_loads():
    assert load_forms(Square().u, None, []) == LoadForms() and LoadForms().work() is None


@pytest.mark.parametrize("name", [name for name in PLACES if name != "mass"])
def test_a_body_under_each_load_is_in_equilibrium_with_it(name):
    """Residual and tangent of the body, by kernels or by FFCx: those of the internal minus the external work, to
    round-off of sums of numbers up to 30."""
    s = Square()
    load = s.load(name)
    V = s.u.function_space
    v, du = ufl.TestFunction(V), ufl.TrialFunction(V)
    problem = di.StaticProblem(s.u, s.material, loads=[load])
    residual = di.operators.internal_force_form(s.u, v, s.material) - load.form(s.u, v, s.material)
    found = problem.body.in_cpp()
    theirs = fem.assemble_vector(fem.form(residual)).array
    np.testing.assert_allclose(found.residual().array, theirs, atol=1e-13)
    rows, columns, values = found.tangent().getValuesCSR()
    dense = np.zeros((len(theirs), len(theirs)))
    for i in range(len(theirs)):
        dense[i, columns[rows[i] : rows[i + 1]]] = values[rows[i] : rows[i + 1]]
    expected = fem.assemble_matrix(fem.form(ufl.derivative(residual, s.u, du))).to_dense()
    np.testing.assert_allclose(dense, expected, atol=1e-13)
