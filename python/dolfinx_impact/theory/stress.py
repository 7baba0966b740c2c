# SPDX-License-Identifier: MIT
"""Stresses at a point of a half-plane or on the axis of a half-space."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from ..common.types import FloatArray


@dataclass(frozen=True)
class Stress:
    """Stresses, positive in tension; z points into the body. Scalars or arrays of one shape.

    Attributes:
        sigma_x: normal stress along the surface [F/L^2].
        sigma_y: normal stress out of the plane of a line contact [F/L^2].
        sigma_z: normal stress into the body [F/L^2].
        tau_xz: shear stress; zero on an axis of symmetry [F/L^2].
    """

    sigma_x: FloatArray | float
    sigma_y: FloatArray | float
    sigma_z: FloatArray | float
    tau_xz: FloatArray | float = 0.0

    @property
    def principal(self) -> FloatArray:
        """Principal stresses along the first axis, in the order larger in-plane, smaller in-plane, sigma_y [F/L^2]."""
        mean = (np.asarray(self.sigma_x) + self.sigma_z) / 2
        radius = np.hypot((np.asarray(self.sigma_x) - self.sigma_z) / 2, self.tau_xz)
        return np.array([mean + radius, mean - radius, np.broadcast_to(self.sigma_y, np.shape(mean))])

    @property
    def max_shear(self) -> FloatArray | float:
        """Largest shear stress over all planes (Tresca), half the largest principal difference [F/L^2]."""
        return np.ptp(self.principal, axis=0)[()] / 2

    @property
    def mises(self) -> FloatArray | float:
        """Mises equivalent stress [F/L^2]."""
        x, y, z = self.sigma_x, self.sigma_y, self.sigma_z
        return np.sqrt(((x - y) ** 2 + (y - z) ** 2 + (z - x) ** 2) / 2 + 3 * np.square(self.tau_xz))


def largest(field: Callable[[Any], Any], depth: float) -> tuple[float, float]:
    """(largest value of field(z) for 0 <= z <= depth, where): a search on a grid, refined around its best point."""
    z = np.linspace(0.0, depth, 601)
    best = int(np.argmax(field(z)))
    around = z[max(best - 1, 0)], z[min(best + 1, len(z) - 1)]
    found = scipy.optimize.minimize_scalar(
        lambda s: -field(s), bounds=around, method="bounded", options={"xatol": 1e-10 * depth}
    )
    # A largest value at the surface lies at the end of the interval, which the search does not reach.
    if field(z[best]) >= -found.fun * (1 - 1e-12):
        return float(field(z[best])), float(z[best])
    return float(-found.fun), float(found.x)
