# SPDX-License-Identifier: MIT
"""Rows of stick and slip in `verify`: they pass, and a fault of a hundredth on either side, ten times the tolerance, is
seen."""

import impact_reference
from dolfinx_impact import interface
from impact_verify import stick_slip
from impact_verify.report import Report


def failures(*cells):
    report = Report(cells=cells or ["quadrilateral"])
    stick_slip.run(report)
    assert len(report.rows) == len(cells or "1") and all(r.level == "contact" for r in report.rows)
    return {r.cell for r in report.failures()}


def test_all_rows_pass():
    assert failures("quadrilateral", "hexahedron") == set()


def test_a_fault_of_the_coefficient(monkeypatch):
    right = interface.FrictionLaw.coefficient
    monkeypatch.setattr(interface.FrictionLaw, "coefficient", lambda self, point: 1.01 * right(self, point))
    assert failures() == {"quadrilateral"}


def test_a_fault_of_the_hand_written_mass(monkeypatch):
    slip = impact_reference.SlidingMass._slip
    monkeypatch.setattr(impact_reference.SlidingMass, "_slip", lambda *args: 0.99 * slip(*args))
    assert failures() == {"quadrilateral"}
