# SPDX-License-Identifier: MIT
"""Rotations as matrices, by Rodrigues' formula."""

import numpy as np

from .array_types import ArrayLike, FloatArray, floats


def cross_matrix(vector: ArrayLike) -> FloatArray:
    """The matrix whose product with w is the cross product of a vector with w.

    Args:
        vector: shape (3).
    """
    x, y, z = floats(vector)
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def matrix_of(angle: ArrayLike) -> FloatArray:
    """Rotation matrix of a rotation vector.

    Args:
        angle: rotation vector, shape (3) [1].
    """
    size = float(np.linalg.norm(angle))
    if size == 0.0:
        return np.eye(3)
    W = cross_matrix(floats(angle) / size)
    return np.eye(3) + np.sin(size) * W + (1.0 - np.cos(size)) * W @ W


def angle_of(matrix: FloatArray) -> FloatArray:
    """Rotation vector of a rotation matrix by less than half a turn.

    Args:
        matrix: shape (3, 3) [1].
    """
    twice = np.array([matrix[2, 1] - matrix[1, 2], matrix[0, 2] - matrix[2, 0], matrix[1, 0] - matrix[0, 1]])
    sine = float(np.linalg.norm(twice)) / 2.0
    if sine == 0.0:
        return np.zeros(3)
    return np.arctan2(sine, (np.trace(matrix) - 1.0) / 2.0) / (2.0 * sine) * twice
