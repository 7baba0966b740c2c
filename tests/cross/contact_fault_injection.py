# SPDX-License-Identifier: MIT
"""Faults that tests of level contact inject into the hand-written solver; runs of patches and solutions."""

import impact_reference
import numpy as np

from impact_verify import contact, contact_static
from impact_verify.report import Report

PATCH = ("quadrilateral", "plane_strain", 1, 1)


def patches(case=PATCH):
    report = Report()
    contact.patches(report, *case)
    return report


def solutions(friction=0.0, law="linear_elastic"):
    report = Report()
    contact_static.compare_methods(
        report, "friction" if friction else "static", contact_static.pressed(*PATCH[:3], friction)
    )
    return report


def failed(report, at_least, not_in=()):
    """The forms that failed hold these and none of those; returns the failed rows."""
    forms = {r.form.removeprefix("contact.") for r in report.failures()}
    assert forms >= set(at_least) and not forms & set(not_in), forms
    assert all(r.level == "contact" and r.note for r in report.failures())
    return report.failures()


def of_theirs(monkeypatch, method, change):
    right = getattr(impact_reference.Contact, method)

    def wrong(self, *args, **kwargs):
        answer = right(self, *args, **kwargs)
        change(answer)
        return answer

    monkeypatch.setattr(impact_reference.Contact, method, wrong)


def times(factor):
    def change(matrix):
        if matrix.data.size:  # nodes on an obstacle have no M
            matrix.data[np.argmax(np.abs(matrix.data))] *= factor

    return change
