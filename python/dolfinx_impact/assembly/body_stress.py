# SPDX-License-Identifier: MIT
"""What problems tell of the stress of their bodies."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dolfinx.fem import Function

from ..common.described import Described
from ..materials import Material
from .history_field import HistoryField
from .stress_fields import StressFields

if TYPE_CHECKING:
    from .material_history import MaterialHistory

NO_STRESS = (
    "the residual is your own, and its stress is not known: give the Cauchy stress sigma as a 3 x 3 UFL tensor, with "
    'that across the plane at [2, 2]: record(fields=["stress", "von_mises"], expressions={"stress": sigma}), or '
    "PointValues(sigma, points)"
)


class BodyStress(Described):
    """Stress of a problem's bodies, whatever the material; kernels are made when it is asked for first.

    Args:
        u: displacement function [L].
        material: material of the bodies; None: the residual is the user's own.
    """

    def __init__(self, u: Function, material: Material | None) -> None:
        self._u, self._material = u, material
        self._elastic: StressFields | None = None

    def field(self, name: str, history: MaterialHistory | None) -> HistoryField:
        """A field of the stress at the quadrature points.

        Args:
            name: "stress" or "von_mises".
            history: internal variables of the problem; None: no material has any.

        Returns:
            The field [F/L^2].

        Raises:
            ValueError: the residual is the user's own, and its stress not known.
        """
        if self._material is None:
            raise ValueError(f"{name}: {NO_STRESS}")
        if history is not None:
            return history[name]
        if self._elastic is None:
            self._elastic = StressFields(self._u, self._material)
        return self._elastic[name]
