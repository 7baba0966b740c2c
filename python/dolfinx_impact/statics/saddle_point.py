# SPDX-License-Identifier: MIT
"""Multipliers kept as unknowns: the saddle point system of displacements and contact forces.

    [ K    -C_L^T ] [ du ]   [ -R + C_L^T f ]
    [ -C    0     ] [ df ] = [ -known       ]

Row (j, d) of C is the component q_jd . (u_j - sum_l P_jl u_l) of the jump at slave node j that contact constrains, f_jd
the force that does it, R the residual without contact; in C_L the normal force of a slipping node leans along its
friction. Rows of C are multiplied by an entry of K's size, so that residuals of both kinds are forces. Multipliers of
any basis will do; the matrix is indefinite and needs a direct solver.
"""

import numpy as np
from petsc4py import PETSc

from .linear_solver import Stiffness
from ..contact.matrices import owned_rows, rectangle


class SaddlePoint(Stiffness):
    """As linear.LinearSystem, with the multipliers of all contacts behind each rank's displacements.

    Args:
        K, extra, pinned, diagonal: as in LinearSystem. parts: list of Constraints; sizes: number of the
        contacts' nodes on this rank, one for each part. forces: f over the size of K's entry, all directions [L].

    Attributes:
        forces: f of the constrained directions, zero elsewhere.
    """

    symmetric = False  # indefinite: nothing for conjugate gradients

    def __init__(self, K, extra, pinned, diagonal, parts, sizes, forces):
        super().__init__(K, extra)
        self.diagonal = diagonal
        self.comm = K.getComm().tompi4py()
        self.num, gdim = len(pinned), parts[0].frames.shape[1]
        self.gdim = gdim
        starts = np.concatenate([[0], np.cumsum(sizes)])
        free, right, left = [], [], []
        first = K.getOwnershipRange()[0]
        num_rows = gdim * starts[-1]
        begin = self.comm.exscan(int(num_rows)) or 0
        for part, start, size in zip(parts, starts, sizes):
            open_rows = np.ones((size, gdim), dtype=bool)
            open_rows[part.rows] = ~part.constrained
            free.append(open_rows.ravel())
            rows = begin + gdim * (start + part.rows)[:, None] + np.arange(gdim)
            normals = part.normal[:, None] == np.arange(gdim)
            lean = np.where(normals[:, None, :], part.tilt[:, :, None], 0.0)
            right.append(self._entries(part, rows, part.frames, part.over, first))
            left.append(self._entries(part, rows, part.frames + lean, part.over + lean, first))
        self.mask = np.concatenate([pinned, *free])
        self.forces = np.where(np.concatenate(free), 0.0, forces)
        self.pinned = np.flatnonzero(self.mask)
        sizes = (num_rows, self.num)
        self.right, self.left = (
            rectangle(self.comm, *sizes, *(np.concatenate([p[i] for p in part]) for i in range(3)))
            for part in (right, left)
        )
        self._u = [K.createVecRight() for _ in range(3)]
        self._f = [self.right.createVecLeft() for _ in range(2)]
        self.known = np.concatenate([self._known(p, size) for p, size in zip(parts, np.diff(starts))])

    def _known(self, part, size):
        known = np.zeros((size, part.frames.shape[1]))
        known[part.rows] = np.where(part.constrained, part.known, 0.0)
        return self.diagonal * known.ravel()

    def _entries(self, part, rows, directions, over, first):
        """Entries (rows, cols, values) of the jump for every constrained row (j, d): slaves along directions[:, :, d],
        masters along over[:, :, d]."""
        gdim = self.gdim
        counts = np.diff(part.pointers)
        owner = np.concatenate([np.arange(len(part.nodes)), np.repeat(np.arange(len(part.nodes)), counts)])
        nodes = np.concatenate([first // gdim + part.nodes, part.columns])
        slaves = len(part.nodes)
        values = np.concatenate([directions, -part.values[:, None, None] * over[owner[slaves:]]])
        cols = np.broadcast_to((gdim * nodes[:, None] + np.arange(gdim))[:, :, None], values.shape)
        rows = np.broadcast_to(rows[owner][:, None, :], values.shape)
        on = np.broadcast_to(part.constrained[owner][:, None, :], values.shape)
        return rows[on], cols[on], self.diagonal * values[on]

    @property
    def sizes(self):
        """Of the operator, as PETSc takes them."""
        return ((len(self.mask), None), (len(self.mask), None))

    def create(self):
        """A vector of the unknowns."""
        return PETSc.Vec().createMPI((len(self.mask), None), comm=self.comm)

    def free(self):
        """Give back the memory of what was made here. Collective."""
        for thing in (*self._u, *self._f, self.right, self.left):
            thing.destroy()

    def _product(self, x, y):
        """y = A x without pins; arrays of this rank. Collective."""
        u, force, other = self._u
        f, jump = self._f
        u.array[:], f.array[:] = x[: self.num], x[self.num :]
        self.stiffness(u, force)
        self.left.multTranspose(f, other)
        self.right.mult(u, jump)
        y[: self.num] = force.array - other.array
        y[self.num :] = -jump.array

    def mult(self, x, y):
        """y = A x. Collective."""
        values = x.array_r.copy()
        values[self.pinned] = 0.0
        out = np.empty_like(values)
        self._product(values, out)
        out[self.pinned] = self.diagonal * x.array_r[self.pinned]
        y.array[:] = out

    def load(self, residual, values, b):
        """Right side b for a residual (array over owned dofs) and a vector of pinned values. Collective."""
        fixed = np.zeros(len(self.mask))
        fixed[self.pinned] = values.array_r[self.pinned]
        fixed[self.num :] = self.forces
        out = np.empty_like(fixed)
        self._product(fixed, out)
        fixed[self.num :] = 0.0
        out = np.concatenate([-residual, -self.known]) - out
        out[self.pinned] = self.diagonal * fixed[self.pinned]
        b.array[:] = out

    def displacements(self, y):
        """Increments of displacement, array over owned dofs."""
        return y.array_r[: self.num].copy()

    def assemble(self):
        """A as a matrix of its own. Collective."""
        ends = np.array(self.comm.allgather((self.num, len(self.mask) - self.num)))
        # Unknowns of a rank stand together: displacements move back by the multipliers of the ranks before.
        u_ends, f_ends = np.cumsum(ends[:, 0]), np.cumsum(ends[:, 1])
        f_starts, u_starts = np.concatenate([[0], f_ends[:-1]]), np.concatenate([[0], u_ends[:-1]])

        def place_u(dofs):
            return dofs + f_starts[np.searchsorted(u_ends, dofs, side="right")]

        def place_f(rows):
            return rows + u_ends[np.searchsorted(f_ends, rows, side="right")]

        me = self.comm.rank
        parts = []
        for A in (self.K, *self.extra):
            rows, cols, values = _triplets(A, u_starts[me])
            parts.append((place_u(rows), place_u(cols), values))
        for A, turned in ((self.right, False), (self.left, True)):
            rows, cols, values = _triplets(A, f_starts[me])
            pair = place_f(rows), place_u(cols)
            parts.append((*(pair[::-1] if turned else pair), -values))
        own = np.arange(len(self.mask)) + u_starts[me] + f_starts[me]
        parts.append((own, own, np.zeros(len(own))))  # a place on the diagonal for every row
        A = rectangle(
            self.comm, len(own), len(own), *(np.concatenate([np.asarray(p[i]) for p in parts]) for i in range(3))
        )
        A.zeroRowsColumns(own[self.pinned].astype(np.int32), self.diagonal)
        return A


def _triplets(A, start):
    pointers, cols, values = owned_rows(A)
    return start + np.repeat(np.arange(len(pointers) - 1), np.diff(pointers)), cols.astype(np.int64), values
