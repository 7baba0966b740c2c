# SPDX-License-Identifier: MIT
"""Linear system of steady rolling with friction: displacements, and multipliers behind each rank's displacements."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from petsc4py import PETSc

from .. import _cpp
from ..common.types import FloatArray, IntArray
from ..statics.linear_solver import LinearSolver, Stiffness
from .contact import RollingContact
from .friction_law import Linearised, tangents

SMALL = 1e-10  # of the stiffness: an equation whose free displacements all have smaller coefficients has none


class SteadySystem(Stiffness):
    """[K, -B; N_u, N_l] [du; l] = [-r; f], where l are multipliers as forces over the unit of stiffness.

    Rows of N are gdim per slave node: contact, and friction along the tangents.

    Args:
        K: tangent of the bodies, with W [F/L].
        extra: geometric stiffness of the contacts, None where there is none [F/L].
        contacts: contacts at the state that is linearised about.
        fixed: prescribed dofs among the owned ones.
        rate: function of a contact, its scale of slip velocities per displacement [1/T].

    Attributes:
        mask: state of the unknowns, an integer each; factors of another system serve better the fewer differ.
    """

    symmetric = False

    def __init__(
        self,
        K: PETSc.Mat,
        extra: Sequence[PETSc.Mat | None],
        contacts: Sequence[RollingContact],
        fixed: IntArray,
        rate: Callable[[RollingContact], float],
    ) -> None:
        super().__init__(K, [E for E in extra if E is not None])
        self.contacts, self.fixed, self._rate = list(contacts), fixed, rate
        self.comm, self.num = K.getComm().tompi4py(), K.getLocalSize()[0]
        self.gdim = self.contacts[0].gdim
        diagonal = K.getDiagonal()
        self.unit = float(np.abs(self.comm.allreduce(float(np.abs(diagonal.array).sum())) / diagonal.getSize()))
        diagonal.destroy()
        self._counts = [len(c.nodes) for c in self.contacts]
        self._size = self.gdim * sum(self._counts)
        self._column = int(self.comm.exscan(self._size) or 0)
        self._first_dof = K.getOwnershipRange()[0]
        self._x, self._y = K.createVecRight(), K.createVecRight()
        self._entries = [self._jump_entries(c) for c in self.contacts]
        self._frames = [self._frame(c) for c in self.contacts]
        self._B = self._forces()
        self._N: PETSc.Mat | None = None
        self._diagonal: FloatArray = np.zeros((sum(self._counts), self.gdim, self.gdim))
        self._right: FloatArray = np.zeros(self._size)
        self._on_velocity: list[FloatArray] = []
        self.mask: IntArray = np.zeros(self.num + self._size, dtype=np.int64)
        self._locked = self._find_locked()

    # --- parts that stay while the status changes -------------------------------------------------------------------

    def _jump_entries(self, c: RollingContact) -> list[tuple[IntArray, IntArray, FloatArray]]:
        """Rows of the nodes in the matrices of jumps over the cover: (index of the node, node, value), twice."""
        out = []
        cover = np.where(c.geometry.participates, c.geometry.cover, np.inf)
        for matrix in (c.jump, c.velocity_jump):
            assert matrix is not None
            starts, cols, values = matrix.getValuesCSR()
            lengths = np.diff(starts)[c.nodes]
            rows = np.repeat(np.arange(len(c.nodes)), lengths)
            at = np.concatenate([np.zeros(0, dtype=np.int64), *(np.arange(starts[k], starts[k + 1]) for k in c.nodes)])
            at = at.astype(np.int64)
            out.append((rows, cols[at].astype(np.int64), values[at] / cover[rows]))
        return out

    def _frame(self, c: RollingContact) -> FloatArray:
        """Normal and tangents of each node, (n, gdim, gdim)."""
        normal = c.geometry.normal
        first = np.where(np.abs(c.slip_velocity) > 0.0, c.slip_velocity, c.main_direction())
        return np.concatenate([normal[:, None, :], tangents(normal, first, c.fixed)], axis=1)

    def _row_numbers(self, which: int) -> IntArray:
        """First row of each node of a contact among this rank's multipliers."""
        return self.gdim * (sum(self._counts[:which]) + np.arange(self._counts[which]))

    def _forces(self) -> PETSc.Mat:
        """B: nodal forces of the multipliers, (dofs, multipliers)."""
        rows, cols, values = [], [], []
        for k, c in enumerate(self.contacts):
            node, at, value = self._entries[k][0]
            weight = np.where(c.carriers, c.geometry.weight, np.inf)
            cover = np.where(c.geometry.participates, c.geometry.cover, 0.0)
            force = self.unit * value * cover[node] / weight[node]
            for a in range(self.gdim):
                rows.append(self.gdim * at + a)
                cols.append(self._column + self._row_numbers(k)[node] + a)
                values.append(force)
        return self._matrix((self.num, self._size), rows, cols, values)

    def _matrix(self, sizes: tuple[int, int], rows: list[Any], cols: list[Any], values: list[Any]) -> PETSc.Mat:
        none = np.zeros(0, dtype=np.int64)
        return _cpp.multipliers.coo_matrix(
            self.comm, *sizes, np.concatenate([none, *rows]), np.concatenate([none, *cols]),
            np.concatenate([none.astype(float), *values]),
        )  # fmt: skip

    def _rows(self, on_jump: Sequence[FloatArray], on_velocity: Sequence[FloatArray], size: bool = False) -> PETSc.Mat:
        """N_u from coefficients, (n, gdim, gdim) each, of displacement jumps and of velocity jumps."""
        rows, cols, values = [], [], []
        for k in range(len(self.contacts)):
            for (node, at, value), factor in zip(self._entries[k], (on_jump[k], on_velocity[k])):
                start = self._row_numbers(k)
                for r in range(self.gdim):
                    for a in range(self.gdim):
                        found = factor[node, r, a] * value
                        used = found != 0.0
                        rows.append(self._column + start[node][used] + r)
                        cols.append(self.gdim * at[used] + a)
                        values.append(np.abs(found[used]) if size else found[used])
        return self._matrix((self._size, self.num), rows, cols, values)

    def _find_locked(self) -> list[Any]:
        """Directions (n, gdim) along which both bodies are prescribed: no equation can be made of them. Collective."""
        jumps, velocities = [], []
        for c, frame in zip(self.contacts, self._frames):
            jumps.append(np.zeros_like(frame))
            velocities.append(frame / self._rate(c))
            jumps[-1][:, 0] = frame[:, 0]
            velocities[-1][:, 0] = 0.0
        N = self._rows(jumps, velocities, size=True)
        self._x.set(1.0)
        self._x.array[self.fixed] = 0.0
        y = N.createVecLeft()
        N.mult(self._x, y)
        small = y.array_r < SMALL
        y.destroy()
        N.destroy()
        ends = np.cumsum(self._counts) * self.gdim
        return [part.reshape(-1, self.gdim) for part in np.split(small, ends[:-1])]

    # --- equations of the present status ----------------------------------------------------------------------------

    def assign(
        self, laws: Sequence[Linearised], slips: Sequence[FloatArray], vectors: Sequence[FloatArray]
    ) -> None:
        """Equations of the nodes. Collective.

        Args:
            laws: of the contacts, linearised where the last solution is.
            slips: slip velocities there, (n, gdim) [L/T].
            vectors: multipliers there, (n, gdim) [F/L^2].
        """
        jumps, velocities, diagonals, rights, status = [], [], [], [], []
        for c, law, frame, locked, slip, vector in zip(
            self.contacts, laws, self._frames, self._locked, slips, vectors
        ):
            on_jump, on_velocity, own = np.zeros_like(frame), np.zeros_like(frame), frame.copy()
            right = np.zeros(frame.shape[:2])
            rate = self._rate(c)
            closed = law.active & ~locked[:, 0]
            on_jump[closed, 0], own[closed, 0], right[closed, 0] = frame[closed, 0], 0.0, -c.geometry.gap[closed]
            for a in range(1, self.gdim):
                t = frame[:, a]
                stick = law.active & ~law.sliding & ~locked[:, a] & (c.friction > 0.0)
                on_velocity[stick, a], own[stick, a] = t[stick] / rate, 0.0
                right[stick, a] = -np.einsum("na,na->n", t, c.slip_velocity)[stick] / rate
                slide = law.sliding & ~locked[:, a] & (c.friction > 0.0)
                along = np.einsum("na,na->n", t, law.direction)
                across = law.kappa[:, None] * (t - along[:, None] * law.direction)
                weight = np.where(c.carriers, c.geometry.weight, 0.0)
                scale = law.tangential_stiffness * weight / self.unit
                own[slide, a] = (t - across - c.friction * along[:, None] * frame[:, 0])[slide]
                on_velocity[slide, a] = (scale[:, None] * across)[slide]
                known = scale[:, None] * (slip - c.slip_velocity) - self._scaled(c, vector)
                right[slide, a] = np.einsum("na,na->n", across, known)[slide]
            jumps.append(on_jump)
            velocities.append(on_velocity)
            diagonals.append(own)
            rights.append(right.ravel())
            kinds = law.active.astype(np.int64) + law.sliding
            status.append(np.repeat(kinds, self.gdim))
        if self._N is not None:
            self._N.destroy()
        self._N = self._rows([self.unit * f for f in jumps], [self.unit * f for f in velocities])
        self._diagonal = self.unit * np.concatenate(diagonals)
        self._right = self.unit * np.concatenate(rights)
        self._on_velocity = velocities
        self.mask = np.concatenate([np.zeros(self.num, dtype=np.int64), *status])
        self.mask[self.fixed] = 3

    def _scaled(self, c: RollingContact, vectors: FloatArray) -> FloatArray:
        """Multipliers as unknowns of the system, (n, gdim)."""
        return np.where(c.carriers, c.geometry.weight, 0.0)[:, None] * vectors / self.unit

    def right_of_velocities(self, slips: Sequence[FloatArray]) -> FloatArray:
        """Right sides that slip velocities besides those of the displacements cause, after `assign`.

        Args:
            slips: velocities, (n, gdim) each [L/T].
        """
        rows = [-np.einsum("nra,na->nr", f, s).ravel() for f, s in zip(self._on_velocity, slips)]
        return self.unit * np.concatenate(rows)

    def contact_forces(self, x: PETSc.Vec) -> FloatArray:
        """Forces of the multipliers among the unknowns on both bodies, owned dofs [F]. Collective.

        Args:
            x: unknowns.
        """
        right = self._B.createVecRight()
        right.array[:] = x.array_r[self.num :]
        self._B.mult(right, self._y)
        right.destroy()
        return self._y.array_r.copy()

    # --- what a LinearSolver asks of a system -----------------------------------------------------------------------

    @property
    def sizes(self) -> tuple[tuple[int, None], tuple[int, None]]:
        """Of the operator, as PETSc takes them."""
        return ((self.num + self._size, None), (self.num + self._size, None))

    def create(self) -> PETSc.Vec:
        """A vector of the unknowns."""
        return PETSc.Vec().createMPI((self.num + self._size, None), comm=self.comm)

    def mult(self, x: PETSc.Vec, y: PETSc.Vec) -> None:
        """y = A x. Collective.

        Args:
            x: unknowns.
            y: is overwritten.
        """
        free = x.array_r[: self.num].copy()
        free[self.fixed] = 0.0
        out = self._product(free, x.array_r[self.num :])
        out[self.fixed] = self.unit * x.array_r[self.fixed]
        y.array[:] = out

    def _product(self, moved: FloatArray, multipliers: FloatArray) -> FloatArray:
        """A times displacements and multipliers, rows of supports as any other."""
        assert self._N is not None
        self._x.array[:] = moved
        self.stiffness(self._x, self._y)
        forces = self._y.array_r.copy()
        left, right = self._N.createVecLeft(), self._B.createVecRight()
        right.array[:] = multipliers
        self._N.mult(self._x, left)
        self._B.mult(right, self._y)
        forces -= self._y.array_r
        own = np.einsum("nra,na->nr", self._diagonal, multipliers.reshape(-1, self.gdim)).ravel()
        rows = left.array_r + own
        left.destroy()
        right.destroy()
        return np.concatenate([forces, rows])

    def load(self, residual: FloatArray, jump: FloatArray, right: FloatArray | None = None) -> PETSc.Vec:
        """Right-hand side, a vector that the caller destroys. Collective.

        Args:
            residual: nodal, owned dofs, without contact forces [F].
            jump: increments of prescribed displacements, over `fixed` [L].
            right: right sides of the equations of contact and friction; None: those of the last `assign`.
        """
        moved = np.zeros(self.num)
        moved[self.fixed] = jump
        known = self._product(moved, np.zeros(self._size))
        b = self.create()
        b.array[:] = np.concatenate([-residual, self._right if right is None else right]) - known
        b.array[self.fixed] = self.unit * jump
        return b

    def solve(self, solver: LinearSolver, b: PETSc.Vec, x: PETSc.Vec) -> str | None:
        """Solve. Collective.

        Args:
            solver: linear solver of the problem.
            b: right-hand side.
            x: a guess, becomes the solution.

        Returns:
            What is wrong with the solution, or None.
        """
        return solver.solve(self, b, x, 1e-12)

    def guess(self, moved: FloatArray, vectors: Sequence[FloatArray]) -> PETSc.Vec:
        """Unknowns that stand for displacements and multipliers, a vector that the caller destroys."""
        x = self.create()
        scaled = [self._scaled(c, v).ravel() for c, v in zip(self.contacts, vectors)]
        x.array[:] = np.concatenate([moved, *scaled])
        return x

    def displacements(self, x: PETSc.Vec) -> FloatArray:
        """Increments of displacement, owned dofs [L]."""
        return x.array_r[: self.num].copy()

    def vectors(self, x: PETSc.Vec) -> list[FloatArray]:
        """Multipliers of the contacts, (n, gdim) each [F/L^2]."""
        parts = np.split(x.array_r[self.num :], np.cumsum(self._counts)[:-1] * self.gdim)
        weights = [np.where(c.carriers, c.geometry.weight, np.inf)[:, None] for c in self.contacts]
        return [self.unit * p.reshape(-1, self.gdim) / w for p, w in zip(parts, weights)]

    def assemble(self) -> PETSc.Mat:
        """A as a matrix of its own. Collective."""
        assert self._N is not None
        total = self.K.copy()
        for E in self.extra:
            total.axpy(1.0, E, PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
        B = self._B.copy()
        B.scale(-1.0)
        n = len(self._diagonal)
        at = (self._column + self.gdim * np.arange(n))[:, None, None]
        ones = np.zeros((1, self.gdim, self.gdim), dtype=np.int64)
        rows = (at + np.arange(self.gdim)[None, :, None] + ones).ravel()
        cols = (at + np.arange(self.gdim)[None, None, :] + ones).ravel()
        own = self._matrix((self._size, self._size), [rows], [cols], [self._diagonal.ravel()])
        nest = PETSc.Mat().createNest([[total, B], [self._N, own]], comm=self.K.getComm())
        A = nest.convert("aij", PETSc.Mat())
        for thing in (nest, total, B, own):
            thing.destroy()
        A.zeroRowsColumns((A.getOwnershipRange()[0] + self.fixed).astype(PETSc.IntType), self.unit)
        return A

    def destroy(self) -> None:
        """Give back the memory of what was made here. Collective."""
        for thing in (self._x, self._y, self._B, *([self._N] if self._N is not None else [])):
            thing.destroy()
