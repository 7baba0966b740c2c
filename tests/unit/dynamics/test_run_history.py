# SPDX-License-Identifier: MIT
"""Rows of histories in a bounded amount of memory."""

import numpy as np
import own_residual_checks
import pytest
from mpi4py import MPI

from dolfinx_impact.dynamics.run_history import RunHistory

LIMIT = 250_000  # rows, unless set
BLOCK = 4096  # rows whose memory is taken at once


class Table:
    """A history whose first energy is the number of the step."""

    def __init__(self, limit=None):
        self.history, self.all = RunHistory(0, 2), np.zeros((0, 10))
        if limit is not None:
            self.history.limit = limit

    def add(self, numbers):
        steps = np.zeros(len(numbers), self.history.step_type)
        steps["kinetic"] = numbers
        self.history.add(-numbers, steps)
        rows = np.zeros((len(numbers), 10))
        rows[:, 0], rows[:, 1] = -numbers, numbers
        self.all = np.concatenate([self.all, rows])

    @property
    def stride(self):
        return self.history._cpp_object.stride


@pytest.mark.parametrize("chunk", (1, 3, 7, 100))
def test_rows_are_thinned_evenly(chunk):
    """However rows come: at most the limit, the first among them, equally far apart, the last one known."""
    table, numbers = Table(10), np.arange(1000.0)
    for k in range(0, 1000, chunk):
        table.add(numbers[k : k + chunk])
        kept, seen = table.history.energies, min(k + chunk, 1000)
        np.testing.assert_array_equal(kept, table.all[: seen : table.stride])
        assert len(kept) <= 10 and 2 * len(kept) >= min(10, seen) and table.history.last["kinetic"] == seen - 1
    assert table.stride == 128
    table.history.limit = 4
    np.testing.assert_array_equal(table.history.energies, table.all[:: table.stride])
    assert len(table.history.energies) <= 4
    table.history.begin_anew()
    table.add(numbers[:3])
    np.testing.assert_array_equal(table.history.energies, table.all[-3:])


def test_nothing_is_dropped_below_the_limit():
    table, numbers = Table(), np.arange(500.0)
    table.add(numbers[:0])
    assert table.history.last is None and table.history.energies.shape == (0, 10)
    for part in np.split(numbers, (1, 100, 333)):
        table.add(part)
    np.testing.assert_array_equal(table.history.energies, table.all)


def test_rows_of_several_blocks_are_thinned_evenly():
    table = Table(3 * BLOCK)
    for part in np.array_split(np.arange(16.5 * BLOCK), 37):
        table.add(part)
        seen = int(table.history.last["kinetic"]) + 1
        np.testing.assert_array_equal(table.history.energies, table.all[: seen : table.stride])
    assert table.stride == 8 and len(table.history.energies) == np.ceil(16.5 * BLOCK / 8)


@pytest.mark.parametrize("count, num_contacts", [(1000, 0), (1000, 1), (1000, 3), (25, 1)])
def test_memory_is_what_the_rows_take(count, num_contacts):
    """docs/explicit/runs.md: 250,000 rows of 104 bytes with one contact, however long the run; to read them takes the
    memory of the result. A table in one piece took twice as much, and three times while it grew."""
    limit = LIMIT if count == 1000 else LIMIT // 10
    history = RunHistory(num_contacts, 2)
    history.limit = limit
    rows = np.zeros(count, history.step_type)
    assert history.row_type.itemsize == 80 + 24 * num_contacts
    allowed = 1.02 * limit * history.row_type.itemsize + 1e6
    most = 0
    for k in range(0, int(2.4 * limit), count):
        history.add(np.arange(k, k + count, dtype=float), rows)
        most = max(most, history._cpp_object.memory)
    assert 0.5 * limit * history.row_type.itemsize < most < allowed
    size = len(history.energies) * 8 * (10 + 2 * num_contacts)
    found = history.energies, history.forces
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
