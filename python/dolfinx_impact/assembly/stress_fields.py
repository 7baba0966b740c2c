# SPDX-License-Identifier: MIT
"""Stress of a problem's bodies as fields."""

from __future__ import annotations

from dolfinx.fem import Function

from ..common.described import Described
from ..materials import Material
from ..forms.elasticity import STRESS
from ..forms.materials import stress_components
from .cauchy_stress import VON_MISES, CauchyStress, von_mises
from .history_field import HistoryField
from .point_values import PointHistory


class StressFields(Described):
    """Cauchy stress of bodies, "stress", and von Mises' equivalent stress, "von_mises", of any material.

    Args:
        u: displacement function [L].
        material: material of the bodies.
        points: internal variables of the problem; None: no material has any.
    """

    def __init__(self, u: Function, material: Material, points: PointHistory | None = None) -> None:
        self._mesh, self._stress = u.function_space.mesh, CauchyStress(u, material, points)

    def __getitem__(self, name: str) -> HistoryField:
        evaluate, degree = self._stress.values, self._stress.degree
        if name == VON_MISES:
            return HistoryField(name, (), degree, self._mesh, lambda: von_mises(evaluate())[..., None])
        if name == STRESS:
            return HistoryField(name, (len(stress_components(self._mesh.geometry.dim)),), degree, self._mesh, evaluate)
        raise KeyError(f"a stress field is called {STRESS!r} or {VON_MISES!r}, not {name!r}")
