# SPDX-License-Identifier: MIT
"""The benchmark of explicit dynamics, on small models."""

import numpy as np
import pytest

from dolfinx_impact import _cpp
from dolfinx_impact.materials import NeoHookean
from impact_studies.bench import explicit as bench_explicit
from impact_studies.bench.setup import Setup

pytestmark = pytest.mark.alone


def by_name(rows):
    assert all(r["ratio"] == pytest.approx(r["value"] / r["baseline"]) for r in rows)
    return {r["name"]: r for r in rows}


def test_rows_of_steps():
    """Made only if the step's acceleration is that of assemble_vector's force."""
    cells = ("hexahedron",)
    rows = by_name(bench_explicit.step_rows((("hexahedron", 1, 4),), steps=5, own=cells))
    by_hand = 1 if _cpp.bench.HandWrittenStep.widths() else 0
    assert len(rows) == 4 + by_hand and all(r["value"] > 0 and r["baseline"] > 0 for r in rows.values())
    assert rows["linear_elastic whole step / A (force)"]["cell"] == "hexahedron P1"
    assert rows["linear_elastic whole step / own force"]["ratio"] < 1.5
    assert "own residual / package, whole step" in rows


def test_another_force_makes_no_rows(monkeypatch):
    right = Setup.baseline

    def wrong(setup, flags):
        seconds, force = right(setup, flags)
        return seconds, force * (1 + 1e-9 * np.arange(len(force)))

    monkeypatch.setattr(Setup, "baseline", wrong)
    with pytest.raises(RuntimeError, match="no timing counts"):
        bench_explicit.step_rows((("hexahedron", 1, 3),), steps=2)


def test_no_stable_step_is_timed_among_the_others(monkeypatch):
    """It is found anew where cells deform far: a row would tell of that, not of steps."""
    case = ("hexahedron", 1, 4)
    rows = by_name(bench_explicit.step_rows((case,), NeoHookean, steps=20, baselines=("A",)))
    assert rows["neo_hookean whole step / own force"]["value"] > 0
    monkeypatch.setattr(bench_explicit, "AMPLITUDE", 1.0)
    with pytest.raises(RuntimeError, match="stable steps were found anew"):
        bench_explicit.step_rows((case,), NeoHookean, steps=20, baselines=("A",))


def test_rows_of_contact():
    rows = bench_explicit.contact_rows((6, 4), (6, 2), steps=(10, 10), rounds=(1, 1))
    by_hand = [r for r in rows if "written by hand" in r["name"]]
    assert len(by_hand) == 2 * _cpp.bench.HandWrittenContact.available()  # penalty, without and with friction
    assert len(rows) - len(by_hand) == 4 * len(bench_explicit.CONTACTS)
    shares = [r for r in rows if "share of a step" in r["name"]]
    assert len(shares) == 4 and all(r["cell"] == "49 of 490 nodes" for r in shares)
    assert all(0.0 < r["ratio"] < 1.0 for r in shares)
    touching = [r["value"] for r in rows if "nodes that touch" in r["name"]]
    assert len(touching) == 4 and min(touching) > 0  # pressed together: contact works in every one


def test_rows_of_contact_without_pairs():
    rows = bench_explicit.general_rows((6, 2), steps=10, rounds=1)
    assert len(rows) == 4 and all(r["cell"] == "244 of 294 nodes" for r in rows), rows
    assert all(r["value"] > 0.0 and r["ratio"] == pytest.approx(r["value"] / r["baseline"]) for r in rows)
    assert all(0.1 < r["value"] < 1.0 for r in rows if "touch" in r["name"])


def test_rows_of_tied_blocks():
    setup, step = bench_explicit.tie_rows((6, 2), steps=10, rounds=1)
    assert (setup["cell"], step["cell"]) == ("49 of 294 nodes",) * 2
    assert all(r["value"] > 0.0 and r["ratio"] == pytest.approx(r["value"] / r["baseline"]) for r in (setup, step))


def test_contact_has_a_clock_of_its_own():
    """It runs when there is contact only, and tells what contact adds to a step, by a factor of two."""
    free, touching = bench_explicit.Blocks(12, 1), bench_explicit.Blocks(12, 1, bench_explicit.Kinematic)
    times = [[bench_explicit.contact_seconds(m.problem, 100) for m in (free, touching)] for _ in range(7)]
    (none, alone), (contact, whole) = np.min(times, axis=0)  # others on the machine only add to it
    assert np.max(times, axis=0)[0, 0] == none == 0.0
    assert 0.5 < contact / (whole - alone) < 2.0


def test_slaves_are_as_many_of_the_nodes_as_the_goal_says():
    n, layers = bench_explicit.SHARE_BLOCKS
    assert (n + 1) ** 2 / (2 * (n + 1) ** 2 * (layers + 1)) == pytest.approx(0.015, rel=0.05)


@pytest.mark.slow
def test_rows_of_output_memory_and_ranks():
    (output,) = bench_explicit.output_rows(3, steps=100, rounds=1)
    assert output["baseline"] > 0 and output["ratio"] < 1.0
    (memory,) = bench_explicit.memory_rows(16)
    assert 0.1 < memory["value"] < 20.0 and "4096 cells" in memory["cell"]
    per_core, beside, messages, sent = bench_explicit.rank_rows(2, 6)
    assert per_core["ranks"] == 2 and per_core["value"] > 0 and per_core["baseline"] > 0
    assert beside["value"] == per_core["value"] and beside["baseline"] > 0
    # One exchange forward and one reverse, with the one neighbour: 9 x 9 nodes between the two, as many behind them.
    assert messages["value"] == pytest.approx(2.0, abs=0.2)
    assert 0 < sent["value"] <= 4 * 81 * 3 * 8e-3
