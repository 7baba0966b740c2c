# SPDX-License-Identifier: MIT
"""Internal force of bodies of elastic and inelastic materials, and the stiffness that bounds their frequencies."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import ufl
from dolfinx.fem import Function

from ..forms import elasticity
from ..forms.inelastic import ELASTIC_ENERGY
from ..forms.point_law import PointLaw
from ..inelastic import InelasticMaterial
from ..materials import AVERAGED_STRAIN, Material, _Material
from . import operators
from .inelastic_part import InelasticParts
from .nodal_mean import StrainParts, strain_parts


@dataclass
class BodyForms:
    """Forms of bodies for explicit steps.

    Attributes:
        internal: internal virtual work, of rank 1, less that of `nodal`.
        stiffness: stiffness, of inelastic materials that of their elastic part, of rank 2.
        linear: whether the internal force is linear in the displacement.
        laws: point laws of the kernels, one or by cell tag; None without internal variables.
        parts: inelastic parts; None without.
        nodal: means of strains whose forces are added node by node.
    """

    internal: ufl.Form
    stiffness: ufl.Form
    linear: bool
    laws: PointLaw | dict[int, PointLaw] | None = None
    parts: InelasticParts | None = None
    nodal: list[StrainParts] = field(default_factory=list)


def body_forms(u: Function, material: Material) -> BodyForms:
    """Forms of the bodies of a material or MaterialMap.

    Args:
        u: displacement function [L].
        material: material of the bodies.
    """
    V = u.function_space
    v, du = ufl.TestFunction(V), ufl.TrialFunction(V)
    stiffness = operators.tangent_form(u, du, v, material)
    if not any(isinstance(m, InelasticMaterial) for _, m in material.parts()):
        internal, nodal = _elastic_forces(u, v, material)
        linear = all(m.elastic_law(V.mesh).linear for _, m in material.parts())
        return BodyForms(internal, stiffness, linear, nodal=nodal)
    internal = operators.internal_force_form(u, v, material)
    parts = InelasticParts(u, material)
    form, laws = parts.force(v)
    if isinstance(laws, dict):  # the elastic energy of the other parts is needed, too
        by_material: dict[int, PointLaw] = {}  # UFL makes one integral of the tags that share a material
        for tag, m in material.parts():
            if tag is not None and not isinstance(m, InelasticMaterial):
                if id(m) not in by_material:
                    law = operators.elastic_law_of(u, m, material)
                    energy = elasticity.energy_integrand(u, law)
                    by_material[id(m)] = PointLaw(outputs={}, sums={ELASTIC_ENERGY: energy})
                laws[tag] = by_material[id(m)]
        form, stiffness = form + internal, parts.elastic_tangent(du, v) + stiffness
    else:
        stiffness = parts.elastic_tangent(du, v)
    return BodyForms(form, stiffness, False, laws, parts)


def _elastic_forces(u: Function, v: ufl.Argument, material: Material) -> tuple[ufl.Form, list[StrainParts]]:
    """Internal virtual work of elastic cells, and means of strains whose forces are added node by node."""
    whole_dx, _ = operators.cells_measure(u, material)
    nodal: dict[int, StrainParts] = {}  # of each mean, which tags may share

    def term(m: _Material, dx: ufl.Measure) -> ufl.Form:
        if m.integration != AVERAGED_STRAIN:
            return elasticity.internal_force(u, v, operators.elastic_law_of(u, m, material), dx)
        parts = strain_parts(u, m, material, whole_dx)
        nodal[id(parts.mean)] = parts
        return elasticity.internal_force(u, v, parts.cells, dx)

    return operators.sum_materials(u, material, term), list(nodal.values())


def stiffness_damping(u: Function, velocity: Function, v: ufl.Argument, material: Material, beta: Any) -> ufl.Form:
    """Virtual work of stiffness-proportional damping; the stiffness of an inelastic material is its elastic one.

    Args:
        u: displacement function [L].
        velocity: velocity function [L/T].
        v: test function.
        material: material of the bodies.
        beta: factor [T].
    """
    form = operators.sum_laws(u, material, lambda law, dx: beta * elasticity.tangent(u, velocity, v, law, dx))
    if any(isinstance(m, InelasticMaterial) for _, m in material.parts()):
        form = form + beta * InelasticParts(u, material).elastic_tangent(velocity, v)
    return form
