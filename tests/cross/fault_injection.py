# SPDX-License-Identifier: MIT
"""Faults that tests of verify inject, and checks of the reports that must show them."""

import numpy as np

from dolfinx_impact import _cpp
from dolfinx_impact.statics.material_body import MaterialBody
from impact_verify import element
from impact_verify.report import Report


def scaled(function, factor):
    """The function with its result multiplied; tuples item by item."""

    def wrong(*args, **kwargs):
        result = function(*args, **kwargs)
        return tuple(factor * r for r in result) if isinstance(result, tuple) else factor * result

    return wrong


def one_entry(function, index, factor):
    """The function with one entry of the array it returns multiplied."""

    def wrong(*args, **kwargs):
        result = np.array(function(*args, **kwargs))
        result[index] *= factor
        return result

    return wrong


def element_report(*cases, count=10):
    report = Report()
    element.run(report, cases, count, progress=False)
    return report


def assert_healthy(report, level, num_rows=None):
    assert report.passed, [(r.form, r.difference, r.note) for r in report.failures()]
    assert {r.level for r in report.rows} == {level}
    assert num_rows is None or len(report.rows) == num_rows


def assert_caught(report, level, form, name=""):
    """The report fails, by rows of this level and form only; returns the first of them, whose note says something."""
    assert not report.passed
    failures = report.failures()
    assert failures and {(r.level, r.form) for r in failures} == {(level, form)}
    found = [r for r in failures if name in r.name]
    assert found and all(r.note for r in found), failures
    return found[0]


def commit_at_once(monkeypatch):
    """Bodies that end a step with every residual."""

    def wrong(self):
        right = self._cpp_object

        def residual():
            b = right.residual()
            right.accept_step()
            return b

        return _cpp.solve.FunctionBody(
            residual=residual, tangent=right.tangent, fault=right.fault, accept_step=right.accept_step, origin=None,
            stored_energy=None, properties=right.properties,
        )  # fmt: skip

    monkeypatch.setattr(MaterialBody, "in_cpp", wrong)
