# SPDX-License-Identifier: MIT
"""Energy stored in the bodies of an implicit problem."""

from __future__ import annotations

import ufl
from dolfinx import fem

from ...assembly import operators
from ...forms.inelastic import ELASTIC_ENERGY
from ...materials import MaterialMap, _Material
from ...statics.body import Body
from ...statics.inelastic_body import InelasticBody


class StoredEnergy:
    """Strain energy of elastic materials, and elastic energy of those with internal variables.

    Args:
        u: displacement function [L].
        material: material or MaterialMap; None: a residual of the user's own, whose energy is not known.
        body: bodies without inertia.
    """

    def __init__(self, u: fem.Function, material: _Material | MaterialMap | None, body: Body) -> None:
        self._known, self._body = material is not None, body
        form = None if material is None else operators.strain_energy_form(u, material)
        self._elastic = operators.Energy(form) if isinstance(form, ufl.Form) else None

    def value(self) -> float | None:
        """Energy at the last residual [F L]; None: it is not known. Collective."""
        if not self._known:
            return None
        stored = 0.0 if self._elastic is None else self._elastic.value()
        if isinstance(self._body, InelasticBody):
            stored += self._body.force.sum(ELASTIC_ENERGY)
        return stored
