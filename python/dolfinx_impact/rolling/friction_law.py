# SPDX-License-Identifier: MIT
"""Contact and Coulomb friction of nodes as equations of semi-smooth functions, linearised; docs/rolling.md."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..common.types import BoolArray, FloatArray


@dataclass
class Linearised:
    """What the law says of each node, at trial values p = lambda_n - c_n g and tau = lambda_T - c_t s.

    Attributes:
        active: p is positive: the node is in contact, (n).
        sliding: tau exceeds friction times p, (n).
        target: multipliers that the law makes of the trial values, (n, gdim) [F/L^2]; in a solution they are the same.
        direction: unit vectors along tau, (n, gdim); zero where a node does not slide.
        kappa: friction times p over the length of tau, at most 1, (n); zero where a node does not slide.
        tangential_stiffness: c_t, (n) [F T/L^3].
    """

    active: BoolArray
    sliding: BoolArray
    target: FloatArray
    direction: FloatArray
    kappa: FloatArray
    tangential_stiffness: FloatArray


def linearise(
    normal: FloatArray,
    friction: float,
    normal_stiffness: FloatArray,
    tangential_stiffness: FloatArray,
    carriers: BoolArray,
    gap: FloatArray,
    slip: FloatArray,
    vectors: FloatArray,
) -> Linearised:
    """Evaluate the law of all nodes of a contact.

    Args:
        normal: unit normals out of the master, (n, gdim) [1].
        friction: coefficient [1].
        normal_stiffness: c_n > 0, (n) [F/L^3].
        tangential_stiffness: c_t > 0, (n) [F T/L^3].
        carriers: mask of nodes with a multiplier, (n).
        gap: gaps, (n) [L].
        slip: tangential slip velocities, (n, gdim) [L/T].
        vectors: multipliers, (n, gdim) [F/L^2].
    """
    along = np.einsum("na,na->n", normal, vectors)
    gap = np.where(carriers, gap, 1.0)
    pressure = np.where(carriers, along - normal_stiffness * gap, 0.0)
    active = pressure > 0.0
    pressure = np.maximum(pressure, 0.0)
    trial = np.where(active[:, None], vectors - along[:, None] * normal - tangential_stiffness[:, None] * slip, 0.0)
    size, limit = np.linalg.norm(trial, axis=1), friction * pressure
    sliding = active & (size > limit)
    safe = np.where(sliding, size, 1.0)
    direction = np.where(sliding[:, None], trial / safe[:, None], 0.0)
    kappa = np.where(sliding, limit / safe, 0.0)
    traction = np.where(sliding[:, None], limit[:, None] * direction, trial)
    target = np.where(active[:, None], pressure[:, None] * normal + traction, 0.0)
    return Linearised(active, sliding, target, direction, kappa, tangential_stiffness)


def tangents(normal: FloatArray, first: FloatArray, fixed: BoolArray) -> FloatArray:
    """Orthonormal tangent vectors of surfaces, (n, gdim - 1, gdim).

    A prescribed component along the surface, as on a plane of symmetry, gets a tangent vector of its own.

    Args:
        normal: unit normals, (n, gdim) [1].
        first: directions that the first tangent follows where no component is prescribed, (n, gdim).
        fixed: prescribed components, (n, gdim).
    """
    n, gdim = normal.shape
    if gdim == 2:
        return np.stack([-normal[:, 1], normal[:, 0]], axis=1)[:, None, :]
    wanted = first.copy()
    for c in range(3):
        level = fixed[:, c] & (np.abs(normal[:, c]) < 0.5)
        wanted[level] = np.eye(3)[c]
    for c in range(3):  # where the direction is normal to the surface, any other will do
        flat = wanted - np.einsum("na,na->n", normal, wanted)[:, None] * normal
        poor = np.linalg.norm(flat, axis=1) <= 1e-6 * np.maximum(np.linalg.norm(wanted, axis=1), 1e-300)
        wanted[poor] = np.eye(3)[c]
    flat = wanted - np.einsum("na,na->n", normal, wanted)[:, None] * normal
    one = flat / np.linalg.norm(flat, axis=1)[:, None]
    return np.stack([one, np.cross(normal, one)], axis=1)
