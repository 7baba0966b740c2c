# SPDX-License-Identifier: MIT
"""Level contact, tied surfaces: healthy, and broken on either side."""

import impact_reference
import numpy as np
import pytest
from fault_injection import assert_healthy

from dolfinx_impact import contact
from impact_verify import tied
from impact_verify.contact_static import pressed
from impact_verify.report import Report

CASE = ("quadrilateral", "plane_strain", 1)


def rows():
    report = Report()
    tied.at_rest(report, pressed(*CASE))
    tied.in_time(report, pressed(*CASE))
    return report


def failed(report):
    assert all(r.level == "contact" and r.note for r in report.failures())
    return {r.form.removeprefix("contact.") for r in report.failures()}


def test_both_sides_agree():
    report = rows()
    assert_healthy(report, "contact", 7)
    assert {r.form for r in report.rows} == {"contact.tied_static", "contact.tied_history"}


def test_a_condition_that_is_wrong(monkeypatch):
    """One entry of C by a part in a million."""
    right = impact_reference.Tie.__init__

    def wrong(self, *args):
        right(self, *args)
        self.conditions[0, np.argmax(np.abs(self.conditions[0]))] *= 1 + 1e-6

    monkeypatch.setattr(impact_reference.Tie, "__init__", wrong)
    assert failed(rows()) == {"tied_static", "tied_history"}


def test_a_tie_along_the_normal_alone(monkeypatch):
    right = contact.Tie.__init__
    monkeypatch.setattr(
        contact.Tie, "__init__", lambda self, pair, **options: right(self, pair, directions="normal", **options)
    )
    assert failed(rows()) == {"tied_static", "tied_history"}


@pytest.mark.parametrize("name", ["multipliers", "force"])
def test_results_that_are_wrong(monkeypatch, name):
    right = impact_reference.Tie._solution

    def wrong(self, u, z):
        found = right(self, u, z)
        getattr(found, name)[...] *= 1 + 1e-6
        return found

    monkeypatch.setattr(impact_reference.Tie, "_solution", wrong)
    assert failed(rows()) >= {"tied_static"}
