# SPDX-License-Identifier: MIT
"""Level material of `verify`, and bodies that yield at the levels solution and history: faults are seen."""

import numpy as np
import pytest
import ufl
from fault_injection import assert_healthy, commit_at_once

from dolfinx_impact.assembly.operators import InternalForce
from dolfinx_impact.forms import consistent_tangent
from dolfinx_impact.forms import plasticity as law
from dolfinx_impact.plasticity import ArmstrongFrederick, J2Plasticity
from impact_verify import cross_check, material, material_tangent, plastic_bodies
from impact_verify.report import Report

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
    assert len(report.rows) > 120
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


@pytest.mark.parametrize("name", (law.PLASTIC_STRAIN, law.PLASTIC_TENSOR, law.BACK_STRESS))
def test_each_internal_variable_has_a_row_that_sees_it(name, monkeypatch, own_cache):
    """Increments too large by 1e-8: a hundred tolerances."""
    right = material.compare(case_of("armstrong_frederick"), "3d", False, num=NUM)
    wrong_law(monkeypatch, stretched(1 + 1e-8, [name]))
    wrong = material.compare(case_of("armstrong_frederick"), "3d", False, num=NUM)
    assert right[name] <= material.TOLERANCE and wrong[name] > 10 * material.TOLERANCE


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


@pytest.mark.long_rows(where=lambda name: name != "prager")
@pytest.mark.parametrize("name", ("prager", "armstrong_frederick"))
def test_a_back_stress_that_is_not_turned_is_seen(name, monkeypatch, own_cache):
    """The return in the frame of the reference configuration, with F in the place of U."""
    assert max(material.objectivity(case_of(name), "plane_strain", num=NUM).values()) <= material.TOLERANCE
    monkeypatch.setattr(law, "plane_stretch", lambda F: F)
    assert max(material.objectivity(case_of(name), "plane_strain", num=NUM).values()) > 1e3 * material.TOLERANCE


@pytest.mark.long_rows(where=lambda hypothesis: hypothesis != "3d")
@pytest.mark.parametrize("hypothesis", ("3d", "plane_strain"))
def test_a_trace_of_the_stretch_that_is_too_large_is_seen(hypothesis, monkeypatch, own_cache):
    """R is no rotation then."""
    right, plane = law.stretch, law.plane_stretch
    monkeypatch.setattr(law, "stretch", lambda C, x: right(C, 1.0001 * x))
    monkeypatch.setattr(law, "plane_stretch", lambda F: 1.0001 * plane(F))
    assert difference("prager", hypothesis, finite=True) > 1e3 * material.TOLERANCE


@pytest.mark.long_rows(where=lambda name: name != "voce")
@pytest.mark.parametrize("name", ("voce", "armstrong_frederick"))
def test_a_stress_across_a_sheet_is_seen(name, monkeypatch, own_cache):
    """Of 4e-4 of the yield stress."""

    def change(self, update, strain, history):
        update.residual = update.residual + ufl.as_vector([0, 1e-4 * update.scale])
        return update

    assert difference(name, "plane_stress", finite=True) <= material.TOLERANCE
    wrong_law(monkeypatch, change)
    assert difference(name, "plane_stress", finite=True) > 1e3 * material.TOLERANCE


def test_a_wrong_thickness_is_seen(monkeypatch, own_cache):
    """Increments too large by 1e-8."""
    wrong_law(monkeypatch, stretched(1 + 1e-8, [law.THICKNESS_STRAIN]))
    wrong = material.compare(case_of("linear"), "plane_stress", True, num=NUM)
    assert wrong[law.THICKNESS_STRAIN] > 10 * material.TOLERANCE


def test_a_thickness_that_stays_is_seen(monkeypatch, own_cache):
    """Trial strains without the stretch across the plane: the local equations have no solution."""
    right = law.thickened
    monkeypatch.setattr(law, "thickened", lambda F, across: right(F, 0.0))
    found = material.compare(case_of("linear"), "plane_stress", True, num=NUM)
    assert not found["stress"] <= 1e3 * material.TOLERANCE


@pytest.mark.slow
def test_a_back_stress_of_a_sheet_that_is_not_turned_is_seen(monkeypatch, own_cache):
    assert max(material.objectivity(case_of("prager"), "plane_stress", num=NUM).values()) <= material.TOLERANCE
    monkeypatch.setattr(law, "plane_stretch", lambda F: F)
    assert max(material.objectivity(case_of("prager"), "plane_stress", num=NUM).values()) > 1e3 * material.TOLERANCE


# --- limits of the law with kinematic hardening in finite strain ------------------------------------------------------


def results(ours, finite, hypothesis, path):
    """Stress and history at the end of a path of displacement gradients."""
    points = material.Points(material.Case("", ours, {}), hypothesis, finite, path.shape[1])
    for gradient in path:
        stress = points.step(gradient)
    return stress, points


@pytest.mark.parametrize("hypothesis", ("3d", "plane_strain", "plane_stress"))
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


@pytest.mark.parametrize("hypothesis", ("3d", "plane_strain", "plane_stress"))
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


def wrong_step(monkeypatch, only=None):
    """The tangent starts from the history of the trial, not from the committed one: that of the next step. With `only`
    one internal variable is, where expressions of all would take the compiler minutes."""
    right = consistent_tangent.consistent_tangent

    def wrong(u, du, v, response, kinematics, symbols, dx):
        update = response.respond(kinematics.strain(u), dict(symbols.history), symbols.unknown)
        after = {symbol: update.outputs[name] for name, symbol in symbols.history.items()
                 if only in (None, name)}  # fmt: skip
        return ufl.replace(right(u, du, v, response, kinematics, symbols, dx), after)

    monkeypatch.setattr(consistent_tangent, "consistent_tangent", wrong)


# The last one's expressions keep the compiler busy for half a minute.
@pytest.mark.parametrize(
    "name", ("linear", "armstrong_frederick", pytest.param("voce_armstrong_frederick", marks=pytest.mark.slow))
)
def test_a_tangent_of_the_wrong_step_is_seen(name, monkeypatch):
    report = Report()
    material_tangent.taylor(report, *tangent_case(name))
    assert report.passed
    wrong_step(monkeypatch, law.BACK_STRESS if name.startswith("voce") else None)
    material_tangent.taylor(report, *tangent_case(name))
    assert [row.passed for row in report.rows] == [True, False] and report.rows[1].note


def test_a_tangent_at_a_constant_thickness_is_seen(monkeypatch):
    """The stretch across the plane does not follow the displacement."""
    right = consistent_tangent.solve

    def wrong(A, b):
        x = right(A, b)
        return [x[0], 0 * x[1]]

    monkeypatch.setattr(consistent_tangent, "solve", wrong)
    report = Report()
    material_tangent.taylor(report, *tangent_case("voce_armstrong_frederick"))
    assert not report.passed


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


def test_trials_that_commit_are_seen(monkeypatch):
    """Every iteration of a static problem commits its history."""
    commit_at_once(monkeypatch)
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


# --- faults of bodies: each row of the levels solution and history ----------------------------------------------------

STATIC = ("quadrilateral", 1, "plane_strain", False, True, "prager")


def names_of(rows):
    """Quantities of rows: the names up to " of "."""
    return {row.name.split(" of ")[0] for row in rows}


def body_reports():
    """Reports of a static body and of an impact, both small."""
    reports = Report(), Report()
    plastic_bodies.static(reports[0], *STATIC)
    plastic_bodies.impact(reports[1], *STATIC)
    return reports


ROWS_OF_BODIES = (
    {"u", "reactions", "largest plastic strain"},
    {"displacement", "velocity", "kinetic energy", "internal energy", "plastic energy"},
)


def test_rows_of_bodies_pass():
    for report, names in zip(body_reports(), ROWS_OF_BODIES):
        assert report.passed and names_of(report.rows) == names


def test_a_history_committed_twice_is_seen_in_bodies(monkeypatch, own_cache):
    """Each step adds its increments twice: every row of both levels fails."""
    wrong_law(monkeypatch, stretched(2.0, [law.PLASTIC_STRAIN, law.PLASTIC_TENSOR]))
    for report, names in zip(body_reports(), ROWS_OF_BODIES):
        assert names_of(report.failures()) == names


def test_a_dilatation_that_is_not_averaged_is_seen_in_bodies(monkeypatch, own_cache):
    right = J2Plasticity.kinematics

    def wrong(self, mesh, degree):
        found = right(self, mesh, degree)
        found.average = False
        return found

    monkeypatch.setattr(J2Plasticity, "kinematics", wrong)
    for report, names in zip(body_reports(), ROWS_OF_BODIES):
        assert names_of(report.failures()) == names


def test_a_mean_in_the_place_of_the_linear_fit_is_seen(monkeypatch, own_cache):
    """Cells of degree 2: the projection on linear functions is the right one, and matters."""
    case = ("quadrilateral", 2, "plane_strain", False, "linear", "prager")
    report = Report()
    plastic_bodies.static(report, *case)
    assert report.passed
    right = J2Plasticity.kinematics

    def wrong(self, mesh, degree):
        found = right(self, mesh, degree)
        found.linear = False
        return found

    monkeypatch.setattr(J2Plasticity, "kinematics", wrong)
    report = Report()
    plastic_bodies.static(report, *case)
    assert names_of(report.failures()) == ROWS_OF_BODIES[0]


def test_a_wrong_stored_energy_is_seen(monkeypatch, own_cache):
    """Energies only: the motion is right. What is not stored counts as plastic."""

    def change(self, update, strain, history):
        update.stored = (1 + 1e-6) * update.stored
        return update

    wrong_law(monkeypatch, change)
    report = Report()
    plastic_bodies.impact(report, *STATIC)
    assert names_of(report.failures()) == {"internal energy", "plastic energy"}


def test_an_evaluation_more_in_every_step_is_seen(monkeypatch):
    """A second evaluation, at a displacement a little larger, that starts from the history of the first."""
    right = InternalForce.assemble

    def wrong(self, values):
        right(self, values)
        self.history.commit()
        u = next(c for c in self.compiled.coefficients if getattr(c, "name", "") == "u")
        here = u.x.array.copy()
        u.x.array[:] *= 1.01
        right(self, np.zeros_like(values))
        u.x.array[:] = here

    monkeypatch.setattr(InternalForce, "assemble", wrong)
    assert difference("linear") > 1e3 * material.TOLERANCE


def test_results_that_are_not_numbers_are_seen(monkeypatch, own_cache):
    """A law that returns NaN once it flows: no row takes it for a small difference."""

    def change(self, update, strain, history):
        flows = ufl.gt(update.outputs[law.PLASTIC_STRAIN] - history[law.PLASTIC_STRAIN], 1e-3)
        update.stress = update.stress * ufl.conditional(flows, ufl.ln(-1 - history[law.PLASTIC_STRAIN]), 1)
        return update

    wrong_law(monkeypatch, change)
    found = material.compare(case_of("linear"), "3d", False, num=NUM)
    assert np.isnan(found["stress"])
    report = Report()
    report.add("material", "j2", "tetrahedron", 1, 1, "3d", found["stress"], material.TOLERANCE, "", "stress", "")
    assert not report.passed
    assert np.isnan(material.dissipation(case_of("linear"), "3d", False, num=NUM))


@pytest.mark.slow
@pytest.mark.parametrize("name, finite", [("linear", True), ("prager", False)])
def test_flow_against_the_stress_is_seen_in_other_laws(name, finite, monkeypatch, own_cache):
    right = material.dissipation(case_of(name), "3d", finite, num=NUM)
    wrong_law(monkeypatch, stretched(-0.1, [law.PLASTIC_TENSOR]))
    wrong = material.dissipation(case_of(name), "3d", finite, num=NUM)
    assert right <= material.TOLERANCE < 1e-4 < wrong


def test_a_wrong_stress_across_the_plane_is_seen(monkeypatch, own_cache):
    """Plane stress that leaves a thousandth of the stress across the plane."""

    def change(self, update, strain, history):
        across = update.residual[1] - 1e-3 * update.stress[0, 0] / (self.kappa + 4 / 3 * self.mu)
        update.residual = ufl.as_vector([update.residual[0], across])
        return update

    assert difference("linear", "plane_stress") <= material.TOLERANCE
    wrong_law(monkeypatch, change)
    assert difference("linear", "plane_stress") > 1e3 * material.TOLERANCE
