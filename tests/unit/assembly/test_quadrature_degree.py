# SPDX-License-Identifier: MIT
"""A plain dx whose estimated degree is needlessly high is warned of; compilations that take long are announced."""

import warnings

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.assembly import jit


class Rubber:
    """One cube of a nearly incompressible law, J**(-2/3), or of a linear one."""

    def __init__(self, kind=mesh.CellType.hexahedron):
        self.mesh = mesh.create_unit_cube(MPI.COMM_SELF, 1, 1, 1, kind)
        self.V = fem.functionspace(self.mesh, ("Lagrange", 1, (3,)))
        self.u, self.v = fem.Function(self.V, name="u"), ufl.TestFunction(self.V)

    def residual(self, linear=False, **rule):
        F = ufl.Identity(3) + ufl.grad(self.u)
        J, strain = ufl.det(F), ufl.sym(ufl.grad(self.u))
        density = ufl.inner(strain, strain) if linear else J ** (-2 / 3) * ufl.inner(F, F) + (J - 1) ** 2
        return ufl.derivative(density * ufl.dx(domain=self.mesh, **rule), self.u, self.v)


@pytest.mark.parametrize("kind, given", [(di.StaticProblem, {}), (di.NewmarkProblem, {"density": 1.0})])
def test_an_estimate_far_too_high_is_warned_of(kind, given):
    r = Rubber()
    with pytest.warns(
        UserWarning, match=r"UFL estimates 13: 343 points.*take 8 \(degree 2\).*di.quadrature_degree\(u\)"
    ):
        kind(r.u, residual=r.residual(), **given)


def test_other_forms_are_not_warned_of():
    """With the degree that is offered, linear, or on cells whose gradients are constant; explicit problems warn too."""
    r, tetrahedra = Rubber(), Rubber(mesh.CellType.tetrahedron)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for case, form in (
            (r, r.residual(degree=di.quadrature_degree(r.u))),
            (r, r.residual(linear=True)),
            (tetrahedra, tetrahedra.residual()),
        ):
            di.StaticProblem(case.u, residual=form)
    linear = r.residual(linear=True, degree=2)
    with pytest.warns(UserWarning, match="UFL estimates 13"):
        di.ExplicitProblem(r.u, residual=linear + 1e-9 * r.residual(), density=1.0)


def test_the_degree_that_is_offered():
    """That of the package's own laws, of fields and spaces, with values and in bodies of revolution."""
    r = Rubber()
    assert di.quadrature_degree(r.u) == di.quadrature_degree(r.V) == 2
    assert di.quadrature_degree(r.u, values=True) == 4
    square = mesh.create_unit_square(MPI.COMM_SELF, 1, 1)
    found = [di.quadrature_degree(fem.functionspace(square, ("Lagrange", p, (2,)))) for p in (1, 2)]
    assert found == [0, 2]
    assert di.quadrature_degree(fem.functionspace(square, ("Lagrange", 1, (2,))), "axisymmetric") == 2
    with pytest.raises(TypeError, match="FunctionSpace"):
        di.quadrature_degree(3)


def test_long_compilations_are_announced(tmp_path, monkeypatch, capfd):
    """Before they begin, with points and seconds; not short ones, nor what is found in the cache."""
    monkeypatch.setenv("IMPACT_JIT_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(jit, "_LOADED", {})
    r = Rubber()
    form = r.residual(degree=2)
    jit.compile_form(r.residual(linear=True, degree=2))
    assert capfd.readouterr().err == ""
    monkeypatch.setattr(jit, "SILENT", 0.0)
    for times in (1, 0):
        jit.compile_form(form)
        said = capfd.readouterr().err
        assert said.count("compiling a form of rank 1 in u: 8 points, about ") == times and said.count("\n") == times


def test_the_estimate_grows_with_the_kernel():
    """By the points of a direction, whose loops are unrolled; tables count nothing."""
    from dolfinx_impact.forms.compiler import emit, frontend

    seconds = []
    for degree in (2, 6, 13):
        integrals = frontend.form_integrals(Rubber().residual(degree=degree), "form", {})
        seconds.append(emit.compile_seconds(integrals[0], emit.source(integrals, "k")[0]))
    assert 0.1 < seconds[0] < 3.0 and np.all(np.diff(seconds) > 0.5), seconds
