# SPDX-License-Identifier: MIT
"""What both sides give of a run: its states, energies and contact forces at all time levels."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from dolfinx_impact.common.types import FloatArray


@dataclass
class Record:
    """States of a run at all time levels, in our order of the degrees of freedom.

    Args:
        time: time levels, shape (num_levels) [T].
        fields: by name "displacement" [L], "velocity" [L/T] and "acceleration" [L/T^2], (num_levels, num_dofs) each.
        energies: by name, (num_levels) each; of explicit runs without the last level [F L].
        largest_energy: of kinetic and internal energy at any level [F L].
        force: force on the slave, (num_levels, gdim), of explicit runs without the last level; None: no contact [F].
    """

    time: FloatArray
    fields: Mapping[str, FloatArray]
    energies: Mapping[str, FloatArray]
    largest_energy: float
    force: FloatArray | None


def largest(energies: Mapping[str, FloatArray]) -> float:
    """Largest kinetic or internal energy.

    Args:
        energies: by name, shape (num_levels) each [F L].
    """
    return max(float(np.abs(energies[name]).max()) for name in ("kinetic", "internal"))
