# SPDX-License-Identifier: MIT
"""Rows of mixed precision."""

from dolfinx_impact import materials
from impact_studies.bench import bench_command, mixed


def test_rows():
    (row,) = mixed.mixed_rows(("tetrahedron", 2, 2), materials.NeoHookean, steps=2, rounds=1)
    assert row["name"] == "neo_hookean mixed / double, whole step"
    assert row["ratio"] > 0.0 and row["cell"] == "tetrahedron P2"


def test_the_command_measures_them():
    assert {text for text, _ in mixed.jobs()} <= {text for text, _ in bench_command.jobs(1.0, 1.0)}
