# SPDX-License-Identifier: MIT
"""Rows of the laws of the interface in `verify`: all pass, and a fault on either side is seen by the law it is in."""

import impact_reference
import numpy as np
import pytest
from dolfinx_impact import interface
from impact_verify import interface_laws
from impact_verify.report import Report

LAWS = tuple(interface_laws.laws())


def failures(*cells):
    report = Report(cells=cells or ["quadrilateral"])
    interface_laws.run(report)
    assert len(report.rows) == len(LAWS) * len(cells or "1") and all(r.level == "contact" for r in report.rows)
    return {r.form.removeprefix("contact.interface.") for r in report.failures()}


def test_all_rows_pass():
    assert failures("quadrilateral", "hexahedron") == set()


FAULTS = {
    "spring_pressure": (lambda p, e: (1.000001 * p, e), {"friction", "falling_friction"}),
    "exponential_pressure": (lambda p, e: (p, 1.001 * e), {"exponential_pressure"}),
    "adhesive_pressure": (lambda p, e: (-p, e), {"adhesion"}),
    "damped_pressure": (lambda p, e: (p, 0.0), {"damped_contact"}),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_of_the_hand_written_pressure(name, monkeypatch):
    right, (change, expected) = getattr(impact_reference, name), FAULTS[name]
    monkeypatch.setattr(impact_reference, name, lambda *args: change(*right(*args)))
    assert failures() == expected


@pytest.mark.parametrize("name, laws", [("cohesive_history", {"cohesive_zone"}),
                                        ("friction_history", {"friction", "falling_friction"})])  # fmt: skip
def test_a_fault_of_the_hand_written_history(name, laws, monkeypatch):
    right = getattr(impact_reference, name)

    def wrong(*args):
        answer = right(*args)
        answer.shear[29] *= 1.0 + 1e-9  # of one step alone
        return answer

    monkeypatch.setattr(impact_reference, name, wrong)
    assert failures() == laws


def test_a_fault_of_the_package(monkeypatch):
    right = interface.InterfaceLaw._coulomb

    def wrong(self, point, given):
        shear, slid, sticks, energy = right(self, point, given)
        return shear, slid, sticks, 1.0001 * energy

    monkeypatch.setattr(interface.InterfaceLaw, "_coulomb", wrong)
    assert failures() == {"friction", "falling_friction"}


def test_rows_of_one_cell_alone():
    report = Report(cells=["hexahedron"])
    interface_laws.run(report)
    assert {r.cell for r in report.rows} == {"hexahedron"} and np.all([r.passed for r in report.rows])
