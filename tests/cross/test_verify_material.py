# SPDX-License-Identifier: MIT
"""Level material of `verify`, and bodies that yield at the levels solution and history: faults are seen."""

import numpy as np
import pytest
import ufl
from fault_injection import assert_healthy

from dolfinx_impact.assembly.inelastic_tangent import InelasticTangent
from dolfinx_impact.forms import plasticity as law
from dolfinx_impact.plasticity import ArmstrongFrederick, J2Plasticity
from dolfinx_impact.statics.inelastic_body import InelasticBody
from dolfinx_impact.verify import cross_check, material, material_tangent, plastic_bodies
from dolfinx_impact.verify.report import Report

NUM = 20  # histories; a fault shows in each
SMALL = ("hexahedron", 1, "3d", False, True, "armstrong_frederick")


def case_of(name):
    return next(case for case in material.CASES if case.name == name)


def tangent_case(name):
    return next(case for case in material_tangent.BODIES if case[0] == name)


def difference(name, hypothesis="3d", finite=False):
    """Largest difference of a row of random histories."""
    found = material.compare(case_of(name), hypothesis, finite, num=NUM)
    assert found.pop("yielding") > 0.5
    return max(found.values())


def test_level_passes():
    report = Report()
    material.run(report, num=NUM)
    assert_healthy(report, "material")
    assert len(report.rows) > 80
    names = {row.name for row in report.rows}
    assert {"stress", "dissipation is never negative", "stress in frames that turn"} <= names
    assert {"tangent is the force's derivative", "forces across the corner are the tangent's integral"} <= names


@pytest.mark.slow
def test_whole_level_passes():
    report = cross_check(levels=["material"])
    assert_healthy(report, "material")


def test_yielding_bodies_pass():
    report = Report()
    plastic_bodies.static(report, *SMALL)
    plastic_bodies.impact(report, "quadrilateral", 1, "plane_strain", False, True, "prager")
    assert report.passed and {row.level for row in report.rows} == {"solution", "history"}


# --- faults of the law ------------------------------------------------------------------------------------------------


def wrong_law(monkeypatch, change):
    """Let laws return change(update, strain, history) instead of their update."""
    right = law.J2.respond

    def wrong(self, strain, history, unknown=None):
        return change(self, right(self, strain, history, unknown), strain, history)

    monkeypatch.setattr(law.J2, "respond", wrong)


def stretched(factor, names):
    """The increments of internal variables multiplied."""

    def change(self, update, strain, history):
        for name in names:
            update.outputs[name] = history[name] + factor * (update.outputs[name] - history[name])
        return update

    return change


@pytest.mark.parametrize("name, finite", [("linear", False), ("voce", True), ("armstrong_frederick", False)])
def test_a_wrong_factor_in_the_yield_condition_is_seen(name, finite, monkeypatch, own_cache):
    """1 in the place of 3/2."""
    monkeypatch.setattr(law, "equivalent", lambda s, floor: ufl.sqrt(ufl.inner(s, s) + floor**2))
    assert difference(name, finite=finite) > 1e3 * material.TOLERANCE


@pytest.mark.parametrize("name, finite", [("linear", False), ("table", True)])
def test_a_wrong_factor_in_the_flow_is_seen(name, finite, monkeypatch, own_cache):
    """2/3 of the plastic strain."""
    wrong_law(monkeypatch, stretched(2 / 3, [law.PLASTIC_TENSOR]))
    assert difference(name, finite=finite) > 1e3 * material.TOLERANCE


def test_a_wrong_factor_in_the_back_stress_is_seen(monkeypatch, own_cache):
    """1 in the place of 2/3."""
    wrong_law(monkeypatch, stretched(1.5, [law.BACK_STRESS]))
    assert difference("prager") > 1e3 * material.TOLERANCE


@pytest.mark.parametrize("finite", (False, True))
def test_a_history_committed_twice_is_seen(finite, monkeypatch, own_cache):
    """Each step adds its increments twice."""
    wrong_law(monkeypatch, stretched(2.0, [law.PLASTIC_STRAIN, law.PLASTIC_TENSOR]))
    assert difference("linear", finite=finite) > 1e3 * material.TOLERANCE


class YieldsLate(law.J2):
    """Whether a point yields is decided by the strain at the start of the step."""

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.history = {**self.history, "strain": (6,)}

    def respond(self, strain, history, unknown=None):
        update = super().respond(strain, history, unknown)
        plastic = law.unpack_deviator(history[law.PLASTIC_TENSOR], 3)

        def trial(eps):
            return 2 * self.mu * (ufl.dev(eps) - plastic)

        before = law.equivalent(trial(law.unpack_symmetric(history["strain"], 3)), 1.0)
        late = ufl.gt(before, self.isotropic.stress(history[law.PLASTIC_STRAIN]) * (1 - 1e-9))
        elastic = trial(strain) + self.kappa * ufl.tr(strain) * ufl.Identity(3)
        update.stress = ufl.conditional(late, update.stress, elastic)
        for name in (law.PLASTIC_STRAIN, law.PLASTIC_TENSOR):
            update.outputs[name] = ufl.conditional(late, update.outputs[name], history[name])
        update.outputs["strain"] = ufl.as_vector(law.pack_symmetric(strain, 3))
        return update


def test_a_yield_condition_with_the_committed_strain_is_seen(monkeypatch, own_cache):
    monkeypatch.setattr(law, "J2", YieldsLate)
    assert difference("linear") > 1e3 * material.TOLERANCE


def test_flow_against_the_stress_is_seen(monkeypatch, own_cache):
    """The plastic strain grows in the wrong direction: energy out of nothing."""
    right = material.dissipation(case_of("linear"), "3d", False, num=NUM)
    wrong_law(monkeypatch, stretched(-0.1, [law.PLASTIC_TENSOR]))
    wrong = material.dissipation(case_of("linear"), "3d", False, num=NUM)
    assert right <= material.TOLERANCE < 1e-3 < wrong


def test_a_history_that_stays_behind_a_rotation_is_seen(monkeypatch, own_cache):
    """The history of finite strain read as if it were a tensor of the deformed body."""

    def change(self, update, strain, history):
        turned = self._finite(strain, {**history, law.PLASTIC_TENSOR: 0 * history[law.PLASTIC_TENSOR]}, None)
        update.stress = update.stress + 0.01 * history[law.PLASTIC_TENSOR][3] * turned.stress.T
        return update

    assert max(material.objectivity(case_of("linear"), "3d", num=NUM).values()) <= material.TOLERANCE
    wrong_law(monkeypatch, change)
    assert max(material.objectivity(case_of("linear"), "3d", num=NUM).values()) > 1e3 * material.TOLERANCE


@pytest.mark.parametrize("name", ("prager", "armstrong_frederick"))
def test_a_back_stress_that_is_not_turned_is_seen(name, monkeypatch, own_cache):
    """The return in the frame of the reference configuration, with F in the place of U."""
    assert max(material.objectivity(case_of(name), "plane_strain", num=NUM).values()) <= material.TOLERANCE
    monkeypatch.setattr(law, "plane_stretch", lambda F: F)
    assert max(material.objectivity(case_of(name), "plane_strain", num=NUM).values()) > 1e3 * material.TOLERANCE


@pytest.mark.parametrize("hypothesis", ("3d", "plane_strain"))
def test_a_trace_of_the_stretch_that_is_too_large_is_seen(hypothesis, monkeypatch, own_cache):
    """R is no rotation then."""
    right, plane = law.stretch, law.plane_stretch
    monkeypatch.setattr(law, "stretch", lambda C, x: right(C, 1.0001 * x))
    monkeypatch.setattr(law, "plane_stretch", lambda F: 1.0001 * plane(F))
    assert difference("prager", hypothesis, finite=True) > 1e3 * material.TOLERANCE


# --- limits of the law with kinematic hardening in finite strain ------------------------------------------------------


def results(ours, finite, hypothesis, path):
    """Stress and history at the end of a path of displacement gradients."""
    points = material.Points(material.Case("", ours, {}), hypothesis, finite, path.shape[1])
    for gradient in path:
        stress = points.step(gradient)
    return stress, points


@pytest.mark.parametrize("hypothesis", ("3d", "plane_strain"))
def test_without_kinematic_modulus_it_is_the_isotropic_law(hypothesis):
    """C of 1e-12 Y: to round-off, 1e-10."""
    path = material.strain_paths(np.random.default_rng(1), NUM, 3 if hypothesis == "3d" else 2, True)
    Y = material.Y
    isotropic, one = results({"hardening": 0.5 * Y}, True, hypothesis, path)
    for kinematic in (1e-12 * Y, ArmstrongFrederick(1e-12 * Y, 10.0)):
        stress, two = results({"hardening": 0.5 * Y, "kinematic": kinematic}, True, hypothesis, path)
        assert np.abs(stress - isotropic).max() < material.TOLERANCE * Y
        for name in one.names:
            assert np.abs(two.variable(name) - one.variable(name)).max() < material.TOLERANCE


@pytest.mark.parametrize("hypothesis", ("3d", "plane_strain"))
@pytest.mark.parametrize("name", ("prager", "armstrong_frederick"))
def test_small_strains_are_the_limit(name, hypothesis, monkeypatch):
    """Strains and yield stress over n: the stress over the yield stress goes to that of small strain with order 1."""
    path = material.stretch_paths(np.random.default_rng(2), NUM, 3 if hypothesis == "3d" else 2, False)[:10]
    Y, errors = material.Y, []
    for n in (1, 2, 4):
        monkeypatch.setattr(material, "Y", Y / n)
        kinematic = {"prager": 20e9, "armstrong_frederick": ArmstrongFrederick(60e9, 300.0 * n)}[name]
        small, finite = (results({"kinematic": kinematic}, f, hypothesis, path / n)[0] for f in (False, True))
        errors.append(np.abs(small - finite).max() * n / Y)
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[0] > 1e-3 and np.all(np.abs(orders - 1.0) < 0.25), (errors, orders)


@pytest.mark.parametrize("name", ("voce", "armstrong_frederick"))
def test_flow_keeps_the_volume(name):
    """det C_p = 1 after 50 steps: 1e-13, the tolerance of the local equations and round-off of its nine factors."""
    path = material.strain_paths(np.random.default_rng(1), NUM, 3, True)
    _, points = results(case_of(name).ours, True, "3d", path)
    assert points.variable(law.PLASTIC_STRAIN).max() > 0.5
    assert np.abs(np.linalg.det(points.variable(law.PLASTIC_TENSOR)) - 1.0).max() < 1e-13 * 50


# --- faults of the tangent and of commits -----------------------------------------------------------------------------


def wrong_step(monkeypatch):
    """The tangent starts from the history of the trial, not from the committed one: that of the next step."""
    right = InelasticBody.assemble

    def wrong(self):
        points = self.force.history
        values = points.values
        try:
            points.values = lambda name, trial=False: values(name, True)
            return right(self)
        finally:
            del points.values

    monkeypatch.setattr(InelasticBody, "assemble", wrong)


@pytest.mark.parametrize("name", ("linear", "armstrong_frederick"))
def test_a_tangent_of_the_wrong_step_is_seen(name, monkeypatch):
    report = Report()
    material_tangent.taylor(report, *tangent_case(name))
    assert report.passed
    wrong_step(monkeypatch)
    material_tangent.taylor(report, *tangent_case(name))
    assert [row.passed for row in report.rows] == [True, False] and report.rows[1].note


def test_a_tangent_of_the_wrong_step_is_seen_across_the_corner(monkeypatch):
    report = Report()
    wrong_step(monkeypatch)
    material_tangent.corner(report, *tangent_case("armstrong_frederick"))
    assert not report.passed


def test_statics_with_a_tangent_of_the_wrong_step_do_not_converge_quadratically(monkeypatch):
    """Iterations of the rows' static problem: few with the right tangent, many or too many with the other."""

    def norms():
        both = plastic_bodies.PlasticBodies(*SMALL)
        V, dim = both.body.V, both.body.gdim
        x = V.tabulate_dof_coordinates()
        ends = [np.flatnonzero(np.isclose(x[:, -1], end)).astype(np.int32) for end in (0.0, 1.0)]
        move = [np.zeros(dim), 0.02 * np.eye(dim)[-1]]
        bcs = [plastic_bodies.fem.dirichletbc(d, nodes, V) for d, nodes in zip(move, ends)]
        problem = plastic_bodies.StaticProblem(both.u, both.steel, bcs=bcs)
        return problem.solve(rtol=1e-12, max_iterations=60).residual_norms[0]

    right = norms()
    assert len(right) <= 9
    wrong_step(monkeypatch)
    try:
        wrong = norms()
    except RuntimeError as e:
        assert "converge" in str(e)
    else:
        assert len(wrong) >= 2 * len(right)


def test_a_wrong_second_derivative_of_the_mean_dilatation_is_seen(monkeypatch):
    """The second derivative of the mean dilatation is too large by a half."""
    right = InelasticTangent._second_derivative
    monkeypatch.setattr(
        InelasticTangent, "_second_derivative", lambda self, means, v, du: 1.5 * right(self, means, v, du)
    )
    report = Report()
    material_tangent.taylor(report, *tangent_case("linear"))
    assert not report.passed


def test_trials_that_commit_are_seen(monkeypatch):
    """Every iteration of a static problem commits its history."""
    right = InelasticBody.add_residual

    def wrong(self, b):
        right(self, b)
        self.force.history.commit()

    monkeypatch.setattr(InelasticBody, "add_residual", wrong)
    report = Report()
    try:
        plastic_bodies.static(report, *SMALL)
    except RuntimeError:
        return  # Newton's method does not converge any more
    assert not report.passed


def test_a_weaker_law_is_seen_in_the_history(monkeypatch):
    """Another yield stress on one side, by a part in a million."""
    right = J2Plasticity.response

    def weaker(self, mesh):
        response = right(self, mesh)
        response.isotropic.yield_stress.value *= 1 - 1e-6
        return response

    monkeypatch.setattr(J2Plasticity, "response", weaker)
    report = Report()
    plastic_bodies.impact(report, "quadrilateral", 1, "plane_strain", False, True, "prager")
    assert {row.name.split(" of ")[0] for row in report.failures()} >= {"displacement", "plastic energy"}
