# SPDX-License-Identifier: MIT
"""Rows of cells with one point."""

import pytest
from dolfinx_impact import _cpp, materials
from impact_studies.bench import bench_command, one_point


@pytest.mark.parametrize("cell", ["hexahedron", "quadrilateral"])
def test_rows(cell):
    rows = one_point.one_point_rows(cell, 3, steps=2, rounds=1)
    assert [r["name"] for r in rows] == [f"linear_elastic reduced / full, {what}" for what in ("whole step", "force")]
    assert all(r["ratio"] > 0.0 and r["cell"] == f"{cell} P1" for r in rows)


@pytest.mark.parametrize("law", [materials.LinearElastic, materials.NeoHookean])
def test_rows_of_mixed_precision(law):
    (row,) = one_point.mixed_rows(3, law, steps=2, rounds=1)
    assert row["name"] == f"{law.law_class.name} reduced, mixed / full, double, whole step" and row["ratio"] > 0.0


def test_rows_of_steps_written_by_hand():
    rows = one_point.hand_written_rows(3, steps=4, rounds=1)
    assert len(rows) == bool(_cpp.bench.HandWrittenStep.widths())
    assert all(r["name"] == "linear_elastic reduced whole step / written by hand" and r["ratio"] > 0.0 for r in rows)


def test_the_command_measures_them():
    assert {text for text, _ in one_point.jobs()} <= {text for text, _ in bench_command.jobs(1.0, 1.0)}
