# SPDX-License-Identifier: MIT
"""Cauchy stress at the quadrature points of bodies of any material, evaluated when it is asked for."""

from __future__ import annotations

from typing import Any

import numpy as np
import ufl
from dolfinx.fem import Function

from ..common.types import FloatArray
from ..forms import elasticity
from ..forms.elasticity import STRESS
from ..forms.materials import von_mises_square
from ..forms.point_law import PointLaw
from ..inelastic import InelasticMaterial
from ..materials import Material, MaterialMap
from .inelastic_part import InelasticPart
from .operators import InternalForce, cells_measure, elastic_law_of
from .point_values import PointHistory

VON_MISES = "von_mises"


def von_mises(stress: FloatArray) -> FloatArray:
    """Von Mises' equivalent stress.

    Args:
        stress: components of forms.materials.stress_components, (..., 4) or (..., 6) [F/L^2].

    Returns:
        Equivalent stress, (...) [F/L^2].
    """
    square: FloatArray = von_mises_square(*np.moveaxis(stress, -1, 0))
    return np.sqrt(square)


class CauchyStress:
    """Cauchy stress of bodies, by kernels of its own.

    Where there are internal variables they solve the local equations once more, from the history of the last step at
    the present displacement: a step without a change of strain, which leaves the history of a rate-independent law as
    it is.

    Args:
        u: displacement function [L].
        material: material of the bodies.
        points: internal variables of the problem; None: no material has any.

    Attributes:
        degree: quadrature degree of the points [1].
    """

    def __init__(self, u: Function, material: Material, points: PointHistory | None = None) -> None:
        self._points = points
        v = ufl.TestFunction(u.function_space)
        dx, degree = cells_measure(u, material)
        self.degree = degree
        form: Any = 0
        laws: dict[int, PointLaw] = {}
        by_material: dict[int, PointLaw] = {}  # UFL makes one integral of the tags that share an elastic material
        for tag, m in material.parts():
            measure = dx if tag is None else dx(tag)
            if isinstance(m, InelasticMaterial):
                part = InelasticPart(u, m, measure, degree, tag, material)
                work, law = part.force(v, with_stress=True)
            else:
                elastic = elastic_law_of(u, m, material)
                work, law = elasticity.internal_force_with_stress(u, v, elastic, measure)
                law = by_material.setdefault(id(m), law)
            form = form + work
            laws[-1 if tag is None else tag] = law
        self._force = InternalForce(form, law=laws if isinstance(material, MaterialMap) else laws[-1])
        self._forces: FloatArray = self._force.vector().array

    def values(self) -> FloatArray:
        """Evaluate the stress at the present displacement. Collective.

        Returns:
            Components (forms.materials.stress_components) on this rank, (num_owned_cells, num_points,
            num_components) [F/L^2].
        """
        own = self._set_history()
        self._forces[:] = 0.0
        self._force.assemble(self._forces)
        values = own.values(STRESS, trial=True)
        own.revert()
        return values

    def forces(self) -> FloatArray:
        """Nodal forces of the stress at the present displacement, owned entries complete [F]. Collective."""
        own = self._set_history()
        forces: FloatArray = self._force.apply().array
        own.revert()
        return forces

    def _set_history(self) -> Any:
        """Take over the internal variables of the problem.

        Returns:
            Those of these kernels (C++).
        """
        own = self._force.history
        if self._points is not None:
            for name in own.state_names:
                own.set_values(name, self._points.values(name))
        return own
