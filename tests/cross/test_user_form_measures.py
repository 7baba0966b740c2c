# SPDX-License-Identifier: MIT
"""Forms of a user's own with integrals over dx and ds, and with moduli that are functions, against the hand-written
solver."""

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di


class Square:
    """Elasticity in plane strain and what acts on its sides; constants by the names of cross_check."""

    def __init__(self):
        self.mesh = mesh.create_unit_square(MPI.COMM_SELF, 2, 2, mesh.CellType.quadrilateral)
        self.V = fem.functionspace(self.mesh, ("Lagrange", 1, (2,)))
        self.u, self.v = fem.Function(self.V, name="u"), ufl.TestFunction(self.V)
        self.k, self.t = fem.Constant(self.mesh, 2.0), fem.Constant(self.mesh, np.array([1.0, 2.0]))
        self.ds, self.normal = ufl.ds(domain=self.mesh, degree=3), ufl.FacetNormal(self.mesh)

    def elastic(self, E, nu=0.3):
        strain = ufl.sym(ufl.grad(self.u))
        lmbda, mu = E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))
        stress = lmbda * ufl.tr(strain) * ufl.Identity(2) + 2 * mu * strain
        return ufl.inner(stress, ufl.grad(self.v)) * ufl.dx(degree=4)

    def springs(self, factor=1.0):
        return factor * self.k * ufl.dot(self.u, self.normal) * ufl.dot(self.normal, self.v) * self.ds


def passes(form, operator, **constants):
    report = di.verify.cross_check(form, operator=operator, constants=constants)
    assert report.rows
    return report.passed


def test_a_sum_over_cells_and_facets():
    """Each part against its own operator; an error in either is found."""
    s = Square()
    E, nu = fem.Constant(s.mesh, 2.0), fem.Constant(s.mesh, 0.3)
    given, both = {"E": E, "nu": nu, "k": s.k}, "elasticity + normal_foundation"
    assert passes(s.elastic(E, nu) + s.springs(), both, **given)
    assert not passes(s.elastic(E, nu) + s.springs(1.01), both, **given)
    assert not passes(1.01 * s.elastic(E, nu) + s.springs(), both, **given)
    assert not passes(s.elastic(E, nu) + s.springs(), "elasticity", **given)


def test_facets_alone():
    s = Square()
    assert passes(s.springs(), "normal_foundation", stiffness=s.k)
    assert passes(s.k * ufl.inner(s.u, s.v) * s.ds, "foundation", k=s.k)
    assert passes(ufl.inner(s.t, s.v) * s.ds, "traction", traction=s.t)
    assert not passes(1.01 * ufl.inner(s.t, s.v) * s.ds, "traction", traction=s.t)
    assert not passes(ufl.inner(s.u, s.v) * s.ds, "mass")


@pytest.mark.parametrize("name", (None, "modulus", "u"))
def test_a_modulus_by_cell(name):
    """A function that is constant in each cell, with a name of its own, that of the displacement, or none."""
    s = Square()
    E = fem.Function(fem.functionspace(s.mesh, ("DG", 0)), name=name)
    assert passes(s.elastic(E), "elasticity", E=E, nu=0.3)
    assert not passes(s.elastic(1.01 * E), "elasticity", E=E, nu=0.3)
    with pytest.raises(ValueError, match="constant in each cell, means nothing here.*constants="):
        passes(s.elastic(E), "elasticity", nu=0.3)


def test_numbers_in_the_place_of_constants():
    s = Square()
    assert passes(s.elastic(3.0), "elasticity", E=3.0, nu=0.3)
    with pytest.raises(ValueError, match="numbers in the place of constants: say which.*constants="):
        passes(s.elastic(3.0), "elasticity")


def test_forms_without_functions():
    """Volume and area: of the cells, of the facets, of both."""
    s = Square()
    for form, value in ((2.0 * ufl.dx(s.mesh), 2.0), (0.5 * s.ds, 2.0), (2.0 * ufl.dx(s.mesh) + 0.5 * s.ds, 4.0)):
        assert di.Energy(form).value() == pytest.approx(value, rel=1e-14)
