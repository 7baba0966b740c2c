# SPDX-License-Identifier: MIT
"""Laws that are written as forms: a residual with its unknown, an energy, a bilinear form."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import ufl
from dolfinx import fem
from ufl.algorithms import extract_coefficients

from .. import compat
from ..assembly.residual import differentiable
from ..forms.quadrature import with_rules
from ..forms.registry import CELLS, default_hypothesis
from ..own_forms.user_file import unknown_of
from ..own_forms.own_form import OwnForm
from .case import Case
from .further_forms import mass_form, stress_form
from .own_law import DENSITY, DISPLACEMENT, KernelForm, Named, OwnLaw, constants_of, values_of


@dataclass
class Terms:
    """What is known of a law.

    Attributes:
        residual: residual.
        u: its unknown.
        energy: form of rank 0, or None.
        tangent: form of rank 2; None: the derivative of the residual.
        stress: Cauchy stress, 3 x 3; None: not known [F/L^2].
        hypothesis: None: "3d" or "plane_strain".
        names: names of constants and functions.
    """

    residual: ufl.Form
    u: Any
    energy: ufl.Form | None = None
    tangent: ufl.Form | None = None
    stress: Any = None
    hypothesis: str | None = None
    names: dict[Named, str] = field(default_factory=dict)


def terms_of_own_form(own: OwnForm) -> Terms:
    """Terms of what a function of a mesh returns.

    Args:
        own: residual and unknown, and what is said about them.
    """
    names = {constant: name for name, constant in own.parameters.items()}
    return Terms(own.residual, own.u, own.energy, own.tangent, own.stress, own.hypothesis, names)


def terms_of_form(form: ufl.Form, name: str, namespace: Mapping[str, Any]) -> Terms:
    """Terms of a form of a file: a residual, an energy, or a bilinear form.

    Args:
        form: the form, on a symbolic mesh as for FFCx or on one of DOLFINx.
        name: its name, for errors.
        namespace: names of the file.

    Raises:
        ValueError: its unknown is not known, or it is the tangent at a state.
    """
    u, rank = unknown_of(form, name, namespace), len(form.arguments())
    kinds = (ufl.Constant, ufl.Coefficient)
    names = {o: n for n, o in namespace.items() if isinstance(o, kinds) and not n.startswith("_")}
    energy, tangent = None, None
    if rank == 0:
        energy, form = form, ufl.derivative(with_rules(form), u, ufl.TestFunction(u.ufl_function_space()))
    elif rank == 2:
        if u in extract_coefficients(form):
            raise ValueError(f"{name} is a tangent at u: give the residual, its tangent is found by differentiation")
        tangent, form = form, ufl.action(form, u)
    return Terms(form, u, energy, tangent, None, namespace.get("hypothesis"), names)


def case_of(u: Any, hypothesis: str | None, name: str) -> Case:
    """Cells that a law is written on.

    Args:
        u: its unknown.
        hypothesis: its hypothesis; None: "3d" or "plane_strain".
        name: its name, for errors.

    Raises:
        ValueError: kernels are not written for these cells.
    """
    V = u.ufl_function_space()
    domain = V.ufl_domain()
    cell, element = compat.cell_name(domain), domain.ufl_coordinate_element()
    gdim = compat.geometric_dimension(domain)
    if cell not in CELLS or gdim != CELLS[cell]:
        raise ValueError(
            f"{name} is on cells {cell!r} in {gdim} dimensions: kernels are written for bodies "
            f"of {', '.join(CELLS)} cells"
        )
    degree, geometry_degree = int(V.ufl_element().embedded_superdegree), int(element.embedded_superdegree)
    return Case(cell, degree, geometry_degree, hypothesis or default_hypothesis(cell))


def law_of(terms: Terms, name: str, case: Case) -> OwnLaw:
    """The law with its kernels' forms.

    Args:
        terms: what is known of the law.
        name: its name.
        case: its cells.

    Raises:
        ValueError: a function has no name, or UFL cannot differentiate the residual.
    """
    u, residual = terms.u, terms.residual
    V = u.ufl_function_space()
    names: dict[Named, str] = {u: DISPLACEMENT}
    terms_given = (residual, terms.energy, terms.tangent, terms.stress)
    for k, constant in enumerate(constants_of(*terms_given)):
        names[constant] = terms.names.get(constant, f"constant_{k}")
    for c in {c for term in terms_given if term is not None for c in extract_coefficients(term)} - {u}:
        given = terms.names.get(c) or (c.name if isinstance(c, fem.Function) and c.name != "f" else None)
        if given is None:
            raise ValueError(f"{name} has a function without a name: give it one, fem.Function(V, name='temperature')")
        names[c] = given
    forms, missing = {"force": KernelForm(residual)}, {}
    tangent = terms.tangent
    if tangent is None:
        with differentiable():
            tangent = ufl.derivative(with_rules(residual), u, ufl.TrialFunction(V))
    forms["tangent"] = KernelForm(tangent)
    if terms.energy is not None:
        forms["energy"] = KernelForm(terms.energy)
    else:
        missing["energy"] = "the file does not say of which energy the residual is the derivative, OwnForm(energy=)"
    mass, density = mass_form(u, case)
    forms["mass"] = KernelForm(mass)
    if terms.stress is not None:
        forms["stress"] = stress_form(u, terms.stress, case)
    else:
        missing["stress"] = "the file does not say what the Cauchy stress is, OwnForm(stress=)"
    values = values_of(names)
    return OwnLaw(name, case, forms, names | {density: DENSITY}, values, missing)
