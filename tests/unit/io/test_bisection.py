# SPDX-License-Identifier: MIT
"""Cells to ranks by what they cost."""

import numpy as np
import pytest

from dolfinx_impact.io.bisection import bisect


@pytest.mark.parametrize("parts", [1, 2, 3, 5, 8])
def test_parts_have_equal_weights(parts):
    """The largest sum exceeds the mean by at most one cell per cut, of which a cell meets about log2(parts)."""
    random = np.random.default_rng(3)
    points = random.uniform(size=(2000, 3)) * (3.0, 1.0, 0.5)
    weights = np.where(points[:, 0] < 0.5, 20.0, 1.0)
    part = bisect(points, weights, parts)
    sums = np.bincount(part, weights, minlength=parts)
    assert len(sums) == parts and np.abs(sums - weights.sum() / parts).max() <= 20.0 * np.ceil(np.log2(max(parts, 2)))
    counts = np.bincount(part, minlength=parts)
    assert parts == 1 or counts.max() > 1.5 * counts.min(), "dear cells make small parts"


def test_parts_are_blocks():
    """Two parts of a bar are its two ends."""
    x = np.linspace(0.0, 1.0, 11)
    points = np.column_stack([x, 0 * x, 0 * x])
    part = bisect(points, np.ones(11), 2)
    assert np.all(np.diff(part) >= 0) and part[0] == 0 and part[-1] == 1


def test_a_plane_is_cut_along_its_sides():
    """Of a plane of points that the cut falls into, those of one part are next to each other, whatever their order."""
    x, y = (a.ravel() for a in np.meshgrid(np.arange(5.0), np.arange(4.0), indexing="ij"))
    order = np.random.default_rng(1).permutation(len(x))
    noise = 1e-16 * np.random.default_rng(2).normal(size=(len(x), 3))
    points = np.column_stack([x, y, 0 * x])[order] + noise
    part = bisect(points, np.ones(len(x)), 2)
    cut = part[np.rint(points[:, 0]) == 2.0][np.argsort(points[np.rint(points[:, 0]) == 2.0, 1])]
    assert cut.tolist() == [0, 0, 1, 1] and np.all(part[points[:, 0] < 1.5] == 0) and np.all(part[points[:, 0] > 2.5])


@pytest.mark.parametrize("weights", [np.zeros(5), np.array([0.0, 0.0, 0.0, 0.0, 1.0]), np.ones(5)])
def test_every_part_has_a_cell(weights):
    """Whatever the weights are; with fewer cells than parts, every cell has a part of its own."""
    points = np.column_stack([np.arange(5.0)] * 3)
    for parts in (2, 3, 5):
        assert len(np.unique(bisect(points, weights, parts))) == parts
    few = bisect(points, weights, 7)
    assert len(np.unique(few)) == 5 and few.max() < 7
