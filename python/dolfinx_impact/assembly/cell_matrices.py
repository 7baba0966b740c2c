# SPDX-License-Identifier: MIT
"""Matrices of a bilinear form cell by cell, and what can be told from them."""

from collections.abc import Collection, Iterator
from typing import Any

import numpy as np
import ufl
from dolfinx import fem

from .. import _cpp
from ..common.types import BoolArray, FloatArray, IntArray
from . import operators
from ..forms.consistent_tangent import DIRECTION
from .averaged_form import compile_columns, split_averages
from .jit import compile_form
from .packed_cells import packed_cells


def _with_functions(form: ufl.Form) -> set[tuple[str, int]]:
    """Kinds and tags of integrals that depend on functions; -1 stands for integrals over all entities."""
    found = set()
    for integral in form.integrals():
        if ufl.algorithms.extract_coefficients(integral.integrand()):
            tags = integral.subdomain_id()
            for tag in tags if isinstance(tags, tuple) else (tags,):
                found.add((integral.integral_type(), tag if isinstance(tag, int) else -1))
    return found


class CellMatrices:
    """Cell matrices of a bilinear form; integrals over a cell's facets belong to the cell, those over a facet between
    two cells to both.

    Args:
        u: displacement function.
        form: UFL form of rank 2 over dx, ds and dS.
        without: functions whose changes are ignored by `changed`.

    Attributes:
        bounds: their eigenvalues over the cells' masses (C++); it has the constants of the last `update`.
    """

    def __init__(self, u: fem.Function, form: ufl.Form, without: Collection[fem.Function | None]) -> None:
        self.space = u.function_space
        plain, averaged = split_averages(form)
        self._compiled = [] if plain is None else [compile_form(plain)]
        if averaged is not None:
            self._compiled.append(compile_columns(averaged, self.space))
        data = next(iter(form.subdomain_data().values()))
        self._tags = {kind: next((t for t in tags if t is not None), None) for kind, tags in data.items()}
        constants = [c for compiled in self._compiled for c in compiled.constants]
        self._inputs = operators.Inputs(constants, [f for c in self._compiled for f in c.coefficients], without)
        varying = _with_functions(form)
        parts = []
        for kernel, functions, entities, constants in self._integrals():
            varies = any((kernel.integral_type, tag) in varying for tag in (-1, *kernel.subdomains))
            integral = _cpp.operators.Integral(kernel.address, entities, constants)
            parts.append((integral, {name: f._cpp_object for name, f in functions.items()}, varies))
        self.bounds = _cpp.operators.CellBounds(u.function_space._cpp_object, parts)

    def changed(self) -> bool:
        """Compare constants and coefficients with those of `store_inputs`.

        Returns:
            Whether any has changed on this rank.
        """
        return self._inputs.changed()

    def change(self) -> float:
        """Largest relative change of constants and coefficients on this rank since `store_inputs` [1]."""
        return self._inputs.change()

    def store_inputs(self) -> None:
        """Store the present constants and coefficients, which `changed` compares with. Collective."""
        self._inputs.store()
        self.update()

    def update(self) -> None:
        """Give `bounds` the present constants and the ghosts of coefficients. Collective."""
        number = 0
        for compiled in self._compiled:
            for f in compiled.coefficients:
                f.x.scatter_forward()
            operators.update_means(compiled.coefficients)
            for kernel in compiled.kernels:
                constants = operators._constants(compiled, kernel)
                for _ in kernel.subdomains:
                    self.bounds.set_constants(number, constants)
                    number += 1

    @property
    def joins_cells(self) -> bool:
        """Whether there are integrals over facets between cells."""
        return bool(self.bounds.joins_cells)

    def _integrals(self) -> Iterator[tuple[Any, dict[str, fem.Function], IntArray, FloatArray]]:
        """Kernel (C++), functions by name, entities and constants of each integral. Collective."""
        for compiled, kernel in [(c, k) for c in self._compiled for k in c.kernels]:
            for f in compiled.coefficients:
                f.x.scatter_forward()
            functions = {c["name"]: compiled.coefficients[c["position"]] for c in kernel.coefficients}
            constants, kind = operators._constants(compiled, kernel), kernel.integral_type
            for subdomain in kernel.subdomains:
                entities = operators.entities_of(self.space.mesh._cpp_object, kind, subdomain, self._tags.get(kind))
                yield kernel, functions, np.ascontiguousarray(entities), constants

    def spectra(self, masses: FloatArray, only: BoolArray | None = None, facets: bool = True) -> FloatArray:
        """Bounds of the eigenvalues of every owned cell's matrix over its mass. Collective.

        The sums over the cells of bound times mass are bounds of the assembled matrix: of a facet between two cells,
        the eigenvalues over the masses of both count for each of them.

        Args:
            masses: lumped masses, (num_cells, local degrees of freedom) [M].
            only: mask of the cells whose integrals count; None: all.
            facets: whether integrals over facets count.

        Returns:
            Lower bound, upper bound and norm of the skew-symmetric part, (num_cells, 3), in the form's unit over [M].

        Raises:
            ValueError: a matrix has entries that are not finite; on all ranks.
        """
        self.update()
        found: FloatArray = self.bounds.spectra(np.ascontiguousarray(masses).ravel(), only, facets)
        return found

    def resistance(self, direction: FloatArray, count: int) -> FloatArray:
        """Relative resistance of cells against a translation, zero for cells that are free to translate.

        Args:
            direction: translation, (gdim) [1].
            count: number of cells that are looked at, from the first [1].

        Returns:
            Largest entry of matrix times translation over the largest entry of the matrix, for cells with a matrix that
            is not zero [1].
        """
        mesh, bs = self.space.mesh, self.space.dofmap.bs
        parts: list[FloatArray] = []
        for kernel, functions, entities, constants in self._integrals():
            if kernel.integral_type != "cell":
                continue
            cells = entities[:count]
            w, x = packed_cells(mesh, kernel, functions, cells)
            n = kernel.shape[0]
            A = np.zeros((len(cells), n, n))
            if kernel.rank == 2:
                kernel.tabulate_cells(A.ravel(), w.ravel(), constants, x.ravel(), len(cells))
            else:
                first = next(c["offset"] for c in kernel.coefficients if c["name"] == DIRECTION)
                for k in range(n):  # a column of the matrices
                    column = np.zeros((len(cells), n))
                    w[:, first + k] = 1.0
                    kernel.tabulate_cells(column.ravel(), w.ravel(), constants, x.ravel(), len(cells))
                    w[:, first + k] = 0.0
                    A[:, :, k] = column
            size = np.abs(A).max(axis=(1, 2), initial=0.0)
            moved = np.abs(A @ np.tile(direction, n // bs)).max(axis=1, initial=0.0)
            parts.append(moved[size > 0.0] / size[size > 0.0])
        return np.concatenate([np.zeros(0), *parts])
