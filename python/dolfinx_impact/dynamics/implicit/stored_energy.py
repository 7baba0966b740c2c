# SPDX-License-Identifier: MIT
"""Energy stored in the bodies of an implicit problem and in their foundations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import ufl
from dolfinx import fem

from ...common.described import Described
from ...assembly import operators
from ...foundation import Foundation
from ...forms.inelastic import ELASTIC_ENERGY
from ...materials import MaterialMap, _Material
from ...statics.body import Body
from ...statics.material_body import MaterialBody


class StoredEnergy(Described):
    """Strain energy of elastic materials, elastic energy of those with internal variables, and that of foundations.

    Args:
        u: displacement function [L].
        material: material or MaterialMap; None: a residual of the user's own, whose energy is not known.
        body: bodies without inertia.
        foundations: springs to the ground, with a material.
    """

    def __init__(
        self,
        u: fem.Function,
        material: _Material | MaterialMap | None,
        body: Body,
        foundations: Sequence[Foundation] = (),
    ) -> None:
        self._known, self._body = material is not None, body
        form: Any = None if material is None else operators.strain_energy_form(u, material)
        if foundations and self._known:  # an inelastic body alone has no strain energy: its form is zero
            springs = [f.energy_form(u, material) for f in foundations]
            form = sum(springs, form) if isinstance(form, ufl.Form) else sum(springs[1:], springs[0])
        self._elastic = operators.Energy(form) if isinstance(form, ufl.Form) else None

    def value(self) -> float | None:
        """Energy at the last residual [F L]; None: it is not known. Collective."""
        if not self._known:
            return None
        stored = 0.0 if self._elastic is None else self._elastic.value()
        if isinstance(self._body, MaterialBody) and self._body.force is not None:
            stored += self._body.force.sum(ELASTIC_ENERGY)
        return stored
