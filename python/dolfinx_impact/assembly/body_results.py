# SPDX-License-Identifier: MIT
"""What problems of all kinds tell of their bodies."""

from __future__ import annotations

from ..common.unique import Unique
from .body_stress import BodyStress
from .cauchy_stress import VON_MISES
from ..forms.elasticity import STRESS
from .material_history import MaterialHistory, existing
from .history_field import HistoryField


class BodyResults(Unique):
    """Base of problems: stress and internal variables of their bodies.

    A derived class sets `_stress` and `_material_history`; None: no material has internal variables.
    """

    _stress: BodyStress
    _material_history: MaterialHistory | None

    @property
    def stress(self) -> HistoryField:
        """Cauchy stress at the quadrature points, components xx, yy, zz, xy and in space yz, xz [F/L^2].

        Raises:
            ValueError: the residual is the user's own, and its stress not known.
        """
        return self._stress.field(STRESS, self._material_history)

    @property
    def von_mises(self) -> HistoryField:
        """Von Mises' equivalent stress at the quadrature points [F/L^2].

        Raises:
            ValueError: the residual is the user's own, and its stress not known.
        """
        return self._stress.field(VON_MISES, self._material_history)

    @property
    def has_history(self) -> bool:
        """Whether a material has internal variables."""
        return self._material_history is not None

    @property
    def history(self) -> MaterialHistory:
        """Internal variables of the materials by name, at the present time; in static problems after the last converged
        step.

        Raises:
            ValueError: no material has any.
        """
        return existing(self._material_history)
