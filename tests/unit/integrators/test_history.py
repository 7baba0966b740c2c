# SPDX-License-Identifier: MIT
"""Rows of histories in a bounded amount of memory."""

import numpy as np
import own_residual_checks
import pytest
from mpi4py import MPI

from dolfinx_impact.dynamics.history import History


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
