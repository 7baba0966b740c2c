# SPDX-License-Identifier: MIT
"""Rows in blocks against one array that is copied whenever it grows."""

import numpy as np
import pytest

from dolfinx_impact.dynamics.row_blocks import BLOCK, RowBlocks

STEP = np.dtype([("time", float), ("number", np.int64)])


def made(first, count):
    rows = np.zeros(count, STEP)
    rows["number"] = np.arange(first, first + count)
    rows["time"] = 0.5 * rows["number"]
    return rows


@pytest.mark.parametrize("chunk", (1, 7, BLOCK - 1, BLOCK, BLOCK + 1, 3 * BLOCK))
def test_rows_are_those_that_were_added(chunk):
    table, total = RowBlocks(STEP), 3 * BLOCK + 5
    for first in range(0, total, chunk):
        table.add(made(first, min(chunk, total - first)))
    assert len(table) == total
    np.testing.assert_array_equal(table.rows(), made(0, total))
    blocks = list(table)
    assert [len(b) for b in blocks] == [BLOCK, BLOCK, BLOCK, 5]


@pytest.mark.parametrize("total", (0, 1, 2, BLOCK - 1, BLOCK, BLOCK + 1, 5 * BLOCK + 3))
def test_every_second_row_is_dropped_in_place(total):
    table = RowBlocks(STEP)
    table.add(made(0, total))
    kept = made(0, total)
    for _ in range(3):
        table.drop_every_second()
        kept = kept[::2]
        np.testing.assert_array_equal(table.rows(), kept)
    assert len(list(table)) == -(-len(kept) // BLOCK)
    table.add(made(10, 3))  # and it goes on
    np.testing.assert_array_equal(table.rows(), np.concatenate([kept, made(10, 3)]))


def test_rows_are_a_copy_and_can_be_forgotten():
    table = RowBlocks(float)
    table.add(np.arange(4.0))
    table.rows()[:] = -1.0
    np.testing.assert_array_equal(table.rows(), np.arange(4.0))
    table.clear()
    assert len(table) == 0 and table.rows().shape == (0,) and list(table) == []
