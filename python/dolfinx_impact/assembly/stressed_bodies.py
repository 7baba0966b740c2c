# SPDX-License-Identifier: MIT
"""What problems tell of the stress of their bodies."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..materials import Material
from .cauchy_stress import STRESS, VON_MISES
from .history_field import HistoryField
from .stress_fields import StressFields

if TYPE_CHECKING:
    from dolfinx.fem import Function

    from .history import MaterialHistory


NO_STRESS = (
    "the residual is your own, and its stress is not known: give the Cauchy stress sigma as a 3 x 3 UFL tensor, with "
    'that across the plane at [2, 2]: record(fields=["stress", "von_mises"], expressions={"stress": sigma}), or '
    "PointValues(sigma, points)"
)


class StressedBodies:
    """Base class of problems: stress of their bodies, whatever the material.

    A derived class has `u`, `material` (None with a residual of the user's own), `has_history` and `history`.
    """

    u: Function
    material: Material | None
    _elastic_stress: StressFields | None = None

    if TYPE_CHECKING:

        @property
        def has_history(self) -> bool: ...
        @property
        def history(self) -> MaterialHistory: ...

    @property
    def stress(self) -> HistoryField:
        """Cauchy stress at the quadrature points, components xx, yy, zz, xy and in space yz, xz [F/L^2].

        Raises:
            ValueError: the residual is the user's own, and its stress not known.
        """
        return self._stress_field(STRESS)

    @property
    def von_mises(self) -> HistoryField:
        """Von Mises' equivalent stress at the quadrature points [F/L^2].

        Raises:
            ValueError: the residual is the user's own, and its stress not known.
        """
        return self._stress_field(VON_MISES)

    def _stress_field(self, name: str) -> HistoryField:
        if self.material is None:
            raise ValueError(f"{name}: {NO_STRESS}")
        if self.has_history:
            return self.history[name]
        if self._elastic_stress is None:
            self._elastic_stress = StressFields(self.u, self.material)
        return self._elastic_stress[name]
