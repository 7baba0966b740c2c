# SPDX-License-Identifier: MIT
"""Runs the checks of a form of one's own on its cells."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import ufl
from dolfinx.mesh import Mesh

from dolfinx_impact.common.progress_bar import transient_bar
from dolfinx_impact.own_forms import distorted_block
from dolfinx_impact.forms import registry
from dolfinx_impact.interface import FrictionLaw, InterfaceLaw
from ..model_warnings import model_warnings_off
from .definite import definiteness
from .energy import energy, symmetry, taylor
from .file import Source, source_of, sources
from .findings import SelfCheckReport
from .friction_law import check_friction_law
from .interface_law import check_interface_law
from .kernels import kernels
from .manufactured import manufactured
from dolfinx_impact.own_forms.own_form import made
from .parameters import parameters
from .patch import patch
from .ranks import ranks
from .rigid import frame, momentum, rest, rotation, translation
from .rule import rule
from .subject import Subject

CHECKS: Mapping[str, Callable[[Subject], None]] = {
    "symmetry": symmetry,
    "energy": energy,
    "taylor": taylor,
    "rest": rest,
    "translation": translation,
    "rotation": rotation,
    "frame": frame,
    "momentum": momentum,
    "definiteness": definiteness,
    "rule": rule,
    "patch": patch,
    "manufactured": manufactured,
    "kernels": kernels,
    "ranks": ranks,
    "parameters": parameters,
}
CELLS = ("quadrilateral", "triangle")  # of functions of a mesh, unless others are named


def block(cell: str, geometry_degree: int, n: int) -> Mesh:
    """Block of the checks: sides of length 1, x[0] from 0.5 so that it can be a ring, inner nodes moved.

    Args:
        cell: cell.
        geometry_degree: degree of the geometry, 1 or 2.
        n: cells per side.
    """
    mesh = distorted_block.block(cell, n, geometry_degree)
    mesh.geometry.x[:, 0] += 0.5
    return mesh


def self_check(
    form: Any,
    name: str | None = None,
    *,
    cells: Collection[str] | None = None,
    checks: Collection[str] | None = None,
    report: SelfCheckReport | None = None,
    progress: bool = False,
    **options: Any,
) -> SelfCheckReport:
    """Check what must hold of any residual, for forms that have no hand-written counterpart. Collective.

    Every rank makes all checks by itself, but for `ranks`, which compares them.

    Args:
        form: function of a mesh that returns `verify.OwnForm` or residual and unknown; a UFL residual, energy or
            bilinear form without functions that vary; a material; a law of the interface or of friction; or the path
            of a file.
        name: name in a file; None: everything there that can be checked. Of other forms, how findings call it.
        cells: cells to check on; None: quadrilaterals and triangles, those that a file names in `cells`, or those of
            the form's own mesh.
        checks: names of checks, a part of selfcheck.run.CHECKS; None: all.
        report: report to add to; None makes a new one.
        progress: show a progress bar.
        options: for forms of UFL: arguments of `verify.OwnForm` (u, energy, parameters, grounded, ...); for laws of the
            interface `length`, `velocity` and `isotropic` of selfcheck.interface_law.check_interface_law, for those of
            friction `pressure`, `velocity` and `isotropic` of selfcheck.friction_law.check_friction_law.

    Returns:
        Report with `rows` (check, what was found, tolerance, sentence) and `passed`.

    Raises:
        TypeError: `form` is nothing that can be checked.
        ValueError: unknown cell or check, or the form cannot be used; the message says what to do.
        FileNotFoundError: no such file.
    """
    report = SelfCheckReport() if report is None else report
    if isinstance(form, InterfaceLaw):
        check_interface_law(report, form, name or form.name, **options)
        return report
    if isinstance(form, FrictionLaw):
        check_friction_law(report, form, name or form.name, **options)
        return report
    for check in checks or ():
        if check not in CHECKS:
            raise ValueError(f"check {check!r} is unknown: use {', '.join(CHECKS)}")
    for cell in cells or ():
        if cell not in registry.CELLS:
            raise ValueError(f"cell {cell!r} is unknown: use {', '.join(registry.CELLS)}")
    if isinstance(form, (str, Path)):
        found, named = sources(form, name)
    else:
        own = name if name is not None else str(getattr(form, "__name__", "form"))
        found, named = {own: source_of(form, own, **options)}, None
    jobs = [(n, s, cell) for n, s in found.items() for cell in _cells(n, s, cells or named)]
    with transient_bar(progress) as bar, model_warnings_off():
        task = bar.add_task("checks", total=len(jobs) * len(checks or CHECKS))
        for n, s, cell in jobs:
            subject = _subject(n, s, cell, report)
            for check, run in CHECKS.items():
                if not checks or check in checks:
                    bar.update(task, description=f"{n} on {cell}s: {check}")
                    run(subject)
                    subject.u.x.array[:] = subject.rest
                    bar.advance(task)
    return report


def _cells(name: str, source: Source, cells: Collection[str] | None) -> list[str]:
    if source.cell is None:
        return list(cells or source.cells or CELLS)
    if cells and source.cell not in cells:
        raise ValueError(f"{name} is written on {source.cell}s: only a function of a mesh can be checked on others")
    return [source.cell]


def _subject(name: str, source: Source, cell: str, report: SelfCheckReport) -> Subject:
    if cell not in registry.CELLS:
        raise ValueError(f"{name} is written on cells {cell!r}: checks are made on {', '.join(registry.CELLS)}")
    mesh_of = partial(block, cell, source.geometry_degree)
    n = 3 if cell in ("triangle", "quadrilateral") else 2
    own = made(source.maker, name, mesh_of(n))
    try:
        return Subject(name, own, partial(made, source.maker, name), report, mesh_of, n)
    except ufl.UFLException if hasattr(ufl, "UFLException") else AssertionError as e:
        raise ValueError(f"{name} cannot be compiled: {e}") from e
