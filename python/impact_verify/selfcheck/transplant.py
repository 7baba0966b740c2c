# SPDX-License-Identifier: MIT
"""A form on one mesh, or on a symbolic one, written anew on another mesh of the same cells."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.mesh import Mesh
from ufl.algorithms import extract_coefficients
from ufl.algorithms.analysis import extract_constants
from ufl.algorithms.map_integrands import map_integrand_dags
from ufl.corealg.multifunction import MultiFunction

from dolfinx_impact.own_forms.own_form import Maker, OwnForm


class _Mover(MultiFunction):  # type: ignore[misc]  # UFL has no types
    """Replaces functions, constants, arguments and places of one mesh by those of another."""

    def __init__(self, mesh: Mesh, terminals: Mapping[Any, Any]) -> None:
        super().__init__()
        self.mesh, self.terminals = mesh, terminals
        self.spaces: dict[Any, Any] = {}

    def expr(self, o: Any, *operands: Any) -> Any:
        return self.reuse_if_untouched(o, *operands)

    def terminal(self, o: Any) -> Any:
        return o

    def coefficient(self, o: Any) -> Any:
        return self.terminals[o]

    constant = coefficient

    def argument(self, o: Any) -> Any:
        return type(o)(self.space(o), o.number(), o.part())

    def space(self, o: Any) -> Any:
        element = o.ufl_function_space().ufl_element()
        return self.spaces.setdefault(element, fem.functionspace(self.mesh, element))

    def geometric_quantity(self, o: Any) -> Any:
        return type(o)(self.mesh.ufl_domain())


def _value(function: Any, name: str) -> Any:
    """The one value that a function has everywhere, zero for symbolic ones.

    Raises:
        ValueError: it varies.
    """
    array = function.x.array if isinstance(function, fem.Function) else np.zeros(1)
    if np.ptp(array) > 0.0:
        raise ValueError(
            f"the residual contains the function {name!r}, which varies: give a function of a mesh that writes the "
            "form, def my_form(mesh): ..."
        )
    return array[0] if len(array) else 0.0


def maker_of(
    form: ufl.Form,
    u: Any,
    values: Mapping[Any, Any],
    energy: ufl.Form | None = None,
    parameters: Mapping[str, Any] | None = None,
    **options: Any,
) -> Maker:
    """Function that writes a form, and its energy, on other meshes of its cells.

    Args:
        form: residual on a mesh of DOLFINx or a symbolic one.
        u: its unknown.
        values: values of symbolic constants.
        energy: energy of the residual.
        parameters: constants of the form by name.
        options: further arguments of OwnForm.

    Returns:
        Function of a mesh.

    Raises:
        ValueError: the form integrates over tagged parts, or contains functions that vary.
    """
    forms = [f for f in (form, energy) if f is not None]
    for integral in (i for f in forms for i in f.integrals()):
        if integral.subdomain_id() not in ("everywhere", "otherwise"):
            raise ValueError(
                f"the form integrates over the tag {integral.subdomain_id()} of its mesh: give a function of a mesh "
                "that writes the form, def my_form(mesh): ..."
            )
    for c in {c for f in forms for c in extract_coefficients(f)} - {u}:
        _value(c, getattr(c, "name", str(c)))

    def maker(mesh: Mesh) -> OwnForm:
        mover = _Mover(mesh, {})
        terminals: dict[Any, Any] = {}
        for c in [u, *(c for f in forms for c in extract_coefficients(f))]:
            if c not in terminals:
                terminals[c] = fem.Function(mover.space(c), name=getattr(c, "name", "u" if c is u else "w"))
                terminals[c].x.array[:] = _value(c, "u") if c is not u or isinstance(c, fem.Function) else 0.0
        for c in {c for f in forms for c in extract_constants(f)}:
            terminals[c] = fem.Constant(mesh, np.array(values[c] if c in values else c.value, dtype=float))
        mover.terminals = terminals

        def moved(f: ufl.Form) -> ufl.Form:
            f = map_integrand_dags(mover, f)
            return ufl.Form([i.reconstruct(domain=mesh.ufl_domain()) for i in f.integrals()])

        own = {name: terminals[c] for name, c in (parameters or {}).items() if c in terminals}
        return OwnForm(moved(form), terminals[u], None if energy is None else moved(energy), parameters=own, **options)

    return maker
