# SPDX-License-Identifier: MIT
"""Rows of histories in a bounded amount of memory."""

import tracemalloc

import numpy as np
import own_residual_checks
import pytest
from mpi4py import MPI

from dolfinx_impact.dynamics import row_blocks
from dolfinx_impact.dynamics.history import LIMIT, History
from dolfinx_impact.dynamics.run_history import RunHistory


@pytest.mark.parametrize("chunk", (1, 3, 7, 100))
def test_rows_are_thinned_evenly(chunk):
    """However rows come: at most the limit, the first among them, equally far apart, the last one known."""
    history, rows = History(np.dtype((float, (2,))), 10), np.column_stack([np.arange(1000.0), -np.arange(1000.0)])
    for k in range(0, 1000, chunk):
        history.add(rows[k : k + chunk])
        kept, seen = history.rows(), min(k + chunk, 1000)
        np.testing.assert_array_equal(kept, rows[: seen : history.stride])
        assert len(kept) <= 10 and 2 * len(kept) >= min(10, seen) and history.last[0] == seen - 1
    assert history.stride == 128
    history.limit = 4
    np.testing.assert_array_equal(history.rows(), rows[:: history.stride])
    assert len(history.rows()) <= 4
    history.clear()
    history.add(rows[:3])
    np.testing.assert_array_equal(history.rows(), rows[:3])


def test_nothing_is_dropped_below_the_limit():
    history, rows = History(np.dtype((float, (1,)))), np.arange(500.0)[:, None]
    history.add(rows[:0])
    assert history.last is None and history.rows().shape == (0, 1)
    for part in np.split(rows, (1, 100, 333)):
        history.add(part)
    np.testing.assert_array_equal(history.rows(), rows)


def test_rows_of_several_blocks_are_thinned_evenly():
    history, rows = History(np.dtype((float, (1,))), 3 * row_blocks.BLOCK), np.arange(50_000.0)[:, None]
    for part in np.array_split(rows, 37):
        history.add(part)
        np.testing.assert_array_equal(history.rows(), rows[: int(history.last[0]) + 1 : history.stride])
        np.testing.assert_array_equal(np.concatenate(list(history)), history.rows())
    assert history.stride == 16 and len(history) == 3125


@pytest.mark.parametrize("count, num_contacts", [(1000, 0), (1000, 1), (1000, 3), (25, 1)])
def test_memory_is_what_the_rows_take(count, num_contacts):
    """docs/explicit/runs.md: 250,000 rows of 104 bytes with one contact, however long the run; to read them takes the
    memory of the result. A table in one piece took twice as much, and three times while it grew."""
    limit = LIMIT if count == 1000 else LIMIT // 10  # tracemalloc is slow
    history = RunHistory(num_contacts, 2)
    history.limit = limit
    rows = np.zeros(count, history.step_type)
    assert history.row_type.itemsize == 80 + 24 * num_contacts
    allowed = 1.02 * limit * history.row_type.itemsize + 1e6
    tracemalloc.start()
    try:
        for k in range(0, int(2.4 * limit), count):
            history.add(np.arange(k, k + count, dtype=float), rows)
        kept, most = tracemalloc.get_traced_memory()
        assert kept <= most < allowed
        size = len(history.energies) * 8 * (10 + 2 * num_contacts)
        tracemalloc.reset_peak()
        found = history.energies, history.forces
        assert tracemalloc.get_traced_memory()[1] < kept + size + 1e6
    finally:
        tracemalloc.stop()
    assert len(found[0]) <= limit and sum(a.nbytes for a in (found[0], *found[1])) == size
    assert np.array_equal(found[0][:, 0], 4.0 * np.arange(len(found[0])))


def test_histories_of_a_run():
    """From time zero on, one row a step; fewer where a limit says so, and the run is the same."""
    problems = [own_residual_checks.Body(MPI.COMM_SELF, n=2).shake() for _ in range(2)]
    problems = [b.problem(b.elastic()) for b in problems]
    problems[1].history_limit = 50
    seen = []
    for p in problems:
        dt = 0.5 * p.stable_step()
        p.advance(90 * dt, dt=dt, callback=lambda q: seen.append((q.step, q.time)), progress=False)
        p.advance(120 * dt, dt=dt, callback=lambda q: seen.append((q.step, q.time)), progress=False)
    whole, thin = (p.energy_history for p in problems)
    assert whole.shape == (120, 10) and whole[0, 0] == 0.0 and whole[0, 1] > 0.0
    np.testing.assert_array_equal(thin, whole[::4])
    assert problems[0].energy == problems[1].energy
    assert [step for step, _ in seen] == 2 * list(range(121)) and seen[0][1] == 0.0  # step 0 once
    for bad in (1, 2.5, True):
        with pytest.raises(ValueError, match="history_limit"):
            problems[0].history_limit = bad
