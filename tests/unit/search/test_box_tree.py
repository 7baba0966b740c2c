# SPDX-License-Identifier: MIT
"""BoxTree against all boxes, one by one."""

import numpy as np
import pytest

from dolfinx_impact import _cpp


def random_boxes(rng, dim, num, size=0.2):
    low = rng.uniform(size=(num, dim))
    return np.hstack([low, low + rng.uniform(0, size, size=(num, dim))])


def overlapping(boxes, box, dim):
    return np.flatnonzero(np.all((boxes[:, :dim] <= box[dim:]) & (box[:dim] <= boxes[:, dim:]), axis=1))


def distances(boxes, x, dim):
    return np.linalg.norm(np.maximum(0, np.maximum(boxes[:, :dim] - x, x - boxes[:, dim:])), axis=1)


@pytest.mark.parametrize("dim", (2, 3))
@pytest.mark.parametrize("num", (0, 1, 4, 5, 300))
def test_same_as_all_boxes(dim, num, rng):
    boxes = random_boxes(rng, dim, num)
    tree = _cpp.search.BoxTree(dim, boxes.ravel())
    assert tree.size == num
    for turn in range(2):  # the second time moved far: the tree is the same, its boxes follow
        for box in random_boxes(rng, dim, 50):
            assert np.array_equal(tree.overlapping(box), overlapping(boxes, box, dim))
        for x in rng.uniform(-0.5, 1.5, size=(50, dim)):
            found, distance = tree.nearest(x)
            if num == 0:
                assert found == -1 and np.isinf(distance)
                continue
            every = distances(boxes, x, dim)
            assert abs(distance - every.min()) < 1e-15  # one square root apart
            assert every[found] < every.min() + 1e-15
        boxes = random_boxes(rng, dim, num)
        tree.refit(boxes.ravel())


def test_equal_and_touching_boxes():
    """Many boxes at one place can still be halved; touching is overlapping."""
    boxes = np.tile([0.0, 0.0, 1.0, 1.0], (100, 1))
    tree = _cpp.search.BoxTree(2, boxes.ravel())
    assert np.array_equal(tree.overlapping(np.array([1.0, 1.0, 2.0, 2.0])), np.arange(100))
    assert tree.overlapping(np.array([1.0 + 1e-15, 0.0, 2.0, 2.0])).size == 0
    assert tree.nearest(np.array([0.5, 0.5])) == (0, 0.0)


def test_refused():
    with pytest.raises(ValueError, match="2\\*gdim"):
        _cpp.search.BoxTree(2, np.zeros(5))
    tree = _cpp.search.BoxTree(2, np.zeros(8))
    with pytest.raises(ValueError, match="as many boxes"):
        tree.refit(np.zeros(4))
    with pytest.raises(ValueError, match="2\\*gdim"):
        tree.overlapping(np.zeros(3))
    with pytest.raises(ValueError, match="gdim"):
        tree.nearest(np.zeros(3))
