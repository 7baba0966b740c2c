# SPDX-License-Identifier: MIT
"""Internal variables of a material that turns about an axis: components of tensors in axes that stand still.

Plastic strains, the inverse of C_p and back stresses (forms/plasticity.py) belong to the undeformed material. Where it
has turned by Q, a tensor T has the components Q T Q^T.
"""

from __future__ import annotations

import numpy as np

from ..common.types import FloatArray

SYMMETRIC = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))  # components that are kept; in the plane the first four
DEVIATOR = ((0, 0), (1, 1), (0, 1), (1, 2), (0, 2))  # and the first three


def rotations(axis: FloatArray, angle: FloatArray) -> FloatArray:
    """Rotations about axes by Rodrigues' formula, (n, 3, 3).

    Args:
        axis: unit vectors, (n, 3).
        angle: by the right-hand rule, (n) [rad].
    """
    cross = np.zeros((len(axis), 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        cross[:, j, i], cross[:, i, j] = axis[:, k], -axis[:, k]
    s, c = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.eye(3) + s * cross + (1.0 - c) * cross @ cross


def turned(values: FloatArray, rotation: FloatArray, deviator: bool) -> FloatArray:
    """Components of tensors after rotations, in the order of forms/plasticity.py.

    Args:
        values: (n, 3) or (n, 5) of deviators, (n, 4) or (n, 6) of others, in the plane or in space.
        rotation: (n, 3, 3), about the normal of the plane for tensors of the plane.
        deviator: are they deviators?
    """
    width = values.shape[1]
    places = (DEVIATOR if deviator else SYMMETRIC)[:width]
    T = np.zeros((len(values), 3, 3))
    for column, (i, j) in enumerate(places):
        T[:, i, j] = T[:, j, i] = values[:, column]
    if deviator:
        T[:, 2, 2] = -T[:, 0, 0] - T[:, 1, 1]
    T = rotation @ T @ rotation.transpose(0, 2, 1)
    return np.stack([T[:, i, j] for i, j in places], axis=1)
