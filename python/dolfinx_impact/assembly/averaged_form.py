# SPDX-License-Identifier: MIT
"""Bilinear forms with averages over a cell, which FFCx does not know: their matrices column by column.

The form a(du, v) is compiled as a vector, a(d, v), of a coefficient d in the place of the trial function. Its kernel
computes averages as those of values. Column j of a cell's matrix is this vector with the j-th degree of freedom of d
set (cpp/dolfinx_impact/operators/CellMatrix.h).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem import Function, FunctionSpace
from petsc4py import PETSc
from ufl.algorithms import expand_derivatives

from .. import _cpp
from ..common.described import Described
from ..forms.compiler import averages, geometry
from .jit import Compiled, compile_form

DIRECTION: str = _cpp.operators.direction_name


def has_averages(form: ufl.Form) -> bool:
    """Whether a form has averages or maxima over a cell, or volumes of cells that are not affine.

    Args:
        form: UFL form.
    """
    return any(averages.has_averages(i.integrand()) for i in geometry.with_sizes(form).integrals())


def split_averages(form: ufl.Form) -> tuple[ufl.Form | None, ufl.Form | None]:
    """Split a form into the integrals that kernels of matrices take, and those over cells if any of them has averages:
    together, as bounds of a sum are sharper than sums of bounds.

    Args:
        form: UFL form of rank 2.

    Returns:
        Both parts; None where one has no integrals.
    """
    if not has_averages(form):
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


class AveragedForm(Described):
    """A bilinear form over cells with averages, for DOLFINx's assembly.

    Args:
        form: UFL form of rank 2.
    """

    def __init__(self, form: ufl.Form) -> None:
        self.space: FunctionSpace = form.arguments()[0].ufl_function_space()
        self.compiled = compile_columns(form, self.space)
        data = next(iter(form.subdomain_data().values()))
        self._tags = next((t for t in data.get("cell", []) if t is not None), None)

    def forms(self) -> list[fem.Form]:
        """DOLFINx's forms of the integrals, with the present values of constants. Collective."""
        from .operators import _constants, entities_of  # operators uses this module

        V, out = self.space, []
        for kernel in self.compiled.kernels:
            functions = {c["name"]: self.compiled.coefficients[c["position"]] for c in kernel.coefficients}
            for f in functions.values():
                f.x.scatter_forward()
            coefficients = {name: f._cpp_object for name, f in functions.items()}
            constants = _constants(self.compiled, kernel)
            for subdomain in kernel.subdomains:
                cells = np.ascontiguousarray(entities_of(V.mesh._cpp_object, "cell", subdomain, self._tags))
                integral = _cpp.operators.Integral(kernel.address, cells, constants)
                spaces = [V._cpp_object, V._cpp_object]
                out.append(fem.Form(_cpp.operators.create_form(spaces, [integral], coefficients)))
        return out

    def add_to(self, matrix: PETSc.Mat, bcs: Any) -> None:
        """Assemble on top of a matrix that is assembled. Collective.

        Args:
            matrix: matrix with a place for each entry of the cells.
            bcs: Dirichlet conditions.
        """
        import dolfinx.fem.petsc as petsc

        for form in self.forms():
            petsc.assemble_matrix(matrix, form, bcs=bcs)  # type: ignore[misc, arg-type]
            matrix.assemble()
