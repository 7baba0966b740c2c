# SPDX-License-Identifier: MIT
"""Displacements of the bodies under forces, and the compliance that candidate nodes of contacts see."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from petsc4py import PETSc

from ..common.types import FloatArray, IntArray
from .contact_operators import Candidates, ContactOperators

BLOCK = 96  # right sides that are solved together
PATIENCE = 12  # iterations with factors of an earlier matrix before new ones are made


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
        fixed: prescribed dofs among the owned ones.

    Attributes:
        seconds: time spent.
    """

    def __init__(self, fixed: IntArray) -> None:
        self._fixed = fixed
        self._ksp: PETSc.KSP | None = None
        self._K: PETSc.Mat | None = None
        self._bare: PETSc.Mat | None = None
        self._extra: list[PETSc.Mat] = []
        self._factored: PETSc.Mat | None = None
        self._iterations = 0
        self.new_factors = False

    def update(self, K: PETSc.Mat, extra: Sequence[PETSc.Mat | None]) -> None:
        """Take another matrix. Collective.

        Args:
            K: tangent of the bodies, symmetric [F/L].
            extra: matrices that are added to it, or None.
        """
        self._bare, self._extra = K, [E for E in extra if E is not None]
        total = K.copy()
        for E in self._extra:
            total.axpy(1.0, E, PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
        self._hold(total)
        if self._K is not None:
            self._K.destroy()
        self._K = total
        if self._ksp is None or self._iterations > PATIENCE:
            self._factorise(K)
        assert self._ksp is not None and self._factored is not None
        self._ksp.setOperators(total, self._factored)

    def _hold(self, A: PETSc.Mat) -> None:
        A.zeroRowsColumns((A.getOwnershipRange()[0] + self._fixed).astype(PETSc.IntType), 1.0)

    def _factorise(self, K: PETSc.Mat) -> None:
        self.destroy_factors()
        A = K.copy()
        self._hold(A)
        A.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        ksp = PETSc.KSP().create(A.getComm())
        ksp.setType("gmres")
        ksp.setOperators(A, A)
        pc = ksp.getPC()
        pc.setType("cholesky")
        pc.setFactorSolverType("mumps")
        pc.setReusePreconditioner(True)
        pc.setFactorSetUpSolverType()
        factors = pc.getFactorMatrix()
        factors.setMumpsIcntl(24, 1)  # counts null pivots
        factors.setMumpsIcntl(14, 50)
        factors.setMumpsCntl(3, 1e-14)
        ksp.setTolerances(rtol=1e-13, max_it=200)
        pc.setUp()
        self._ksp, self._factored, self._iterations, self.new_factors = ksp, A, 0, True

    @property
    def null_pivots(self) -> int:
        """Motions of the bodies that nothing holds but contact."""
        assert self._ksp is not None
        return int(self._ksp.getPC().getFactorMatrix().getMumpsInfog(28))

    def solve(self, load: FloatArray, jump: FloatArray | None = None) -> tuple[FloatArray, str | None]:
        """Displacements under a load. Collective.

        Args:
            load: nodal forces, owned dofs [F].
            jump: values at the prescribed dofs, in their order; None: zero [L].

        Returns:
            Displacements, owned dofs [L]; what is wrong with them, or None.
        """
        assert self._ksp is not None and self._bare is not None
        b, x = self._bare.createVecRight(), self._bare.createVecRight()
        b.array[:] = load
        if jump is not None:
            x.array[self._fixed] = jump
            for matrix in (self._bare, *self._extra):
                y = matrix.createVecLeft()
                matrix.mult(x, y)
                b.axpy(-1.0, y)
                y.destroy()
            x.set(0.0)
        b.array[self._fixed] = 0.0 if jump is None else jump
        self._ksp.solve(b, x)
        self._iterations = max(self._iterations, self._ksp.getIterationNumber())
        reason, out = self._ksp.getConvergedReason(), x.array_r.copy()
        b.destroy()
        x.destroy()
        return out, None if reason > 0 else f"PETSc reason {reason}"

    def compliance(self, operators: ContactOperators, candidates: Candidates) -> Compliance | None:
        """Jumps and velocities that unit forces at the candidates cause, on rank 0; None on others. Collective.

        Without E: good enough for what leads to a solution, which is then checked by `solve`.

        Args:
            operators: of the contacts.
            candidates: nodes.
        """
        assert self._ksp is not None and self._bare is not None
        factors, comm = self._ksp.getPC().getFactorMatrix(), self._bare.getComm().tompi4py()
        starts, cols, values = operators.forces.getValuesCSR()
        num, total = self._bare.getLocalSize()[0], operators.forces.getSize()[1]
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

    def destroy_factors(self) -> None:
        """Give back the memory. Collective."""
        for thing in (self._ksp, self._factored):
            if thing is not None:
                thing.destroy()
        self._ksp = self._factored = None

    def destroy(self) -> None:
        """Give back the memory. Collective."""
        self.destroy_factors()
        if self._K is not None:
            self._K.destroy()
            self._K = None


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
