# SPDX-License-Identifier: MIT
"""Contact without pairs at quadrature points in `verify`: healthy, and broken on either side."""

import impact_reference
import numpy as np
import pytest
from fault_injection import assert_healthy

import dolfinx_impact as di
from impact_verify import general_static
from impact_verify.contact_bodies import SLAVE
from impact_verify.report import Report

CASES = (("triangle", "plane_strain", 2), ("quadrilateral", "axisymmetric", 1), ("tetrahedron", "3d", 1))
FORMS = {f"contact.general_static_{what}" for what in ("gap", "normal", "status", "pressure", "force", "tangent")}


def rows(case=CASES[0]):
    report = Report()
    general_static.compare(report, *case)
    return report


def failed(case=CASES[0]):
    return {r.form.removeprefix("contact.general_static_") for r in rows(case).failures()}


@pytest.mark.parametrize("case", CASES)
def test_both_sides_agree(case):
    report = rows(case)
    assert_healthy(report, "contact", 6)
    assert {r.form for r in report.rows} == FORMS
    assert all(np.abs(r.difference) < 1e-12 for r in report.rows)
    assert not any("all values of the hand-written side are zero" in r.note for r in report.rows)


def test_a_penalty_that_is_wrong(monkeypatch):
    right = impact_reference.Contact.penalty
    monkeypatch.setattr(
        impact_reference.Contact, "penalty", lambda self, u, chi, *others: right(self, u, chi * (1 + 1e-6), *others)
    )
    assert failed() == {"pressure", "force", "tangent"}


def test_one_way_that_is_left_out(monkeypatch):
    """Points of one surface meet the other one, those of the other do not."""
    right = impact_reference.Contact.penalty

    def one_way(self, u, *others):
        result = right(self, u, *others)
        if self.slave_is_above:
            return result
        result.force = 0.0 * result.force
        return result

    made = impact_reference.Contact.__init__
    count = []

    def marked(self, *given, **options):
        made(self, *given, **options)
        count.append(self)
        self.slave_is_above = len(count) % 2 == 1

    monkeypatch.setattr(impact_reference.Contact, "__init__", marked)
    monkeypatch.setattr(impact_reference.Contact, "penalty", one_way)
    assert failed() == {"force"}


def test_another_friction(monkeypatch):
    right = di.GeneralContact.__init__

    def slippery(self, facet_tags, tags=None, friction=0.0, name="general contact"):
        assert SLAVE in tags
        right(self, facet_tags, tags, friction * (1 - 1e-6), name)

    monkeypatch.setattr(di.GeneralContact, "__init__", slippery)
    assert {"force", "tangent"} <= failed(CASES[1])
