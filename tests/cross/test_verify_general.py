# SPDX-License-Identifier: MIT
"""Contact without pairs in `verify`: healthy, and broken on either side."""

import impact_reference
import numpy as np
import pytest
import scenario_faults
from fault_injection import assert_healthy

from impact_verify import general
from impact_verify.report import Report
from impact_verify.scenarios import general_runs

FORMS = {f"contact.general_{what}" for what in ("force", "gap", "slip", "status")}


def case_of(cell, name):
    return next(case for case in general_runs.touching(cell, 1) if case.name.startswith(name))


def rows(cell, name):
    report = Report()
    general.compare(report, case_of(cell, name))
    return report


def failed(cell, name):
    report = rows(cell, name)
    assert all(r.level == "contact" and r.note for r in report.failures())
    return {r.form.removeprefix("contact.general_") for r in report.failures()}


@pytest.mark.parametrize(
    "cell,name",
    (
        ("triangle", "strip"),
        ("quadrilateral", "block on"),
        ("hexahedron", "crossed"),
        ("hexahedron", "sliding prism"),
        ("quadrilateral", "block in a notch"),
        ("tetrahedron", "block in a notch"),
    ),
)
def test_both_sides_agree(cell, name):
    report = rows(cell, name)
    assert_healthy(report, "contact", 4)
    assert {r.form for r in report.rows} == FORMS
    assert all(np.abs(r.difference) < r.tolerance for r in report.rows)
    assert all("all values of the hand-written side are zero" not in r.note for r in report.rows if "force" in r.form)


@pytest.mark.parametrize("cell,name", (("quadrilateral", "strip"), ("tetrahedron", "crossed")))
def test_stiffness_that_is_wrong(monkeypatch, cell, name):
    """Springs of the other side, for bodies that are stiffer by a part in a million."""
    right = impact_reference.GeneralContact._bind

    def wrong(self, model, *others):
        law = next(iter(model.materials.values()))
        stiffer = impact_reference.Material(law.E * (1.0 + 1e-6), law.nu, law.density, law.hypothesis, law.law)
        changed = impact_reference.Model(model.points, model.cells, model.cell_type, stiffer)
        return right(self, changed, *others)

    monkeypatch.setattr(impact_reference.GeneralContact, "_bind", wrong)
    assert "force" in failed(cell, name)


def test_a_facet_that_is_left_out(monkeypatch):
    """Nodes that fall through one facet of the thin plate."""
    right = impact_reference.GeneralContact.__init__

    def wrong(self, facets, friction=0.0):
        right(self, facets, friction)
        x = case.body.points[self.facets].mean(axis=1)
        self.facets = np.delete(self.facets, np.argmin(np.linalg.norm(x - (0.5, 1.0), axis=1)), axis=0)

    case = case_of("quadrilateral", "block on a thin plate")
    monkeypatch.setattr(impact_reference.GeneralContact, "__init__", wrong)
    report = Report()
    general.compare(report, case)
    assert {r.form for r in report.failures()} >= {"contact.general_force", "contact.general_gap"}


def test_an_end_that_is_left_out(monkeypatch):
    """Of a notch between two bodies, the lowest facet of one: nodes in it have one spring less."""
    right = impact_reference.GeneralContact.__init__

    def wrong(self, facets, friction=0.0):
        right(self, facets, friction)
        x = case.body.points[self.facets].mean(axis=1)
        which = np.where((x[:, 0] < 0.0) & (x[:, 1] > 0.0), np.linalg.norm(x, axis=1), np.inf)
        self.facets = np.delete(self.facets, np.argmin(which), axis=0)

    case = case_of("triangle", "block in a notch")
    monkeypatch.setattr(impact_reference.GeneralContact, "__init__", wrong)
    report = Report()
    general.compare(report, case)
    assert {r.form for r in report.failures()} >= {"contact.general_force"}


def test_histories_with_another_friction():
    """A run in time with a coefficient that is larger by a part in a million: displacements and energies differ."""
    case = case_of("quadrilateral", "two blocks")
    body = case.body
    right = body.friction

    class Other(type(body)):
        pass

    other = Other.__new__(Other)
    other.__dict__.update(body.__dict__)
    other.friction = right * (1.0 + 1e-6)
    assert scenario_faults.failed(case, 60) == set()
    assert scenario_faults.failed(case, 60, body=other) >= {"displacement", "velocity", "friction energy"}
