# SPDX-License-Identifier: MIT
"""Rows of averaged pressure and strain pass; a fault of either side is seen."""

import impact_reference as ref
import pytest
from impact_verify import averaged_pressure, plastic_bodies
from impact_verify.report import Report

import dolfinx_impact as di
from dolfinx_impact.forms import averaged_pressure as forms
from dolfinx_impact.forms import averaged_strain

CASE = ("tetrahedron", "3d", "j2.finite")
STRAINED = ("tetrahedron", "3d", "linear_elastic", "averaged_strain")


def reports(case=CASE):
    found = Report(), Report()
    averaged_pressure.static(found[0], *case)
    plastic_bodies.compare_runs(found[1], averaged_pressure.AveragedBodies(*case), 60)
    return found


@pytest.mark.parametrize("case", [CASE, STRAINED])
def test_rows_pass(case):
    for report in reports(case):
        assert report.passed, [row.name for row in report.failures()]


def test_another_share_of_strains_on_our_side_is_seen(monkeypatch):
    """Nodes have another part of the deviator, by their kernels in equilibria and by the matrix in runs."""
    monkeypatch.setattr(averaged_strain, "SHARE", averaged_strain.SHARE * (1 + 1e-5))
    for report in reports(STRAINED):
        assert not report.passed


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
    rows = {how: {law for _, _, law, of in averaged_pressure.BODIES if of == how} for how in di.materials.AVERAGED}
    assert rows["averaged_pressure"] == {*forms.LAWS, "j2.small", "j2.finite"}
    assert rows["averaged_strain"] == {*averaged_strain.LAWS}
