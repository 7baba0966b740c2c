# SPDX-License-Identifier: MIT
"""Energy stored in the bodies of an implicit problem and in their foundations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import ufl
from dolfinx import fem

from ...assembly import operators
from ...foundation import Foundation
from ...materials import MaterialMap, _Material


def stored_energies(
    u: fem.Function, material: _Material | MaterialMap, foundations: Sequence[Foundation] = ()
) -> list[operators.Energy]:
    """Strain energy of elastic materials and that of foundations. Materials with internal variables find their own.

    Args:
        u: displacement function [L].
        material: material or MaterialMap.
        foundations: springs to the ground.

    Returns:
        One operator, or none where nothing else stores energy.
    """
    form: Any = operators.strain_energy_form(u, material)
    if foundations:  # an inelastic body alone has no strain energy: its form is zero
        springs = [f.energy_form(u, material) for f in foundations]
        form = sum(springs, form) if isinstance(form, ufl.Form) else sum(springs[1:], springs[0])
    return [operators.Energy(form)] if isinstance(form, ufl.Form) else []
