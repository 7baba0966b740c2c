# SPDX-License-Identifier: MIT
"""Rows of cells with one point."""

import pytest

from impact_studies.bench import bench_command, one_point


@pytest.mark.parametrize("cell", ["hexahedron", "quadrilateral"])
def test_rows(cell):
    rows = one_point.one_point_rows(cell, 3, steps=2, rounds=1)
    assert [r["name"] for r in rows] == [f"linear_elastic reduced / full, {what}" for what in ("whole step", "force")]
    assert all(r["ratio"] > 0.0 and r["cell"] == f"{cell} P1" for r in rows)


def test_the_command_measures_them():
    assert {text for text, _ in one_point.jobs()} <= {text for text, _ in bench_command.jobs(1.0, 1.0)}
