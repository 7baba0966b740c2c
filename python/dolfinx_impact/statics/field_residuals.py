# SPDX-License-Identifier: MIT
"""Residuals of a mixed space field by field: a volume that is left over vanishes beside forces in one norm of both."""

from __future__ import annotations

import numpy as np
from dolfinx.fem import FunctionSpace
from petsc4py import PETSc

from ..assembly.fields import field_dofs
from ..common.described import Described
from ..common.types import BoolArray, FloatArray, IntArray


class FieldResiduals(Described):
    """How large the equations of each field are, and whether they hold.

    The equation of a field is measured by its largest terms, |K| |u|: of a constraint, div u = p / bulk, the terms
    balance at the solution, and no force at a support tells their size.

    Args:
        V: mixed space of the unknowns.
        fixed: mask of prescribed degrees of freedom, owned and ghosts.
    """

    def __init__(self, V: FunctionSpace, fixed: BoolArray) -> None:
        self.comm = V.mesh.comm
        self._dofs = field_dofs(V)
        self._free = [d[~fixed[d]] for d in self._dofs]
        self.begin()

    def begin(self) -> None:
        """Begin an increment: nothing is known of it."""
        self._scales: FloatArray = np.zeros(len(self._dofs))
        self._noises: FloatArray = np.zeros(len(self._dofs))

    def measure(self, K: PETSc.Mat, moved: FloatArray, residual: FloatArray) -> None:
        """Take the size of the terms of a linearisation into account. Collective.

        Args:
            K: tangent.
            moved: unknowns, from where they are measured, over owned degrees of freedom.
            residual: residual with that of supports, over owned degrees of freedom.
        """
        first, columns, values = K.getValuesCSR()
        absolute = PETSc.Mat().createAIJ(K.getSizes(), csr=(first, columns, np.abs(values)), comm=K.comm)
        x, y = absolute.createVecs()
        x.array[:] = np.abs(moved)
        absolute.mult(x, y)
        terms = y.array.copy()
        for thing in (x, y, absolute):
            thing.destroy()
        size: FloatArray = self._norms(terms, self._free)
        self._noises = 4 * np.finfo(float).eps * size
        self._scales = np.maximum(self._scales, np.maximum(size, self._norms(residual, self._dofs)))

    def small(self, residual: FloatArray, rtol: float, atol: float) -> bool:
        """Whether the equations of every field hold. Collective.

        Args:
            residual: residual over owned degrees of freedom.
            rtol: tolerance, relative to the largest terms of a field's equation so far [1].
            atol: absolute tolerance of each field's equation.
        """
        tolerances = np.maximum(np.maximum(atol, self._noises), rtol * self._scales)
        return bool(np.all(self._norms(residual, self._free) <= tolerances))

    def _norms(self, values: FloatArray, dofs: list[IntArray]) -> FloatArray:
        return np.sqrt(self.comm.allreduce(np.array([values[d] @ values[d] for d in dofs])))
