# SPDX-License-Identifier: MIT
"""Motion of a free body of single elements by central differences with lumped mass."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from . import elements
from ._reference import Material
from .array_types import ArrayLike, FloatArray, integers


@dataclass
class BodyForces:
    """What the elements of a body have at a displacement.

    Attributes:
        force: internal forces, shape (num_nodes, gdim) [F].
        internal: strain energy [F L].
        hourglass: the part of it that hourglass modes have [F L].
    """

    force: FloatArray
    internal: float
    hourglass: float


@dataclass
class FreeMotion:
    """End of a motion.

    Attributes:
        displacement: shape (num_nodes, gdim) [L].
        internal: strain energy, elastic where the body flows [F L].
        hourglass: the part of it that hourglass modes have [F L].
    """

    displacement: FloatArray
    internal: float
    hourglass: float


def lumped_mass(points: FloatArray, cells: ArrayLike, cell_type: str, material: Material) -> FloatArray:
    """Lumped mass of each degree of freedom.

    Args:
        points: nodes, shape (num_nodes, gdim) [L].
        cells: nodes of the cells in the order of `reference_nodes`, shape (num_cells, n).
        cell_type: "quadrilateral" or "hexahedron".
        material: density and hypothesis.

    Returns:
        Masses, shape (num_nodes, gdim) [M].
    """
    mass = np.zeros_like(points)
    for cell in integers(cells, "cells", 2):
        mass[cell] += elements.element_lumped_mass(cell_type, points[cell], material).reshape(len(cell), -1)
    return mass


def move_freely(
    mass: FloatArray,
    velocity: FloatArray,
    forces: Callable[[FloatArray], BodyForces],
    dt: float,
    num_steps: int,
) -> FreeMotion:
    """Central differences of a free body.

    Args:
        mass: of each degree of freedom, shape (num_nodes, gdim) [M].
        velocity: at the beginning, shape (num_nodes, gdim) [L/T].
        forces: what the elements have at a displacement; called once at each time level, in their order.
        dt: step [T].
        num_steps: number of steps [1].

    Returns:
        FreeMotion.
    """
    u, v = np.zeros_like(mass), np.array(velocity)
    now = forces(u)
    v -= 0.5 * dt * now.force / mass
    for _ in range(num_steps):
        u += dt * v
        now = forces(u)
        v -= dt * now.force / mass
    return FreeMotion(u, now.internal, now.hourglass)
