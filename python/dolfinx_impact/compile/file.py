# SPDX-License-Identifier: MIT
"""Laws of a user's file, on all cells that are asked for."""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import ufl
from dolfinx.mesh import Mesh

from ..forms.registry import CELLS, FORMS
from ..materials import _Material
from ..own_forms import distorted_block
from ..own_forms.user_file import cells_of, things
from ..own_forms.own_form import OwnForm, made
from .case import Case
from .choice import Choice
from .form_law import case_of, law_of, terms_of_form, terms_of_own_form
from .material_law import law_of_material
from .own_law import OwnLaw


def laws_of(path: Path | str, name: str | None, choice: Choice) -> Iterator[OwnLaw]:
    """Laws of a file, one by one.

    Args:
        path: the file.
        name: name of the one law; None: all that `verify` would check.
        choice: what is asked for.

    Raises:
        FileNotFoundError: no such file.
        TypeError: a name of the file is no law.
        ValueError: the file raises, has no law, or a law does not exist as it is asked for.
    """
    found, namespace = things(path, name)
    for label in found:
        if not label.isascii():
            raise ValueError(f"{label!r} cannot be a name in C++: call it otherwise in {path}, in ASCII letters")
        if label in {form.split(".")[0] for form in FORMS}:
            raise ValueError(f"{label!r} is a name of the package's own forms: call yours otherwise in {path}")
    for label, thing in found.items():
        yield from _laws_of(thing, label, namespace, choice)


def _laws_of(thing: Any, name: str, namespace: Mapping[str, Any], choice: Choice) -> Iterator[OwnLaw]:
    if isinstance(thing, tuple) and len(thing) == 2:
        thing = OwnForm(*thing)
    if isinstance(thing, OwnForm):
        thing.check()
        thing = thing if thing.material is None else thing.material
    if isinstance(thing, _Material):
        yield from _of_material(thing, name, choice)
    elif isinstance(thing, (ufl.Form, OwnForm)):
        yield _of_form(thing, name, namespace, choice)
    elif callable(thing) and not isinstance(thing, type):
        yield from _of_function(thing, name, cells_of(namespace), choice)
    else:
        raise TypeError(
            f"{name} is of type {type(thing).__name__}: kernels are written of a function of a mesh that returns "
            "residual and unknown, of a material, or of a UFL form"
        )


def _mesh(case: Case) -> Mesh:
    """A small mesh of the cells: functions of a mesh are called with it."""
    return distorted_block.block(case.cell, 2, case.geometry_degree)


def _of_material(material: _Material, name: str, choice: Choice) -> Iterator[OwnLaw]:
    hypothesis = material.hypothesis or "3d"
    dimension = 3 if hypothesis == "3d" else 2
    own = Choice(choice.cells, choice.degrees, choice.geometry_degrees, [hypothesis])
    cells = [cell for cell in CELLS if CELLS[cell] == dimension]
    for cell in choice.cells or ():
        if CELLS[cell] != dimension:
            raise ValueError(
                f"the material {name} has the hypothesis {hypothesis}, which does not fit cells {cell!r}: give it "
                "another hypothesis in the file, or ask for other cells"
            )
    for case in own.cases(cells):
        other = choice.contradiction(case)
        if other:
            raise ValueError(f"{name} is written for {other}")
        yield law_of_material(material, name, _mesh(case), case)


def _of_form(thing: ufl.Form | OwnForm, name: str, namespace: Mapping[str, Any], choice: Choice) -> OwnLaw:
    """A form that is bound to its cells."""
    own = isinstance(thing, OwnForm)
    terms = terms_of_own_form(thing) if own else terms_of_form(thing, name, namespace)
    case = case_of(terms.u, terms.hypothesis, name)
    other = choice.contradiction(case)
    if other:
        raise ValueError(f"{name} is written for {other}: only a function of a mesh can be compiled for others")
    return law_of(terms, name, case)


def _of_function(function: Any, name: str, cells: tuple[str, ...] | None, choice: Choice) -> Iterator[OwnLaw]:
    """A function of a mesh; its parameters `degree` and `hypothesis`, if it has them, are those that are asked for."""
    parameters = inspect.signature(function).parameters
    for cell in cells or ():
        if cell not in CELLS:
            raise ValueError(f"the file names the cell {cell!r}: kernels are written for {', '.join(CELLS)}")
    seen = set()
    for asked in choice.cases(cells):
        given = {what: getattr(asked, what) for what in ("degree", "hypothesis") if what in parameters}
        if choice.degrees is None:
            given.pop("degree", None)
        own = made(partial(function, **given), name, _mesh(asked))
        mesh, material = own.u.function_space.mesh, own.material
        hypothesis = own.hypothesis or given.get("hypothesis")
        if material is not None:
            hypothesis = material.hypothesis_on(mesh)
        case = case_of(own.u, hypothesis, name)
        other = choice.only(asked).contradiction(case)
        if other:
            what = "degree" if other.startswith("degree") else "hypothesis"
            raise ValueError(
                f"{name}(mesh) is written for {other}: give it the parameter {what}, with a default, and use it"
            )
        if case in seen:
            continue
        seen.add(case)
        if material is not None:
            yield law_of_material(material, name, mesh, case)
        else:
            yield law_of(terms_of_own_form(own), name, case)
    if not seen:
        raise ValueError(f"{name}: none of the hypotheses {choice.hypotheses} fits the cells {cells} of the file")
