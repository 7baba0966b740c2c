# SPDX-License-Identifier: MIT
"""Displacements of the bodies under forces, and the compliance that candidate nodes of contacts see."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from dolfinx.fem import FunctionSpace
from petsc4py import PETSc

from .. import _cpp
from ..common.types import BoolArray, FloatArray
from ..statics.linear_solver import LinearSolver
from .contact_operators import Candidates, ContactOperators

BLOCK = 96  # right sides that are solved together
PATIENCE = 12  # iterations with factors of an earlier matrix before new ones are made
PREFIX = "impact_bodies_"
# K is symmetric; the directions of contact forces are found to round-off.
OPTIONS = {"pc_type": "cholesky", "mat_mumps_icntl_14": 50, "ksp_rtol": 1e-13, "ksp_max_it": 200}


@dataclass
class Compliance:
    """What unit forces at candidate nodes change, on rank 0, in the axes of the mesh.

    Attributes:
        jump: displacements of slave against master, (count, gdim, count, gdim) [L/F].
        velocity: velocities of slave against master, of the same shape [L/(T F)].
    """

    jump: FloatArray
    velocity: FloatArray


class BodyResponse:
    """Solutions of (K + E) u = f with prescribed values, by factors of K.

    The factors serve later matrices as a preconditioner. The matrix is symmetric but for E, what the turning of
    normals adds.

    Args:
        V: displacement space.
        fixed: mask of prescribed dofs, owned.
    """

    def __init__(self, V: FunctionSpace, fixed: BoolArray) -> None:
        self._fixed, self._pinned = np.flatnonzero(fixed), np.ascontiguousarray(fixed)
        limits = _cpp.solve.LinearSolverLimits()
        limits.patience = PATIENCE
        self._solver = LinearSolver(V, OPTIONS, PREFIX, limits=limits)
        self._system: _cpp.solve.PerturbedSystem | None = None

    def update(self, K: PETSc.Mat, extra: Sequence[PETSc.Mat | None]) -> None:
        """Take another matrix, which stays as it is until the next one. Collective.

        Args:
            K: tangent of the bodies, symmetric [F/L].
            extra: matrices that are added to it, or None.
        """
        self._system = _cpp.solve.PerturbedSystem(K, [E for E in extra if E is not None], self._pinned, 1.0)
        if self._solver.factors is None:
            self._solver.set_up(self._system)

    @property
    def num_factors(self) -> int:
        """How many times factors were made so far."""
        return self._solver.num_set_ups

    @property
    def null_pivots(self) -> int:
        """Motions of the bodies that nothing holds but contact."""
        return self._solver.null_pivots

    def solve(self, load: FloatArray, jump: FloatArray | None = None) -> tuple[FloatArray, str | None]:
        """Displacements under a load. Collective.

        Args:
            load: nodal forces, owned dofs [F].
            jump: values at the prescribed dofs, in their order; None: zero [L].

        Returns:
            Displacements, owned dofs [L]; what is wrong with them, or None.
        """
        assert self._system is not None
        b, x = self._system.create_vector(), self._system.create_vector()
        if jump is not None:
            x.array[self._fixed] = jump
        self._system.load(-load, x, b)
        fault = self._solver.solve(self._system, b, x)
        out: FloatArray = self._system.displacements(x)
        b.destroy()
        x.destroy()
        return out, fault

    def compliance(self, operators: ContactOperators, candidates: Candidates) -> Compliance | None:
        """Jumps and velocities that unit forces at the candidates cause, on rank 0; None on others. Collective.

        Without E: good enough for what leads to a solution, which is then checked by `solve`.

        Args:
            operators: of the contacts.
            candidates: nodes.
        """
        factors, comm = self._solver.factors, operators.forces.getComm().tompi4py()
        assert factors is not None
        starts, cols, values = operators.forces.getValuesCSR()
        num, total = len(self._pinned), operators.forces.getSize()[1]
        B = scipy.sparse.csr_matrix((values, cols, starts), shape=(num, total)).tocsc()
        wanted = operators.columns(candidates)
        n, gdim = candidates.count, operators.gdim
        # On rank 0. Bodies that are far apart have no candidates.
        jumps: list[FloatArray] = [np.zeros((n, gdim, 0))]
        velocities: list[FloatArray] = [np.zeros((n, gdim, 0))]
        for first in range(0, len(wanted), BLOCK):
            block = wanted[first : first + BLOCK]
            right = B[:, block].toarray()
            right[self._fixed] = 0.0
            load = PETSc.Mat().createDense(((num, None), (None, len(block))), comm=comm)
            load.setUp()
            load.getDenseArray()[:] = right
            load.assemble()
            moved = load.duplicate()
            factors.matSolve(load, moved)
            columns = np.array(moved.getDenseArray())
            load.destroy()
            moved.destroy()
            for found, name in ((jumps, "jump"), (velocities, "velocity_jump")):
                parts = [_relative(c, getattr(c, name), columns, operators.gdim) for c in operators.contacts]
                here = [part[nodes] for part, nodes in zip(parts, candidates.local)]
                gathered = comm.gather(np.concatenate(here))
                if gathered is not None:
                    found.append(np.concatenate(gathered))
        if comm.rank:
            return None
        shape = (n, gdim, n, gdim)
        return Compliance(*(np.concatenate(part, axis=2).reshape(shape) for part in (jumps, velocities)))

    def forget_factors(self) -> None:
        """Factors are made anew, when they are used next. Collective."""
        self._solver.reset()


def _relative(c: object, matrix: PETSc.Mat, columns: FloatArray, gdim: int) -> FloatArray:
    """A matrix of jumps times displacement fields, over the cover, (n, gdim, fields). Collective."""
    nodes, k = len(columns) // gdim, columns.shape[1]
    fields = PETSc.Mat().createDense(((nodes, None), (None, gdim * k)), comm=matrix.getComm())
    fields.setUp()
    fields.getDenseArray()[:] = columns.reshape(nodes, gdim * k)
    fields.assemble()
    out = matrix.matMult(fields)
    at = c.nodes  # type: ignore[attr-defined]
    values = np.array(out.getDenseArray())[at].reshape(len(at), gdim, k)
    fields.destroy()
    out.destroy()
    geometry = c.geometry  # type: ignore[attr-defined]
    cover = np.where(geometry.participates, geometry.cover, np.inf)
    return values / cover[:, None, None]
