# SPDX-License-Identifier: MIT
"""The benchmark of static contact, on a small model."""

import pytest

from impact_studies.bench import contact_rows as bench_contact

pytestmark = pytest.mark.alone


def test_rows_of_the_benchmark():
    rows = bench_contact.contact_rows((("small", "quadrilateral", 0.3, 3.0),))
    solve, share, count, memory = rows
    assert all(r["ratio"] == pytest.approx(r["value"] / r["baseline"]) for r in rows)
    assert solve["name"] == "static contact solve / tied linear solve" and solve["value"] > solve["baseline"] > 0
    assert share["baseline"] == solve["value"] and 0 < share["ratio"] < 1
    assert 0.05 < memory["value"] < memory["baseline"] == bench_contact.MEMORY  # of this process [GB]
    assert 1 <= count["value"] <= 5 and count["baseline"] > 1  # iterations, nodes in contact


def test_the_tied_problem_is_tied():
    """Every slave node moves with what it faces: the upper body's weighted displacements are the lower one's."""
    model = bench_contact.PressedBodies("quadrilateral", 0.3, 3.0, friction=1.0)
    contact = model.problem.contact[0]
    contact.begin_step(model.problem.u.x.array, None)
    moved = bench_contact.tied_solution(model)
    jump = contact.geometry.jump(moved)
    gap = contact.gap[contact.usable]
    # Gaps close, nothing slips: to the tolerance of the solution, 1e-10 of displacements of 0.03.
    assert abs((jump[contact.usable] * contact.normal[contact.usable]).sum(axis=1) + gap).max() < 1e-10
    along = (jump * contact.normal).sum(axis=1)[:, None] * contact.normal
    tangential = (jump - along)[contact.usable & ~contact.fixed.any(axis=1)]
    assert abs(tangential).max() < 1e-10 and abs(moved).max() > 0.02
