# SPDX-License-Identifier: MIT
"""Stress, internal variables and parts of operators of one small body whose strain is the same everywhere."""

import warnings

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.assembly import operators
from dolfinx_impact.assembly.body_forms import BodyForms, body_forms
from dolfinx_impact.assembly.body_results import BodyResults
from dolfinx_impact.assembly.body_stress import BodyStress
from dolfinx_impact.assembly.cauchy_stress import CauchyStress
from dolfinx_impact.assembly.history_field import HistoryField
from dolfinx_impact.assembly.inelastic_part import InelasticParts
from dolfinx_impact.assembly.large_rotation import LargeRotation, RotationWarning
from dolfinx_impact.assembly.operators import BilinearKernels, Inputs, SplitForce, _Operator
from dolfinx_impact.assembly.point_values import PointHistory
from dolfinx_impact.assembly.residual_bodies import ResidualBodies
from dolfinx_impact.assembly.stress_fields import StressFields

E, NU, YIELD = 1000.0, 0.25, 5.0
LAMBDA, MU = E * NU / ((1 + NU) * (1 - 2 * NU)), E / (2 * (1 + NU))
ELASTIC = di.LinearElastic(E, NU, 1.0, "plane_strain")
PLASTIC = di.J2Plasticity(E, NU, 1.0, yield_stress=YIELD, hypothesis="plane_strain")


class Body:
    """Unit square of 2 x 2 cells with a displacement of constant gradient."""

    def __init__(self, gradient=((1e-3, 2e-3), (0.0, -3e-3))):
        self.mesh = mesh.create_unit_square(MPI.COMM_SELF, 2, 2, mesh.CellType.quadrilateral)
        self.V = fem.functionspace(self.mesh, ("Lagrange", 1, (2,)))
        self.u = fem.Function(self.V, name="u")
        self.move(gradient)

    def move(self, gradient):
        self.u.interpolate(lambda x: np.asarray(gradient) @ x[:2])


@pytest.fixture(scope="module")
def body():
    return Body()


def hooke(gradient):
    """Components xx, yy, zz, xy in plane strain, and von Mises' stress."""
    strain = np.zeros((3, 3))
    strain[:2, :2] = (np.asarray(gradient) + np.asarray(gradient).T) / 2
    s = LAMBDA * np.trace(strain) * np.eye(3) + 2 * MU * strain
    deviator = s - np.trace(s) / 3 * np.eye(3)
    return [s[0, 0], s[1, 1], s[2, 2], s[0, 1]], np.sqrt(1.5 * np.sum(deviator**2))


def test_stress_of_an_elastic_body(body):
    stress, mises = hooke(((1e-3, 2e-3), (0.0, -3e-3)))
    fields = StressFields(body.u, ELASTIC)
    np.testing.assert_allclose(fields["stress"].values, np.broadcast_to(stress, (4, 4, 4)), rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(fields["von_mises"].values, np.full((4, 4), mises), rtol=1e-12)
    with pytest.raises(KeyError, match="not 'strain'"):
        fields["strain"]
    assert CauchyStress(body.u, ELASTIC).degree == fields["stress"].degree
    one = BodyStress(body.u, ELASTIC)
    assert one.field("stress", None).shape == (4,) and one.field("von_mises", {"von_mises": "of the history"}) == (
        "of the history"
    )
    with pytest.raises(ValueError, match="von_mises: the residual is your own"):
        BodyStress(body.u, None).field("von_mises", None)


def test_results_of_a_body_without_internal_variables(body):
    problem = di.StaticProblem(body.u, ELASTIC)
    assert isinstance(problem, BodyResults) and not problem.has_history
    assert problem.von_mises.values == pytest.approx(np.full((4, 4), hooke(((1e-3, 2e-3), (0, -3e-3)))[1]), rel=1e-12)
    with pytest.raises(ValueError, match="no material of the problem has internal variables"):
        problem.history


def test_internal_variables_by_name():
    body = Body(((0.0, 0.0), (0.0, 0.0)))
    problem = di.StaticProblem(body.u, PLASTIC)
    history, parts = problem.history, InelasticParts(body.u, PLASTIC)
    assert isinstance(problem.history, type(history)) and problem.has_history
    (part,) = parts
    assert list(history) == list(part.history) and len(history) == len(part.history) > 0 == len(InelasticParts(
        body.u, ELASTIC))  # fmt: skip
    with pytest.raises(KeyError, match="no material has the internal variable 'rust'"):
        history["rust"]
    assert history["von_mises"].shape == () and repr(history).startswith("MaterialHistory(")


class Part:
    """Stands for internal variables of one integral in C++."""

    memory = 10

    def __init__(self, cells, num_points, width):
        self.cells, self.num_points, self.width = np.array(cells), num_points, width
        self.names, self.given, self.calls = ["alpha", "energy"], {}, []

    def is_history(self, name):
        return name == "alpha"

    def num_components(self, name):
        return self.width

    def values(self, name, trial):
        return np.arange(1.0, 1 + len(self.cells) * self.num_points * self.width)

    def set_values(self, name, values):
        self.given[name] = values

    def __getattr__(self, name):
        return lambda: self.calls.append(name)


def test_values_of_several_laws_are_one_array():
    first, second = Part([0, 3], 2, 1), Part([1], 1, 2)
    history = PointHistory(5, [(7, first)]) + PointHistory(5, [(8, second)])
    assert (history.parts, history.num_points, history.memory) == ([first, second], 2, 20)
    assert history.names == ["alpha", "energy"] and history.state_names == ["alpha"]
    values = history.values("alpha")
    expected = np.zeros((5, 2, 2))
    expected[0, :, 0], expected[3, :, 0], expected[1, 0] = (1, 2), (3, 4), (1, 2)
    assert np.array_equal(values, expected)
    assert np.array_equal(history.of_tag(8).values("alpha")[1], [[1, 2]])
    history.set_values("alpha", 10 * values)
    assert np.array_equal(first.given["alpha"], [10, 20, 30, 40]) and np.array_equal(second.given["alpha"], [10, 20])
    for call in ("store_snapshot", "restore_snapshot", "commit", "revert"):
        getattr(history, call)()
        assert first.calls[-1] == second.calls[-1] == call
    with pytest.raises(ValueError, match=r"must have shape \(5, 2, 2\), found \(5, 2\)"):
        history.set_values("alpha", values[..., 0])
    with pytest.raises(ValueError, match="called 'beta'; there are: alpha, energy"):
        history.values("beta")


def test_a_field_reads_and_writes_what_it_is_given(body):
    stored = {"values": np.arange(48.0).reshape(4, 4, 3)}
    field = HistoryField("back", (3,), 2, body.mesh, lambda: stored["values"], lambda v: stored.update(values=v))
    assert np.array_equal(field.values, stored["values"])
    field.values = 2 * field.values
    assert stored["values"][3, 3, 2] == 94.0
    assert field.function().x.array.sum() == pytest.approx(stored["values"].sum(), rel=1e-15)
    assert repr(field) == "HistoryField('back': 3 components at the points of degree 2)"
    with pytest.raises(AttributeError, match="energy follows from the displacement"):
        HistoryField("energy", (), 2, body.mesh, lambda: np.zeros((4, 4, 1))).values = np.zeros((4, 4))


def test_averages_at_vertices(body):
    """Of cells with the values 1 to 4: a corner has that of its cell, the centre the mean, with equal weights."""
    values = np.broadcast_to(np.arange(1.0, 5.0)[:, None, None], (4, 4, 1))
    field = HistoryField("alpha", (), 2, body.mesh, lambda: values)
    nodes = field.at_nodes()
    x = nodes.function_space.tabulate_dof_coordinates()
    dofs = nodes.function_space.dofmap.list
    counts = np.bincount(dofs.ravel())
    mean = np.bincount(dofs.ravel(), np.repeat(np.arange(1.0, 5.0), 4)) / counts
    assert sorted(counts) == [1] * 4 + [2] * 4 + [4] and len(x) == 9
    np.testing.assert_allclose(nodes.x.array, mean, rtol=1e-13)


def test_changes_of_constants_and_functions(body):
    constant, f, unseen = fem.Constant(body.mesh, (2.0, 0.0)), fem.Function(body.V), fem.Function(body.V)
    inputs = Inputs([constant], [f, unseen], [unseen, None])
    unseen.x.array[:] = 1.0
    assert not inputs.changed() and inputs.change() == 0.0
    constant.value = (2.5, 0.0)
    assert inputs.changed() and inputs.change() == pytest.approx(0.25, rel=1e-15)
    constant.value = (2.0, 0.0)
    f.x.array[0] = 1e-30
    assert inputs.changed() and inputs.change() == 1.0  # what was zero
    inputs.store()
    assert not inputs.changed()


def test_parts_of_a_force_are_the_force(body):
    v = ufl.TestFunction(body.V)
    form = operators.internal_force_form(body.u, v, ELASTIC)
    whole, split = operators.InternalForce(form), SplitForce(form, displacement=body.u)
    assert isinstance(whole, _Operator) and repr(whole).startswith("InternalForce(integrals: 1 cell, of ")
    found = whole.vector().array.copy()
    for part in split._parts:
        part.assemble(found)
    expected = whole.apply().array
    np.testing.assert_allclose(found, expected, atol=1e-13 * np.abs(expected).max())
    assert whole.width in (1, 4, 8) and whole.flops > 0 and whole.fault() == split.fault() == ""
    # Equilibrium of a uniform stress: nothing inside, and the resultant of each side is the stress on it.
    x = body.V.tabulate_dof_coordinates()
    stress = hooke(((1e-3, 2e-3), (0.0, -3e-3)))[0]
    right = np.isclose(x[:, 0], 1.0)
    assert expected.reshape(-1, 2)[right].sum(axis=0) == pytest.approx([stress[0], stress[3]], rel=1e-12)
    middle = np.isclose(x[:, :2], 0.5).all(axis=1)
    assert np.abs(expected.reshape(-1, 2)[middle]).max() < 1e-13 * np.abs(expected).max()


def test_a_split_force_tells_of_changed_constants(body):
    load, v = fem.Constant(body.mesh, (1.0, 0.0)), ufl.TestFunction(body.V)
    split = SplitForce(ufl.inner(load, v) * ufl.dx)
    assert not split.changed() and len(split.history.names) == 0
    load.value = (2.0, 0.0)
    assert split.changed()
    split.update()
    assert not split.changed()
    total = split._parts[0].vector().array.copy()
    for part in split._parts:
        part.assemble(total)
    assert total.reshape(-1, 2).sum(axis=0) == pytest.approx([2.0, 0.0], rel=1e-14)
    with pytest.raises(ValueError, match="InternalForce takes a form of rank 1, this one has 2"):
        operators.InternalForce(ufl.inner(ufl.TrialFunction(body.V), v) * ufl.dx)


def test_kernels_of_a_bilinear_form_have_sources_and_constants(body):
    k, w = fem.Constant(body.mesh, 3.0), fem.Function(body.V, name="w")
    form = k * ufl.inner(w, w) * ufl.inner(ufl.TrialFunction(body.V), ufl.TestFunction(body.V)) * ufl.dx
    compiled = operators.compile_form(form)
    kernels = BilinearKernels(form, compiled)
    assert len(kernels.integrals) == len(kernels.sources) == len(compiled.kernels) == 1
    assert kernels.functions == [w] and len(kernels.sources[0]) == 1
    k.value = 4.0
    assert [v.tolist() for v in kernels.values()] == [[4.0]]


def test_forms_of_explicit_steps(body):
    elastic, plastic = body_forms(body.u, ELASTIC), body_forms(body.u, PLASTIC)
    assert isinstance(elastic, BodyForms) and elastic.linear and elastic.laws is None and elastic.parts is None
    assert not plastic.linear and plastic.laws is not None and len(plastic.parts) == 1
    assert not body_forms(body.u, di.NeoHookean(E, NU, 1.0, "plane_strain")).linear
    # The stiffness of an inelastic body is that of its elastic part: in the undeformed body the same matrix.
    rest = Body(((0.0, 0.0), (0.0, 0.0)))
    forms = [body_forms(rest.u, material).stiffness for material in (ELASTIC, PLASTIC)]
    first, second = (fem.assemble_matrix(fem.form(form)).to_dense() for form in forms)
    # Quadrature of both is exact on squares.
    np.testing.assert_allclose(second, first, atol=1e-10 * np.abs(first).max())


@pytest.mark.parametrize(
    "material, told",
    [(ELASTIC, True), (PLASTIC, True), (di.NeoHookean(E, NU, 1.0, "plane_strain"), False), (None, False)],
)
def test_bodies_of_small_strain_that_turn_are_told_once(material, told):
    turn = np.array([[np.cos(0.5), -np.sin(0.5)], [np.sin(0.5), np.cos(0.5)]])
    body, watch = Body(1e-3 * np.eye(2)), RotationWarning(material)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        watch.look(body.u, 1)
        assert not caught
        body.move(turn - np.eye(2))
        watch.look(body.u, 1)
        watch.look(body.u, 1)
    assert [c.category for c in caught] == [LargeRotation] * told


def test_bodies_of_a_residual_know_what_they_were_told(body):
    bodies = ResidualBodies(body.mesh, None)
    assert bodies.hypothesis_on(body.mesh) == "plane_strain" and bodies.parts() == [(None, bodies)]
    with pytest.raises(ValueError, match="per_mass=False"):
        bodies.density_constant(body.mesh)
    assert ResidualBodies(body.mesh, "axisymmetric", "rho", 3.0).density_constant(body.mesh) == "rho"
    with pytest.raises(ValueError, match="does not fit"):
        ResidualBodies(body.mesh, "3d")
