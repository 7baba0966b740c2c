# SPDX-License-Identifier: MIT
"""Bodies as Newton's method in C++ sees them, and the lines that it writes, without a problem around them."""

import logging

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.assembly import operators
from dolfinx_impact.statics.assembled_body import AssembledBody, BodyMatrix, depends_on
from dolfinx_impact.statics.evaluated_body import EvaluatedBody, EvaluatedTangent
from dolfinx_impact.statics.form_body import FormBody
from dolfinx_impact.statics.load_steps import StepLog
from dolfinx_impact.statics.restart import StaticRestart

SQUARE = mesh.create_unit_square(MPI.COMM_SELF, 2, 2)
V = fem.functionspace(SQUARE, ("Lagrange", 1, (2,)))
v, du = ufl.TestFunction(V), ufl.TrialFunction(V)


def dense(matrix):
    rows = np.arange(matrix.size[0], dtype=np.int32)
    return matrix.getValues(rows, rows)


@pytest.fixture
def u(rng):
    f = fem.Function(V)
    f.x.array[:] = 0.1 * rng.random(len(f.x.array))
    return f


def cubic(u):
    """Residual of springs u + |u|^2 u at all places, and its derivative."""
    residual = ufl.inner((1 + ufl.inner(u, u)) * u, v) * ufl.dx(degree=4)
    return residual, ufl.derivative(residual, u, du)


def test_a_body_of_a_form_is_that_form(u):
    residual, tangent = cubic(u)
    body = FormBody(u, residual, tangent)
    assert isinstance(body, AssembledBody) and isinstance(body.tangent, BodyMatrix)
    assert not body.properties.linear and not body.properties.keeps_tangent
    for _ in range(2):  # at any displacement
        expected = fem.assemble_vector(fem.form(residual)).array
        np.testing.assert_allclose(body.in_cpp().residual().array_r, expected, atol=1e-15)
        matrix = body.tangent.assemble()
        assert matrix.handle == body.tangent.matrix.handle
        np.testing.assert_allclose(dense(matrix), fem.assemble_matrix(fem.form(tangent)).to_dense(), atol=1e-15)
        u.x.array[:] *= -3.0


@pytest.mark.parametrize("exact", [True, False])
def test_a_linear_form_keeps_its_tangent_if_it_is_known_to_be_exact(u, exact):
    residual = ufl.inner(u, v) * ufl.dx
    body = FormBody(u, residual, ufl.inner(du, v) * ufl.dx, exact)
    assert body.properties.linear == body.properties.keeps_tangent == exact


def test_what_a_form_depends_on(u):
    residual, tangent = cubic(u)
    linear = ufl.derivative(ufl.inner(u, u) / 2 * ufl.dx, u, v)
    assert depends_on(residual, u) == depends_on(tangent, u) == (True, True)
    assert depends_on(ufl.derivative(linear, u, du), u) == (True, False)  # written with u, but without it when derived
    assert depends_on(None, u) == depends_on(ufl.inner(du, v) * ufl.dx, u) == (False, False)


def test_energies_of_an_assembled_body(u):
    law = di.LinearElastic(10.0, 0.3, 1.0, "plane_strain")
    body = FormBody(
        u, *[f(u, *a, law) for f, a in ((operators.internal_force_form, (v,)), (operators.tangent_form, (du, v)))]
    )
    energy = operators.strain_energy_form(u, law)
    body.set_energies([operators.Energy(energy)])
    assert body.in_cpp().stored_energy() == pytest.approx(fem.assemble_scalar(fem.form(energy)), rel=1e-13)


def test_functions_are_evaluated_before_they_are_read(u):
    """A user's function sets w = u^2; residual and tangent read w."""
    w, calls = fem.Function(V), []

    def evaluate(at):
        calls.append("evaluate")
        w.x.array[:] = at.x.array**2

    residual, tangent = ufl.inner(w, v) * ufl.dx, ufl.inner(w, w) * ufl.inner(du, v) * ufl.dx
    body = EvaluatedBody(u, residual, tangent, evaluate, lambda at: calls.append("accept"))
    assert isinstance(body.tangent, EvaluatedTangent) and body.properties.inelastic
    first = body.in_cpp().residual().array_r.copy()
    np.testing.assert_allclose(first, fem.assemble_vector(fem.form(residual)).array, atol=1e-16)
    body.tangent.assemble()
    assert calls == ["evaluate"]  # the functions are those of this displacement
    u.x.array[:] *= 2.0
    matrix = dense(body.tangent.assemble())
    assert calls == ["evaluate"] * 2 and body.tangent.matrix.handle == body.forms.tangent.matrix.handle
    np.testing.assert_allclose(matrix, fem.assemble_matrix(fem.form(tangent)).to_dense(), atol=1e-16)
    body.in_cpp().accept_step()
    body.tangent.assemble()  # a step has ended: a history may have changed
    assert calls == ["evaluate", "evaluate", "accept", "evaluate"]


def test_a_function_that_writes_to_the_displacement(u):
    def evaluate(at):
        at.x.array[:] = 0.0

    residual, tangent = cubic(u)
    with pytest.raises(ValueError, match="evaluate has written to the displacement u, which it may only read"):
        EvaluatedBody(u, residual, tangent, evaluate, None).tangent.assemble()


def test_lines_of_iterations(capsys, caplog):
    with caplog.at_level(logging.INFO):
        StepLog(MPI.COMM_SELF, True).iteration(2, 0.5, 2.0, 7, 1)
        StepLog(MPI.COMM_SELF, False).iteration(3, 0.5, 0.0, 7, 1)
    printed = capsys.readouterr().out.splitlines()
    assert printed == ["  iteration  2: residual 5.000e-01 (relative 2.50e-01), 7 in contact, 1 changed"]
    assert [r.getMessage() for r in caplog.records][1].endswith("(relative 0), 7 in contact, 1 changed")


def test_a_static_problem_recognises_itself_by_its_arguments():
    def signature(E=10.0, load=1.0):
        problem = di.StaticProblem(
            fem.Function(V), di.LinearElastic(E, 0.3, 1.0, "plane_strain"), loads=[di.BodyForce((0, load))]
        )
        restart = StaticRestart(problem)
        nodes, rows = restart._supports()
        assert len(nodes) == len(rows) == 0 and restart._recorders() == ()
        return {k: v for k, v in restart._signature(None).items() if isinstance(v, str | int)}

    assert signature() == signature(load=2.0)  # a value that a solve leads to
    assert {k for k, v in signature(E=11.0).items() if v != signature()[k]} == {"material.E"}
