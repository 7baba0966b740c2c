# SPDX-License-Identifier: MIT
"""Consistent mass: its matrix, and its cell matrices."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import ufl
from dolfinx.fem import FunctionSpace
from dolfinx.mesh import MeshTags
from petsc4py import PETSc

from ..common.types import FloatArray, IntArray
from ..forms import inertia
from . import operators
from .fields import Density, fields_of
from .jit import compile_form
from .packed_cells import packed_cells
from .lumped_mass import mass_measure

Densities = Sequence[tuple[int | None, Density]]  # by cell tag; None: all cells [M/L^3]


def diagonal_matrix(V: FunctionSpace, values: FloatArray) -> PETSc.Mat:
    """Matrix with entries on its diagonal only. Collective.

    Args:
        V: space of its rows and columns.
        values: the diagonal, over owned degrees of freedom.

    Returns:
        A new matrix.
    """
    matrix = PETSc.Mat().createAIJ([(len(values), None)] * 2, bsize=V.dofmap.index_map_bs, nnz=1, comm=V.mesh.comm)
    at = np.arange(len(values) + 1, dtype=np.int32)
    matrix.setValuesCSR(at, at[:-1] + np.int32(matrix.getOwnershipRange()[0]), values)
    matrix.assemble()
    return matrix


class ConsistentMass:
    """Consistent mass of bodies.

    Args:
        V: displacement space.
        densities: density by cell tag, or those of fields or components; the tag None stands for all cells
            [M/L^3].
        hypothesis: hypothesis of the materials.
        cell_tags: cell tags of the densities; None: one density.
    """

    def __init__(
        self, V: FunctionSpace, densities: Densities, hypothesis: str, cell_tags: MeshTags | None = None
    ) -> None:
        self.space, self.cell_tags = V, cell_tags
        v, trial = ufl.TestFunction(V), ufl.TrialFunction(V)
        self._forms: list[tuple[int | None, ufl.Form]] = []
        for tag, density in densities:
            if not isinstance(density, tuple):
                dx = mass_measure(V, hypothesis, cell_tags)
                form = inertia.mass(trial, v, density, hypothesis, dx if tag is None else dx(tag))
                self._forms.append((tag, form))
                continue
            for field, d, t, w in zip(fields_of(V), density, ufl.split(trial), ufl.split(v)):
                if d is not None:
                    dx = mass_measure(V, hypothesis, cell_tags, field=field)
                    self._forms.append((tag, inertia.mass(t, w, d, hypothesis, dx if tag is None else dx(tag))))

    def assemble(self) -> PETSc.Mat:
        """Assemble the matrix. Collective.

        Returns:
            A new matrix [M].
        """
        if not self._forms:  # no field has inertia
            V = self.space
            return diagonal_matrix(V, np.zeros(V.dofmap.index_map.size_local * V.dofmap.index_map_bs))
        return operators.Tangent(sum(form for _, form in self._forms)).assemble()

    def of_cells(self, cells: IntArray) -> Iterator[tuple[int, FloatArray]]:
        """Mass matrices of some cells. Collective.

        Args:
            cells: owned cells, sorted.

        Yields:
            Cell, and its matrix over the cell's degrees of freedom, node by node [M].
        """
        mesh, V = self.space.mesh, self.space
        size = V.dofmap.dof_layout.num_dofs * V.dofmap.bs
        for tag, form in self._forms:
            compiled = compile_form(form)
            for f in compiled.coefficients:
                f.x.scatter_forward()
            (kernel,) = compiled.kernels
            constants = operators._constants(compiled, kernel)
            there = operators.entities_of(mesh._cpp_object, "cell", -1 if tag is None else tag, self.cell_tags)
            here = np.intersect1d(there, cells)
            functions = {c["name"]: compiled.coefficients[c["position"]] for c in kernel.coefficients}
            w, x = packed_cells(mesh, kernel, functions, here)
            matrices = np.zeros((len(here), size, size))
            kernel.tabulate_cells(matrices.ravel(), w.ravel(), constants, x.ravel(), len(here))
            yield from zip(map(int, here), matrices)
