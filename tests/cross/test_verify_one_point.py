# SPDX-License-Identifier: MIT
"""Cells with one point in `verify`: healthy, and broken on either side."""

import impact_reference
import numpy as np
import pytest

from dolfinx_impact.forms import one_point as forms
from dolfinx_impact.forms import one_point_flow as flow
from impact_verify import element, one_point
from impact_verify.model_warnings import model_warnings_off
from impact_verify.report import Report
from impact_verify.scenarios.explicit_runs import FLOAT_STEPS, IN_FLOAT


def worst(law="linear_elastic", cell="quadrilateral", hypothesis="plane_strain"):
    return {kind: error for kind, (error, _) in one_point.element_differences(law, cell, hypothesis).items()}


@pytest.mark.parametrize(
    "law, cell, hypothesis", [("linear_elastic", "hexahedron", "3d"), ("neo_hookean", "quadrilateral", "plane_strain")]
)
def test_both_sides_agree(law, cell, hypothesis):
    found = worst(law, cell, hypothesis)
    assert set(found) == set(one_point.KINDS) and max(found.values()) < element.TOLERANCE


def test_motions_agree():
    with model_warnings_off():
        found = one_point.motion_differences("linear_elastic", "hexahedron", "3d")
    assert max(found.values()) < one_point.GROWTH, found


@pytest.mark.parametrize("law", ["linear_elastic", "neo_hookean"])
def test_motions_in_mixed_precision_agree(law):
    """They are not those of double: the largest difference is beyond the round-off of that."""
    with model_warnings_off():
        found = one_point.motion_differences(law, "hexahedron", "3d", "mixed", FLOAT_STEPS)
    assert one_point.GROWTH < max(found.values()) < IN_FLOAT[law].tolerance, found


@pytest.mark.parametrize("cell, hypothesis, finite", one_point.FLOWING)
def test_flowing_motions_agree(cell, hypothesis, finite):
    with model_warnings_off():
        found = one_point.flow_differences(cell, hypothesis, finite)
    assert max(found.values()) < one_point.GROWTH, found


@pytest.mark.parametrize("name, wrong", [("PLATE_LIMIT", 0.26), ("FACE", 0.49), ("TWIST_LIMIT", 0.05)])
def test_modes_that_flow_at_another_moment(monkeypatch, name, wrong):
    """Each constant of our modes is seen. The kernels are compiled with it once more."""
    monkeypatch.setattr(flow, name, wrong)
    with model_warnings_off():
        found = one_point.flow_differences("hexahedron", "3d", False)
    assert found["displacement"] > 10 * one_point.GROWTH


def test_rows_are_added(monkeypatch):
    monkeypatch.setattr(one_point, "element_differences", lambda *args: {"force": (0.0, "")})
    monkeypatch.setattr(one_point, "motion_differences", lambda *args: {"displacement": 0.0})
    monkeypatch.setattr(one_point, "flow_differences", lambda *args: {"displacement": 0.0})
    report = Report(cells=["hexahedron"])
    one_point.run_elements(report)
    one_point.run_motion(report)
    one_point.run_flow(report)
    assert {(r.level, r.form) for r in report.rows} == {
        (level, f"{law}.reduced{end}")
        for law in ("linear_elastic", "neo_hookean")
        for level, end in (("element", ".force"), ("history", ""))
    } | {("history", f"j2.{strain}.linear.reduced") for strain in ("small", "finite")}


def test_hourglass_stiffness_that_is_wrong_on_the_other_side(monkeypatch):
    right = impact_reference.one_point._weights
    monkeypatch.setattr(impact_reference.one_point, "_weights", lambda *args: (1 + 1e-6) * right(*args))
    assert min(worst().values()) > element.TOLERANCE


def test_shape_vectors_without_the_linear_part(monkeypatch):
    """Plain hourglass base vectors, which feel a linear displacement of distorted cells."""

    def wrong(cell_type, X, b):
        xi = impact_reference.reference_nodes(cell_type, 1)
        return np.array([xi[:, 0] * xi[:, 1]]) / len(xi)

    monkeypatch.setattr(impact_reference.one_point, "hourglass_vectors", wrong)
    assert worst()["force"] > 1e-3


def test_our_stiffness_that_is_wrong(monkeypatch):
    monkeypatch.setattr(forms, "SQUARE", (1 + 1e-6) / 12)
    assert worst()["hourglass_energy"] > element.TOLERANCE


def test_what_the_other_side_refuses():
    material = impact_reference.Material(1.0, 0.3, 1.0, "axisymmetric", "linear_elastic")
    with pytest.raises(ValueError, match="not axisymmetric"):
        impact_reference.element_one_point("quadrilateral", np.eye(4, 2), material, np.zeros(8))
