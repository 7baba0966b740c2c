# SPDX-License-Identifier: MIT
"""Parts of the checks, each by itself: forms as arrays, replaced terms of forms, reports, scenarios, sampled cells."""

from types import SimpleNamespace

import basix
import numpy as np
import own_forms
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from ufl.algorithms.map_integrands import map_integrand_dags

import dolfinx_impact as di
from dolfinx_impact.assembly import operators
from impact_verify import OwnForm
from impact_verify.reasons.sample import Sample, derivative, sample
from impact_verify.scenarios.record import Record, largest
from impact_verify.scenarios.scenario import ACCURACY, STEPS, USUAL_FRACTION, Accuracy, Explicit, Implicit, Scenario
from impact_verify.scenarios.variation import RandomVariation
from impact_verify.selfcheck.assembled import AssembledForm, AssembledMaterial, assembled
from impact_verify.selfcheck.file import Source, source_of
from impact_verify.selfcheck.findings import Finding, SelfCheckReport
from impact_verify.selfcheck.strong import _Test, gradient_order, has_gradient
from impact_verify.selfcheck.subject import Subject
from impact_verify.selfcheck.transplant import _Mover


def square(n=2, cell=mesh.CellType.triangle):
    return mesh.create_unit_square(MPI.COMM_SELF, n, n, cell)


# --- forms of one's own ----------------------------------------------------------------------------------------------


def elastic(domain):
    """Residual of linear elasticity with a dead load of 3 downwards."""
    u, v = own_forms.displacement(domain)
    load = fem.Constant(domain, (0.0, -3.0))
    return OwnForm(
        ufl.inner(own_forms.hooke(own_forms.strain(u)), ufl.grad(v)) * ufl.dx - ufl.inner(load, v) * ufl.dx, u
    )


def test_a_form_as_arrays_without_its_dead_loads(rng):
    own = elastic(square())
    form = assembled(own)
    assert type(form) is AssembledForm and form.dead is not None
    values = rng.random(len(own.u.x.array))
    assert form.vector(0 * values) == pytest.approx(0.0, abs=1e-15)
    K = form.matrix(values)
    np.testing.assert_allclose(form.vector(values), K @ values, atol=1e-12 * np.abs(K).max())
    x = own.u.function_space.tabulate_dof_coordinates()
    turn = np.column_stack([-x[:, 1], x[:, 0]]).ravel()
    assert np.abs(K @ turn).max() < 1e-13 * np.abs(K).max()


@pytest.mark.filterwarnings("ignore::dolfinx_impact.assembly.locking.Locking")
def test_a_material_as_arrays_is_virgin_at_every_state(rng):
    """Small strain below first yield: the arrays are those of the elastic material, also after a large one."""
    domain = square(1)  # triangles: the mean of the dilatation over a cell is that at its points
    u = fem.Function(fem.functionspace(domain, ("Lagrange", 1, (2,))))
    material = di.J2Plasticity(1.0, 0.3, 1.0, yield_stress=0.1, hypothesis="plane_strain")
    found = assembled(OwnForm(None, u, material=material))
    assert type(found) is AssembledMaterial
    values = rng.uniform(-1, 1, len(u.x.array))
    form = operators.internal_force_form(
        u, ufl.TestFunction(u.function_space), di.LinearElastic(1.0, 0.3, 1.0, "plane_strain")
    )
    small, large = 1e-3 * values, 10 * values
    plastic = found.vector(large)
    u.x.array[:] = large
    assert np.abs(plastic - fem.assemble_vector(fem.form(form)).array).max() > 0.1
    u.x.array[:] = small
    expected = fem.assemble_vector(fem.form(form)).array
    np.testing.assert_allclose(found.vector(small), expected, atol=1e-10 * np.abs(expected).max())
    np.testing.assert_allclose(found.matrix(small) @ small, expected, atol=1e-10 * np.abs(expected).max())


@pytest.mark.parametrize("order", [0, 1, 2])
def test_factors_of_a_test_function_and_its_gradients(order):
    """2 v + 3 dv/dx + 5 d2v/dxdy: each of them where that gradient alone is a unit tensor."""
    domain = square(1)
    v = ufl.TestFunction(fem.functionspace(domain, ("Lagrange", 2)))
    form = (2 * v + 3 * v.dx(0) + 5 * v.dx(0).dx(1)) * ufl.dx
    assert has_gradient(v.dx(0) * ufl.dx, 0) and not has_gradient(v * ufl.dx, 0)
    unit = {0: ufl.as_ufl(1.0), 1: ufl.as_vector((1.0, 0.0)), 2: ufl.as_tensor(((0.0, 1.0), (0.0, 0.0)))}
    plain = ufl.algorithms.expand_derivatives(ufl.algorithms.apply_algebra_lowering.apply_algebra_lowering(form))
    assert gradient_order(plain) == 2
    (integral,) = plain.integrals()
    replaced = map_integrand_dags(_Test(order, unit[order]), integral.integrand())
    value = fem.assemble_scalar(fem.form(replaced * ufl.dx(domain=domain)))
    assert value == pytest.approx((2, 3, 5)[order], rel=1e-14)


def test_a_form_moved_to_another_mesh():
    here, there = square(1), square(3)
    u, v = own_forms.displacement(here)
    k = fem.Constant(here, 2.0)
    mover = _Mover(there, {})
    W = mover.space(u)
    mover.terminals = {u: fem.Function(W), k: fem.Constant(there, 7.0)}
    mover.terminals[u].interpolate(lambda x: (x[0], x[1]))
    form = k * ufl.inner(u, v) * ufl.SpatialCoordinate(here)[0] * ufl.dx
    moved = map_integrand_dags(mover, form)
    moved = ufl.Form([i.reconstruct(domain=there.ufl_domain()) for i in moved.integrals()])
    assert moved.arguments()[0].ufl_function_space() is W
    # Test functions sum to one: 7 times the integrals of x^2 and of x y.
    total = fem.assemble_vector(fem.form(moved)).array.reshape(-1, 2).sum(axis=0)
    assert total == pytest.approx([7 / 3, 7 / 4], rel=1e-12)


def test_what_of_a_file_can_be_checked():
    found = source_of(elastic, "elastic")
    assert found == Source(elastic) and found.cell is None and found.cells is None
    law = source_of(di.NeoHookean(1.0, 0.3), "law")
    assert law.cells == ("hexahedron", "tetrahedron")
    own = law.maker(mesh.create_unit_cube(MPI.COMM_SELF, 1, 1, 1))
    assert len(own.residual.arguments()) == 1 and own.energy is not None
    with pytest.raises(TypeError, match="text is of type str"):
        source_of("form", "text")


@pytest.fixture(scope="module")
def subject():
    domain = square(2)
    return Subject("own", elastic(domain), elastic, SelfCheckReport(), square, 2)


def test_a_subject_has_states_forces_and_places(subject):
    assert subject.conservative and subject.degree == 1 and not subject.axisymmetric
    np.testing.assert_allclose(subject.forces, subject.tangent @ subject.state, atol=1e-13)
    assert 0.0 < np.abs(subject.motion()).max() < 5 * subject.own.strain
    # One field: all is relative to the largest force.
    assert subject.size(0.5 * subject.forces) == pytest.approx(0.5, rel=1e-14)
    assert subject.scaled(subject.tangent).shape == subject.tangent.shape
    x = subject.space.tabulate_dof_coordinates()
    node = int(np.flatnonzero(np.isclose(x[:, :2], (0.5, 1.0)).all(axis=1))[0])
    assert subject.place(2 * node + 1) == "component 1 at [0.5, 1.0]"


def test_findings_of_a_report(subject, capsys):
    report = subject.report
    assert not report.passed and repr(report) == "SelfCheckReport(0 checks made, nothing was checked)"
    assert subject.add("rigid", 1e-12, 1e-10, "round-off", "good", "bad")
    subject.leave_out("energy", "it has none")
    assert report.passed and repr(report) == "SelfCheckReport(1 checks made, all passed)"
    assert not subject.add("rigid", float("nan"), 1e-10, "round-off", "good", "bad [sic]")
    assert not report.passed and repr(report).endswith("failed: rigid)")
    assert [f.status for f in report.findings] == ["pass", "does not apply", "FAIL"]
    assert [f.note for f in report.of("rigid")] == ["good", "bad [sic]"] and isinstance(report.of("energy")[0], Finding)
    report.print()
    text = capsys.readouterr().out
    assert "2 checks, 1 do not apply; 1 failed" in text and "FAIL own triangle rigid: bad [sic]" in text


# --- reasons ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral", "hexahedron"])
def test_forces_of_a_sampled_cell_do_the_work_of_its_stress(cell, rng):
    """Virtual work of nodal forces against a linear motion: the integral of stress times its gradient; volume by V."""
    kind = getattr(basix.CellType, cell)
    X = np.array(basix.geometry(kind)) @ np.diag([2.0, 3.0, 0.5][: basix.geometry(kind).shape[1]])
    dim = X.shape[1]
    points, weights = basix.make_quadrature(kind, 4)
    one = sample(cell, 1, 1, X, SimpleNamespace(points=points, weights=weights))
    volume = {"triangle": 3.0, "quadrilateral": 6.0, "hexahedron": 3.0}[cell]
    assert isinstance(one, Sample) and one.weights.sum() == pytest.approx(volume, rel=1e-14)
    A = rng.random((dim, dim))
    u = (X @ A.T).ravel()
    H = one.gradient(u, hoop=False)
    np.testing.assert_allclose(H[:, :dim, :dim], np.broadcast_to(A, (len(H), dim, dim)), atol=1e-13)
    P = np.zeros((len(H), 3, 3))
    P[:, :dim, :dim] = stress = rng.random((dim, dim))
    ones = np.ones(len(H))
    assert one.forces(P, False, ones) @ u == pytest.approx(volume * np.sum(stress * A), rel=1e-13)
    load = np.zeros((len(H), 3))
    load[:, 0] = 2.0
    assert one.loads(load, ones).reshape(-1, dim).sum(axis=0) == pytest.approx(
        [2 * volume] + [0] * (dim - 1), abs=1e-13
    )


def test_the_hoop_of_a_body_of_revolution():
    """u_r = 0.1 r: the hoop strain is 0.1, and a hoop stress of one does the work 0.1 per volume."""
    X = np.array([(1.0, 0.0), (2.0, 0.0), (1.0, 1.0)])
    points, weights = basix.make_quadrature(basix.CellType.triangle, 4)
    one = sample("triangle", 1, 1, X, SimpleNamespace(points=points, weights=weights))
    u = np.column_stack([0.1 * X[:, 0], np.zeros(3)]).ravel()
    assert one.gradient(u, hoop=True)[:, 2, 2] == pytest.approx(0.1, rel=1e-13)
    P = np.zeros((len(weights), 3, 3))
    P[:, 2, 2] = 1.0
    around = 2 * np.pi * one.x[:, 0]
    volume = 2 * np.pi * (4 / 3) * 0.5  # of the ring: its centroid times its area
    assert one.forces(P, True, around) @ u == pytest.approx(0.1 * volume, rel=1e-13)


def test_normals_of_a_sampled_facet():
    X = np.array(basix.geometry(basix.CellType.triangle)) @ np.diag([2.0, 1.0])
    points, weights = basix.make_quadrature(basix.CellType.interval, 2)
    facet = sample("triangle", 1, 1, X, SimpleNamespace(points=points, weights=weights), 0)  # opposite to the origin
    assert facet.weights.sum() == pytest.approx(np.sqrt(5.0), rel=1e-14)
    assert facet.normal == pytest.approx(np.tile(np.array([1.0, 2.0, 0.0]) / np.sqrt(5.0), (len(weights), 1)))


def test_a_complex_step_has_no_cancellation(rng):
    H, dH = rng.random((2, 1, 3, 3))
    found = derivative(lambda A: A @ A @ A, H, dH)
    assert found == pytest.approx(dH @ H @ H + H @ dH @ H + H @ H @ dH, rel=1e-15)


# --- scenarios -------------------------------------------------------------------------------------------------------


def scenario(**given):
    body = SimpleNamespace(gdim=2)
    return Scenario("falls", body, lambda x: np.tile((0.0, -0.1), (len(x), 1)), **given)


def test_what_follows_from_the_scheme_of_a_scenario():
    explicit, implicit = scenario(contact="kinematic"), scenario(scheme=Implicit(), fixed_nodes=(2, 0), steps=7)
    assert (explicit.num_steps, implicit.num_steps) == (STEPS[Explicit], 7)
    assert explicit.accuracy is ACCURACY[Explicit] and isinstance(implicit.accuracy, Accuracy)
    assert (explicit.form, implicit.form) == ("explicit.kinematic", "implicit.free")
    assert explicit.compared == ("displacement",) and scenario().compared == ("displacement", "velocity")
    assert implicit.compared == ("displacement", "velocity", "acceleration")
    assert implicit.fixed_dofs.tolist() == [4, 5, 0, 1] and explicit.fixed_dofs.tolist() == []


def test_a_variation_keeps_supports_and_turns_what_moves():
    case = scenario(fixed_nodes=(1,))
    assert RandomVariation().apply(case) is case
    varied = RandomVariation(3).apply(case)
    x = np.array([(0.0, 2.0), (1.0, 2.0), (0.0, 3.0)])
    v = varied.velocity(x)
    assert not v[1].any() and 0.7 <= varied.step_fraction <= 0.9 and case.step_fraction == USUAL_FRACTION
    assert np.array_equal(v, RandomVariation(3).apply(case).velocity(x))
    assert not np.array_equal(v, RandomVariation(4).apply(case).velocity(x))
    assert varied.name == "falls, variation 3"


def test_a_turned_body_keeps_its_shape_and_its_height():
    domain = mesh.create_rectangle(MPI.COMM_SELF, [(0, 1.5), (1, 2.5)], (2, 2))
    before = domain.geometry.x.copy()
    RandomVariation(5).rotate_upper_body(domain)
    after = domain.geometry.x
    assert after[:, 1].min() == pytest.approx(1.5, abs=1e-14) and np.abs(after - before).max() > 0.01
    lengths = [np.linalg.norm(x[:, None] - x[None], axis=2) for x in (before, after)]
    np.testing.assert_allclose(lengths[1], lengths[0], atol=1e-14)


def test_the_largest_energy_of_a_record():
    energies = {"kinetic": np.array([1.0, -0.1]), "internal": np.array([0.2, -3.0]), "external": np.array([9.0, 0.0])}
    record = Record(np.array([0.0, 1.0]), {}, energies, largest(energies), None)
    assert record.largest_energy == 3.0
