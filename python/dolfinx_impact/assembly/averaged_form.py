# SPDX-License-Identifier: MIT
"""Bilinear forms with averages over a cell, which FFCx does not know: their matrices column by column. So are those of
cells with one point, whose matrices have so many factors that a compiler takes a minute for them.

The form a(du, v) is compiled as a vector, a(d, v), of a coefficient d in the place of the trial function. Its kernel
computes averages as those of values. Column j of a cell's matrix is this vector with the j-th degree of freedom of d
set (cpp/dolfinx_impact/operators/CellMatrix.h).
"""

from __future__ import annotations

from typing import Any

import ufl
from dolfinx.fem import Function, FunctionSpace
from ufl.algorithms import expand_derivatives

from ..forms.compiler import averages, geometry
from ..forms.consistent_tangent import DIRECTION
from ..forms.reference_derivatives import has_reference_derivatives
from .jit import Compiled, compile_form, find_form


def has_averages(form: ufl.Form) -> bool:
    """Whether a form has averages or maxima over a cell, or volumes of cells that are not affine.

    Args:
        form: UFL form.
    """
    return any(averages.has_averages(i.integrand()) for i in geometry.with_sizes(form).integrals())


def _by_columns(form: ufl.Form) -> bool:
    """Whether the matrices of a bilinear form are computed column by column."""
    if has_averages(form):
        return True
    return any(has_reference_derivatives(i.integrand()) for i in form.integrals()) and find_form(form) is None


def compile_matrices(form: ufl.Form, V: FunctionSpace) -> Compiled:
    """Kernels of a bilinear form without averages over cells, of its matrices or of their columns. Collective.

    Args:
        form: UFL form of rank 2.
        V: space of test and trial functions.
    """
    return compile_columns(form, V) if _by_columns(form) else compile_form(form)


def split_averages(form: ufl.Form) -> tuple[ufl.Form | None, ufl.Form | None]:
    """Split a form into the integrals that kernels of matrices take, and those over cells if any of them has averages:
    together, as bounds of a sum are sharper than sums of bounds.

    Args:
        form: UFL form of rank 2.

    Returns:
        Both parts; None where one has no integrals.
    """
    if not _by_columns(form):
        return form, None
    parts: dict[bool, list[Any]] = {True: [], False: []}
    for integral in expand_derivatives(form).integrals():
        parts[integral.integral_type() == "cell"].append(integral)
    plain, cells = (ufl.Form(parts[kind]) if parts[kind] else None for kind in (False, True))
    return plain, cells


def compile_columns(form: ufl.Form, V: FunctionSpace) -> Compiled:
    """Kernels of a bilinear form over cells as those of vectors, with a direction among the coefficients. Collective.

    Args:
        form: UFL form of rank 2.
        V: space of test and trial functions.

    Raises:
        ValueError: kernels do not support the form.
    """
    trial = max(form.arguments(), key=lambda a: a.number())
    return compile_form(ufl.replace(form, {trial: Function(V, name=DIRECTION)}))
