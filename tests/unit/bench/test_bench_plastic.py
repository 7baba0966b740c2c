# SPDX-License-Identifier: MIT
"""The benchmark of plasticity, on small models: rows are made only of sides that compute the same."""

import numpy as np
import pytest

from impact_studies.bench import explicit as bench_explicit
from impact_studies.bench import plastic
from dolfinx_impact.plasticity import J2Plasticity

pytestmark = pytest.mark.alone


@pytest.fixture(autouse=True)
def few_rounds(monkeypatch):
    monkeypatch.setattr(plastic, "ROUNDS", 2)
    # Steps as short as those of the benchmark's smaller cells, so that the flow lasts.
    monkeypatch.setattr(plastic, "SHARE", 0.025)
    monkeypatch.setattr(plastic, "STEPS", 40)


@pytest.mark.alone
def test_rows_of_speed():
    rows = plastic.speed_rows(5)
    laws = [f"{size} strain, {law}" for size in ("small", "finite") for law in ("linear", "Voce")]
    states = ("all points yield", "no point yields")
    found = [", ".join(r["name"].split(", ")[1:4]) for r in rows]
    assert found == [f"{law}, {state}" for law in laws for state in states]
    # A sane bound of a ratio whose goal is below 1, as so few cells take little more than what a step does once.
    assert all(0.0 < r["ratio"] < 10.0 and r["baseline"] > 0.0 for r in rows)


@pytest.mark.alone
def test_rows_of_one_point():
    rows = plastic.reduced_rows(10)
    found = [", ".join(r["name"].split(", ")[:-1]) for r in rows]
    states = ("all points yield", "no point yields")
    assert found == [f"j2 reduced / full, {s} strain, linear, {state}" for s in ("small", "finite") for state in states]
    assert all(0.0 < r["ratio"] < 20.0 and r["baseline"] > 0.0 for r in rows)


def test_a_timing_with_a_new_stable_step_does_not_count(monkeypatch):
    body = plastic.Body(3, plastic.j2(plastic.YIELDING, finite_strain=True))
    safe, advance = body.problem._cpp_object.safe_step, body.advance
    assert body.seconds() > 0.0
    assert safe.num_found > 0 and body.problem.step <= safe.check_step
    monkeypatch.setattr(body, "advance", lambda steps: advance(steps + safe.check_step - body.problem.step))
    with pytest.raises(RuntimeError, match="stable steps were found in .* no timing counts"):
        body.seconds()


def test_a_state_of_another_name_makes_no_row(monkeypatch):
    right = plastic.j2
    for given in (plastic.YIELDING, plastic.ELASTIC):
        monkeypatch.setattr(plastic, "j2", lambda _, *law, given=given: right(given, *law))
        with pytest.raises(RuntimeError, match="of the points flow before the rounds"):
            plastic.speed_rows(3)


def test_row_of_the_usual_way():
    """Made only if force and plastic strain agree."""
    (row,) = plastic.usual_row(4, steps=1)
    # In DOLFINx a step is several passes over the cells, without vectors: whatever the load, it is not the faster one.
    assert row["ratio"] > 1.0


@pytest.mark.parametrize("wrong", ({"hardening": 2.0}, {"yield_stress": 2e-3}, {"nu": 0.31}))
def test_another_law_makes_no_row(monkeypatch, wrong):
    arguments = {"E": plastic.E, "nu": plastic.NU, "yield_stress": plastic.YIELDING, "hardening": plastic.HARDENING}
    monkeypatch.setattr(plastic, "j2", lambda _: J2Plasticity(density=1.0, **(arguments | wrong)))
    with pytest.raises(RuntimeError, match="no timing counts"):
        plastic.usual_row(3, steps=1)


def test_row_of_an_own_law(monkeypatch):
    (row,) = plastic.own_row(5)
    assert row["name"].startswith("own law at run time / j2 of the package") and row["value"] > 0.0
    right = plastic.OwnJ2
    monkeypatch.setattr(plastic, "OwnJ2", lambda y: right(2 * y))
    with pytest.raises(RuntimeError, match="no timing counts"):
        plastic.own_row(3)
    monkeypatch.setattr(plastic, "j2", lambda y: right(y))
    with pytest.raises(RuntimeError, match="J2Plasticity was not: nothing is compared"):
        plastic.own_row(3)


def test_row_of_memory(monkeypatch):
    found = {"history": 0.7}
    monkeypatch.setattr(bench_explicit, "run_on_ranks", lambda what, _, n: {"cells": n**3, "kB": found[what]})
    (row,) = plastic.memory_rows(4)
    assert row["ratio"] == pytest.approx(0.5) and "64 cells" in row["cell"]


@pytest.mark.slow
def test_memory_of_the_history():
    """At least what the history takes: 6 numbers at 8 points, twice."""
    n = 24  # 13824 cells: 10 MB of history, against which what else the process allocates is small
    found = [bench_explicit.run_on_ranks(what, 1, n)["kB"] for what in ("memory", "history")]
    assert np.diff(found)[0] > 0.9 * 0.768
