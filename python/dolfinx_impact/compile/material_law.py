# SPDX-License-Identifier: MIT
"""Laws that are materials: those of the package with the numbers of a file, and inelastic ones of a user's own."""

from __future__ import annotations

import ufl
from dolfinx import fem
from dolfinx.mesh import Mesh

from ..assembly import operators
from ..assembly.inelastic_part import InelasticPart
from ..forms import elasticity
from ..inelastic import InelasticMaterial
from ..materials import FULL, _Material
from .case import Case
from .further_forms import mass_form
from .own_law import DENSITY, DISPLACEMENT, KernelForm, Named, OwnLaw, values_of

NO_ENERGY = "the stored energy depends on the internal variables: the kernel of the force sums it up as 'elastic'"


def law_of_material(material: _Material, name: str, mesh: Mesh, case: Case) -> OwnLaw:
    """A material with its kernels' forms.

    Args:
        material: the material.
        name: its name.
        mesh: mesh of the cells.
        case: the cells.
    """
    if material.integration != FULL:
        raise ValueError(f"{material!r} has no kernels of cells alone: use integration={FULL!r} for C++")
    V = fem.functionspace(mesh, ("Lagrange", case.degree, (mesh.geometry.dim,)))
    u, v, du = fem.Function(V, name=DISPLACEMENT), ufl.TestFunction(V), ufl.TrialFunction(V)
    dx, degree = operators.cells_measure(u, material)
    missing = {}
    names: dict[Named, str] = {u: DISPLACEMENT}
    if isinstance(material, InelasticMaterial):
        part = InelasticPart(u, material, dx, degree, None)
        tangent, of_tangent = part.tangent_form()
        names |= of_tangent
        forms = {
            "force": KernelForm(*part.force(v)),
            "tangent": KernelForm(tangent),
            "elastic_tangent": KernelForm(part.elastic_tangent(du, v)),
            "stress": KernelForm(*part.force(v, with_stress=True)),
        }
        missing = {"energy": NO_ENERGY}
    else:
        forms = {
            "force": KernelForm(operators.internal_force_form(u, v, material)),
            "tangent": KernelForm(operators.tangent_form(u, du, v, material)),
            "energy": KernelForm(operators.strain_energy_form(u, material)),
            "stress": KernelForm(*elasticity.internal_force_with_stress(u, v, material.law(mesh), dx)),
        }
    mass, density = mass_form(u, case)
    forms["mass"] = KernelForm(mass)
    names |= {constant: of for of, constant in material.constants_on(mesh).items()}
    values = values_of(names)
    if material.density is not None:
        values[DENSITY] = [material.density]
    return OwnLaw(name, case, forms, names | {density: DENSITY}, values, missing)
