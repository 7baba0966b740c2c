# SPDX-License-Identifier: MIT
"""Rows of averaged pressure pass; a fault of either side is seen."""

import impact_reference as ref
import pytest
from impact_verify import averaged_pressure, plastic_bodies
from impact_verify.report import Report

import dolfinx_impact as di
from dolfinx_impact.forms import averaged_pressure as forms

CASE = ("tetrahedron", "3d", "j2.finite")


def reports():
    found = Report(), Report()
    averaged_pressure.static(found[0], *CASE)
    plastic_bodies.compare_runs(found[1], averaged_pressure.AveragedBodies(*CASE), 60)
    return found


def test_rows_pass():
    for report in reports():
        assert report.passed, [row.name for row in report.failures()]


def test_another_share_on_our_side_is_seen(monkeypatch):
    """Cells keep another part of their own pressure."""
    monkeypatch.setattr(forms, "OWN_SHARE", forms.OWN_SHARE * (1 + 1e-5))
    for report in reports():
        assert not report.passed


@pytest.mark.parametrize("law", ["neo_hookean", "j2.finite"])
def test_plain_cells_on_the_other_side_are_seen(monkeypatch, law):
    kind = ref.Model if law == "neo_hookean" else ref.PlasticBody
    right = kind.__init__

    def plain(self, *arguments, averaged_pressure=False, **options):
        right(self, *arguments, **options)

    monkeypatch.setattr(kind, "__init__", plain)
    report = Report()
    averaged_pressure.static(report, "tetrahedron", "3d", law)
    assert not report.passed


def test_every_law_has_rows():
    assert {law for _, _, law in averaged_pressure.BODIES} == {*forms.LAWS, "j2.small", "j2.finite"}
    assert di.materials.AVERAGED_PRESSURE == "averaged_pressure"
