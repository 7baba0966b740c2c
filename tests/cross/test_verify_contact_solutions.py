# SPDX-License-Identifier: MIT
"""Level contact, whole solutions: broken on either side."""

import numpy as np
import pytest
from contact_fault_injection import failed, of_theirs, solutions
from fault_injection import assert_healthy

from dolfinx_impact import contact as contact_package
from dolfinx_impact.contact.mortar.lagrange import LagrangeContact
from dolfinx_impact.contact.penalty.quadrature_penalty import QuadraturePenalty
from impact_verify import contact_static
from impact_verify.report import Report


def test_multipliers_that_are_never_augmented(monkeypatch, contacts_in_python):
    monkeypatch.setattr(QuadraturePenalty, "augment", lambda self: False)
    failed(solutions(), ["static_augmented"], ["static_penalty", "static_lagrange"])


def test_one_round_of_augmentation_too_few(monkeypatch, contacts_in_python):
    right, seen = QuadraturePenalty.augment, []

    def wrong(self):
        seen.append(self)
        return right(self) if len(seen) < 3 else False

    monkeypatch.setattr(QuadraturePenalty, "augment", wrong)
    failed(solutions(), [], ["static_lagrange"])
    assert len(seen) >= 3


@pytest.mark.long_rows(where=lambda shape: shape == "Cylinder")
@pytest.mark.parametrize("shape", ["Sphere", "Cylinder"])
def test_a_solution_under_another_radius(shape):
    case = contact_static.under_obstacle("tetrahedron", "3d", 1, shape=shape)
    report = Report()
    contact_static.compare_methods(report, "static", case)
    assert_healthy(report, "contact", 15)
    assert all(shape.lower() in r.name for r in report.rows)
    case.body.rigid[1].radius *= 1 + 1e-6
    report = Report()
    contact_static.compare_methods(report, "static", case)
    failed(report, ["static_penalty", "static_augmented", "static_lagrange"])


@pytest.mark.parametrize("method, form", [("solve_penalty", "static_penalty"), ("solve_lagrange", "static_lagrange")])
@pytest.mark.parametrize(
    "name, what", [("u", "u of"), ("contact_force", "contact force of"), ("pressure", "pressure of")]
)
def test_a_solution_off_by_one_millionth(method, form, name, what, monkeypatch):
    of_theirs(monkeypatch, method, lambda s: setattr(s, name, getattr(s, name) * (1 + 1e-6)))
    rows = failed(solutions(), [form])
    forms = [form] + ["static_augmented"] * (method == "solve_penalty")
    assert [r.form for r in rows] == [f"contact.{f}" for f in forms] and all(what in r.name for r in rows)


@pytest.mark.parametrize("method", ["solve_penalty", "solve_lagrange"])
def test_a_status_that_differs_at_one_place(method, monkeypatch):
    def change(solution):
        k = np.flatnonzero(solution.status)[0]
        solution.status[k] = 0

    of_theirs(monkeypatch, method, change)
    number = 2 if method == "solve_penalty" else 1  # augmented as well
    assert [r.name.split()[0] for r in failed(solutions(), [])] == ["status"] * number


def test_another_penalty(monkeypatch):
    right = contact_package.Penalty.__init__
    monkeypatch.setattr(contact_package.Penalty, "__init__",
                        lambda self, pair, p, *a, **k: right(self, pair, p * (1 + 1e-5), *a, **k))  # fmt: skip
    failed(solutions(), ["static_penalty"], ["static_lagrange"])


def test_nodes_that_stick_where_they_should_slip(monkeypatch, contacts_in_python):
    """Half of the law of friction: nodes that should slip stick."""
    right = LagrangeContact.update_active_set

    def wrong(self, first, last=None):
        before = self.active
        right(self, first, last)
        self.sliding = np.zeros_like(before)
        return int(np.count_nonzero(before != self.active))

    monkeypatch.setattr(LagrangeContact, "update_active_set", wrong)
    failed(solutions(0.3), ["friction_lagrange"], ["friction_penalty"])
