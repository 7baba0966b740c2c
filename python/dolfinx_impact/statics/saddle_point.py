# SPDX-License-Identifier: MIT
"""Multipliers kept as unknowns: the linear system of displacements and contact forces, a saddle point.

Its rows, products and matrix are C++: cpp/dolfinx_impact/enforcement/mortar/SaddlePoint.h.
"""

from typing import Any

from petsc4py import PETSc

from ..common.types import FloatArray
from .linear_solver import Stiffness


class SaddlePoint(Stiffness):
    """As linear_solver.LinearSystem, with the multipliers of all contacts behind each rank's displacements.

    Args:
        K: matrix of the displacements [F/L].
        extra: matrices of the same size, which are added to it [F/L].
        rows: constraints of the present linear problem, assigned: SaddlePoint (C++).

    Attributes:
        mask: pinned unknowns of this rank.
    """

    symmetric = False  # indefinite: nothing for conjugate gradients

    def __init__(self, K: PETSc.Mat, extra: list[PETSc.Mat], rows: Any) -> None:
        super().__init__(K, extra)
        self.rows, self.mask = rows, rows.pinned
        self.comm = K.getComm().tompi4py()
        self.num = K.getLocalSize()[0]

    @property
    def sizes(self) -> tuple[tuple[int, None], tuple[int, None]]:
        """Of the operator, as PETSc takes them."""
        return ((len(self.mask), None), (len(self.mask), None))

    def create(self) -> PETSc.Vec:
        """A vector of the unknowns."""
        return PETSc.Vec().createMPI((len(self.mask), None), comm=self.comm)

    def free(self) -> None:
        """Nothing: the C++ object keeps its memory for the next linear problem."""

    def mult(self, x: PETSc.Vec, y: PETSc.Vec) -> None:
        """y = A x. Collective.

        Args:
            x: unknowns.
            y: is overwritten.
        """
        self.rows.mult([self.K, *self.extra], x, y)

    def load(self, residual: FloatArray, values: PETSc.Vec, b: PETSc.Vec) -> None:
        """Right-hand side b. Collective.

        Args:
            residual: nodal, owned dofs, without contact forces [F].
            values: unknowns, whose pinned displacements count [L].
            b: is overwritten.
        """
        self.rows.load([self.K, *self.extra], residual, values, b)

    def unknowns(self, increments: FloatArray, forces: FloatArray) -> FloatArray:
        """A guess: unknowns that stand for increments and forces.

        Args:
            increments: of displacement, owned dofs [L].
            forces: of the multipliers, by node and direction, over the system's diagonal [L].

        Returns:
            unknowns of this rank.
        """
        return self.rows.unknowns(increments, forces)

    def displacements(self, y: PETSc.Vec) -> FloatArray:
        """Increments of displacement that unknowns stand for, owned dofs [L].

        Args:
            y: unknowns.
        """
        return y.array_r[: self.num].copy()

    def forces(self, y: PETSc.Vec) -> FloatArray:
        """Forces of the multipliers that unknowns stand for, by node and direction, over the system's diagonal [L].

        Args:
            y: unknowns.
        """
        return self.rows.forces(y)

    def assemble(self) -> PETSc.Mat:
        """A as a matrix of its own. Collective."""
        return self.rows.assemble([self.K, *self.extra])
