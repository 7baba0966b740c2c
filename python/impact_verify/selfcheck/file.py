# SPDX-License-Identifier: MIT
"""Forms of a user's file: functions of a mesh, residuals, energies, materials."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.mesh import Mesh
from ufl.algorithms import extract_coefficients
from ufl.algorithms.analysis import extract_constants

from dolfinx_impact import compat
from dolfinx_impact.assembly import operators
from dolfinx_impact.inelastic import InelasticMaterial
from dolfinx_impact.materials import _Material
from ..user_form import check_body
from dolfinx_impact.own_forms.own_form import OwnForm
from dolfinx_impact.own_forms.user_file import cells_of, things, unknown_of
from .transplant import maker_of

# Values of symbolic constants, by the names that they have in a file.
USUAL = {"E": 1.0, "young": 1.0, "nu": 0.3, "poisson_ratio": 0.3, "mu": 0.4, "lmbda": 0.6, "lam": 0.6, "lambda_": 0.6}


@dataclass
class Source:
    """Something that can be checked.

    Args:
        maker: function of a mesh.
        cell: cell that the form is bound to; None: that of the mesh which it is given.
        geometry_degree: degree of the geometry that it is bound to [1].
        cells: cells to check on if none are named; None: those of the checks.
    """

    maker: Callable[[Mesh], Any]
    cell: str | None = None
    geometry_degree: int = 1
    cells: tuple[str, ...] | None = None


def source_of(thing: Any, name: str, namespace: Mapping[str, Any] | None = None, **options: Any) -> Source:
    """Make something of a user's checkable.

    Args:
        thing: function of a mesh, OwnForm, residual (UFL form of rank 1), energy (rank 0), bilinear form (rank 2),
            pair of residual and unknown, or material.
        name: its name, for errors.
        namespace: names of the file that it is from: `u`, constants, `hypothesis`.
        options: arguments of OwnForm, for forms.

    Returns:
        What the checks take.

    Raises:
        TypeError: it is nothing that can be checked.
        ValueError: its unknown is not known, or it cannot be written on another mesh.
    """
    names = dict(namespace or {})
    if isinstance(thing, _Material):
        return _of_material(thing)
    if isinstance(thing, tuple) and len(thing) == 2:
        thing = OwnForm(*thing)
    if isinstance(thing, OwnForm):
        thing.check()
        if thing.material is not None:
            return _of_material(thing.material)
        own = thing
        given = {k: getattr(own, k) for k in OwnForm.__dataclass_fields__ if k not in _FORMS}
        return _source(maker_of(own.residual, own.u, {}, own.energy, own.parameters, **given), own.u)
    if isinstance(thing, ufl.Form):
        return _of_form(thing, name, names, options)
    if callable(thing) and not isinstance(thing, type):
        return Source(thing)
    raise TypeError(
        f"{name} is of type {type(thing).__name__}: give a function of a mesh that returns residual and unknown, or a "
        "UFL form"
    )


_FORMS = ("residual", "u", "energy", "tangent", "material", "parameters", "stress")


def _source(maker: Callable[[Mesh], OwnForm], u: Any) -> Source:
    domain = u.ufl_function_space().ufl_domain()
    check_body(domain)
    element = domain.ufl_coordinate_element()
    return Source(maker, compat.cell_name(domain), int(element.embedded_superdegree) and _degree(element))


def _degree(element: Any) -> int:
    sub = element.sub_elements[0] if element.block_size > 1 else element
    return int(sub.basix_element.degree)


def _of_material(material: _Material) -> Source:
    """A material, on linear elements; one without a hypothesis is checked in space."""
    space = material.hypothesis in (None, "3d")
    return Source(partial(_form_of_material, material), cells=("hexahedron", "tetrahedron") if space else None)


def _form_of_material(material: _Material, mesh: Mesh) -> OwnForm:
    V = fem.functionspace(mesh, ("Lagrange", 1, (mesh.geometry.dim,)))
    u, hypothesis = fem.Function(V, name="displacement"), material.hypothesis
    if isinstance(material, InelasticMaterial):
        return OwnForm(None, u, material=material, hypothesis=hypothesis)
    residual = operators.internal_force_form(u, ufl.TestFunction(V), material)
    return OwnForm(residual, u, operators.strain_energy_form(u, material), hypothesis=hypothesis)


def _of_form(form: ufl.Form, name: str, names: Mapping[str, Any], options: Mapping[str, Any]) -> Source:
    """A residual, an energy, or a bilinear form."""
    options = dict(options)
    u = options.pop("u", None)
    if u is None:
        u = unknown_of(form, name, names)
    energy = options.pop("energy", None)
    rank = len(form.arguments())
    if rank == 0:
        energy, form = form, ufl.derivative(form, u, ufl.TestFunction(u.ufl_function_space()))
    elif rank == 2:
        if u in extract_coefficients(form):
            raise ValueError(f"{name} is a tangent at u: give the residual, its tangent is found by differentiation")
        form = ufl.action(form, u)
    options.setdefault("hypothesis", names.get("hypothesis"))
    values, parameters = {}, dict(options.pop("parameters", None) or {})
    constants = extract_constants(form) + ([] if energy is None else extract_constants(energy))
    rng = np.random.default_rng(2026)
    of_name = {id(c): n for n, c in names.items() if isinstance(c, ufl.Constant)}
    for c in constants:
        if not isinstance(c, fem.Constant):
            value = USUAL.get(of_name.get(id(c), ""), None)
            values[c] = rng.uniform(0.5, 1.0, c.ufl_shape) if value is None else value
    return _source(maker_of(form, u, values, energy, parameters, **options), u)


def sources(path: Path | str, name: str | None = None) -> tuple[dict[str, Source], tuple[str, ...] | None]:
    """What can be checked in a user's file.

    Args:
        path: the file.
        name: as in `things`.

    Returns:
        Sources by name, and the cells that the file names in `cells`; None if it names none.

    Raises:
        FileNotFoundError: no such file.
        ValueError: the file raises, or there is nothing to check in it, or nothing of this name.
    """
    chosen, namespace = things(path, name)
    return {n: source_of(o, n, namespace) for n, o in chosen.items()}, cells_of(namespace)
