# SPDX-License-Identifier: MIT
"""Implicit runs of `verify`: both sides agree, and every kind of fault on one side is seen."""

import copy
import functools
import itertools

import numpy as np
import pytest
import scenario_faults
from fault_injection import commit_at_once

from dolfinx_impact._cpp.integrators import ImplicitScheme
from dolfinx_impact.contact.mortar.lagrange import LagrangeContact
from dolfinx_impact.contact.penalty.quadrature_penalty import QuadraturePenalty
from dolfinx_impact.assembly.consistent_mass import ConsistentMass
from dolfinx_impact.dynamics.implicit import newmark_problem as implicit_problem
from dolfinx_impact.dynamics.implicit.damping import DampingForce
from dolfinx_impact.dynamics.implicit.mass_redistribution import MassRedistribution
from impact_verify import cross_check, runs_in_time, yielding_runs
from impact_verify.report import Report
from impact_verify.scenarios import implicit_runs as implicit
from impact_verify.scenarios import our_adapter

STEPS = 60  # a fault shows soon
SMALL = 1 + 1e-6


@functools.cache
def cases(make, cell="quadrilateral", degree=1):
    return {case.name: case for case in make(cell, degree)}


def case_of(name):
    makes = (implicit.without_contact, implicit.bars, implicit.disc, implicit.rigid)
    return next(cases(make)[name] for make in makes if name in cases(make))


def report_of(case, steps=STEPS):
    report = Report()
    runs_in_time.compare(report, case, steps)
    return report


def failed(case, **changes):
    """What a comparison sees when our side runs a changed case."""
    return scenario_faults.failed(case, STEPS, **changes)


@pytest.mark.long_rows(where=lambda make: make is implicit.without_contact)
@pytest.mark.parametrize("make", (implicit.without_contact, implicit.bars, implicit.disc, implicit.rigid))
def test_rows_pass(make):
    """Schemes, masses, damping, loads, supports that move; penalty and multipliers, friction, two bodies, obstacles."""
    for case in cases(make).values():
        report = report_of(case)
        assert report.passed and len(report.rows) >= 5, (case.name, [(r.name, r.note) for r in report.failures()])
        assert {r.level for r in report.rows} == {"history"}
        if case.contact:
            assert any(r.name.startswith("contact force") for r in report.rows)


@pytest.mark.slow
def test_rows_of_other_cells_pass():
    report = Report()
    runs_in_time.compare(report, next(iter(implicit.without_contact("tetrahedron", 2))), 30)
    for case in implicit.blocks("hexahedron", 1):
        runs_in_time.compare(report, case, 8)
    for case in implicit.varied_runs("triangle", 1, implicit.bars, (7,)):  # a variation that the level has not
        runs_in_time.compare(report, case, 100)
    assert report.passed and len(report.rows) > 25


@pytest.mark.slow
def test_all_rows_pass():
    report = Report()
    runs_in_time.run_implicit(report)
    yielding_runs.run(report)
    assert report.passed and len(report.rows) > 250


def test_runs_belong_to_the_level(monkeypatch):
    """`cross_check` runs them with the level history."""
    called = []
    monkeypatch.setattr(runs_in_time, "run", lambda *a: None)
    monkeypatch.setattr("impact_verify.plastic_bodies.history_rows", lambda *a: None)
    monkeypatch.setattr(runs_in_time, "run_implicit", called.append)
    monkeypatch.setattr(yielding_runs, "run", called.append)
    report = cross_check(levels=["history"])
    assert len(called) == 2 and called[0] is called[1] is report


def yielding(steps=STEPS):
    report = Report()
    yielding_runs.compare(report, *yielding_runs.YIELDING[0], steps=steps)
    return report


def test_yielding_rows_pass():
    report = yielding()
    assert report.passed
    assert {"plastic energy", "damping energy"} <= {row.name.split(" of the ")[0] for row in report.rows}


# --- faults ----------------------------------------------------------------------------------------------------------


def change_scheme(monkeypatch, change):
    """Let problems take the parameters that a function makes of those of their schemes."""
    right = implicit_problem.scheme_of
    monkeypatch.setattr(implicit_problem, "scheme_of", lambda *arguments: ImplicitScheme(*change(right(*arguments))))


def test_exchanged_parameters_are_seen(monkeypatch):
    """beta in the velocity and gamma in the displacement, as seed (3.81) may be read."""
    change_scheme(monkeypatch, lambda s: (s.gamma, s.beta, s.alpha_m, s.alpha_f))
    for name in ("shaken block", "support that moves, first order"):
        assert {"displacement", "velocity", "acceleration", "kinetic energy"} <= failed(case_of(name))


def test_inertia_of_the_mean_acceleration_is_seen(monkeypatch):
    """M A in place of M a, which are the same without alphas."""
    change_scheme(monkeypatch, lambda s: (s.beta, s.gamma, 0.0, 0.0))
    assert not failed(case_of("shaken block"))
    assert "displacement" in failed(case_of("damped block under a load, generalised-alpha"))
    assert "displacement" in failed(case_of("shaken block, HHT, lumped"))


@pytest.mark.parametrize("name", ("two bars, lagrange", "two bars, penalty", "ring on a rigid plane, lagrange"))
def test_contact_mass_that_is_kept_is_seen(name):
    assert {"displacement", "contact force"} <= failed(case_of(name), impact="none")


def test_history_that_is_committed_too_soon_is_seen(monkeypatch):
    """After every residual in place of the end of the step. (Twice at the end would be no fault: a return mapping from
    its own result does nothing.)"""
    commit_at_once(monkeypatch)
    report = yielding()
    assert {"displacement", "plastic energy"} <= {row.name.split(" of the ")[0] for row in report.failures()}


def test_friction_that_is_committed_twice_is_seen(monkeypatch, contacts_in_python):
    right = LagrangeContact.accept_step

    def wrong(self):
        right(self)
        right(self)

    monkeypatch.setattr(LagrangeContact, "accept_step", wrong)
    assert "friction energy" in failed(case_of("disc on a block, lagrange"))


def test_friction_that_is_not_committed_is_seen(monkeypatch, contacts_in_python):
    """In every other step. (Twice would be no fault with penalty: it takes over the state of the last residual.)"""
    right, count = QuadraturePenalty.accept_step, itertools.count()
    monkeypatch.setattr(QuadraturePenalty, "accept_step", lambda self: right(self) if next(count) % 2 else None)
    assert {"displacement", "friction energy"} <= failed(case_of("disc on a block, penalty"))


def test_damping_at_the_old_velocity_is_seen(monkeypatch):
    """At that of the evaluation before."""
    right = DampingForce.forces

    def wrong(self):
        now = self.velocity.x.array.copy()
        self.velocity.x.array[:], self.before = getattr(self, "before", now), now
        found = right(self)
        self.velocity.x.array[:] = now
        return found

    monkeypatch.setattr(DampingForce, "forces", wrong)
    case = case_of("damped block under a load, generalised-alpha")
    assert {"displacement", "velocity", "damping energy"} <= failed(case)


def test_damping_with_the_stiffness_at_rest_is_seen():
    """What differs between a neo-Hookean body and a linear one that moves little."""
    case = case_of("damped block under a load, neo-Hookean, lumped")
    assert "displacement" in failed(case, damping=(0.1, 0.004 * SMALL))


def test_another_mass_is_seen(monkeypatch):
    right = ConsistentMass.assemble

    def wrong(self):
        matrix = right(self)
        matrix.scale(SMALL)
        return matrix

    monkeypatch.setattr(ConsistentMass, "assemble", wrong)
    assert {"displacement", "kinetic energy"} <= failed(case_of("shaken block"))


def test_velocity_of_massless_nodes_is_seen(monkeypatch):
    """Newmark's velocity at nodes without mass in place of the mean of the step."""
    right = MassRedistribution.__init__

    def wrong(self, *arguments):
        right(self, *arguments)
        self.massless[:] = False

    monkeypatch.setattr(MassRedistribution, "__init__", wrong)
    assert "velocity" in failed(case_of("two bars, lagrange"))


@pytest.mark.parametrize(
    "name, changes, seen",
    (
        ("shaken block", {"damping": (1e-6, 0.0)}, {"displacement", "velocity", "damping energy"}),
        ("damped block under a load, generalised-alpha", {"parameters": {"rho_inf": 0.6 * SMALL}}, {"displacement"}),
        ("shaken block, HHT, lumped", {"parameters": {"hht": -0.1 * SMALL}}, {"displacement"}),
        ("shaken block, HHT, lumped", {"lumping": None}, {"displacement", "kinetic energy"}),
        ("support that moves, first order", {"motion": lambda t: 0.02 * SMALL * np.sin(3 * t)}, {"external energy"}),
        ("body on normal springs, linear-elastic", {"foundation": (0.4 * SMALL, 0.0)}, {"displacement"}),
        (
            "body on springs and dashpots, linear-elastic, HHT",
            {"foundation": (np.array([0.3, 0.5]), 0.2 * SMALL)},
            {"velocity", "damping energy"},
        ),
        (
            "body on normal springs and dashpots, with mass, neo-hookean, HHT",
            {"added_mass": 0.7 * SMALL},
            {"displacement", "kinetic energy"},
        ),
        ("shaken block", {"gravity": (np.array([0.0, -1e-6]), lambda t: 1.0)}, {"external energy"}),
        (
            "block under a rigid cylinder that moves, lagrange",
            {"obstacle": lambda t: np.array([0.01 * t, -0.03 * SMALL * np.sin(t / 4)])},
            {"contact force", "external energy"},
        ),
    ),
)
def test_a_fault_in_what_is_given_is_seen(name, changes, seen):
    assert seen <= failed(case_of(name), **changes)


@pytest.mark.parametrize("method", ("penalty", "lagrange"))
def test_another_friction_is_seen(method):
    case = case_of(f"disc on a block, {method}")
    changed = copy.copy(case.body)
    changed.friction *= SMALL
    assert {"contact force", "friction energy"} <= failed(case, body=changed)


def test_another_number_of_steps_is_seen(monkeypatch):
    """A step that our side cuts in half does not go unnoticed."""
    ours, report = our_adapter.run, Report()
    monkeypatch.setattr(our_adapter, "run", lambda case, steps: ours(case, steps + 1))
    runs_in_time.compare(report, case_of("shaken block"), 5)
    assert not any(row.passed for row in report.rows) and "steps" in report.rows[0].note
