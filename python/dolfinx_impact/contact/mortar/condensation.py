# SPDX-License-Identifier: MIT
"""Multipliers condensed: unknowns and equations of slave nodes exchanged for those that contact leaves free.

At a slave node some directions q_d of an orthonormal frame are constrained,

    u_j . q_d = sum_l P_jl u_l . m_d + known.

m_d is q_d; only where a component of u_j is prescribed and the normal n has a part along it, for which q_d cannot
stand, m_d = n/L with L the length of n's free part.

With u = T y + known the constrained components leave the system, and with test functions of the same kind (of T_L
under slip) so do the multipliers: T_L^T K T has the size and, without friction, the symmetry of K. Wohlmuth and Krause
(2003), Popp et al. (2010).
"""

from dataclasses import dataclass

import numpy as np

from ..matrices import matrix


@dataclass
class Constraints:
    """Constrained slave nodes of one contact on this rank.

    Attributes:
        rows: (n) index of the nodes among the contact's. nodes: (n) owned nodes.
        frames: (n, gdim, gdim), columns are the directions. over: (n, gdim, gdim) the same directions as the master's
        displacements see them. constrained: (n, gdim) of these.
        known: (n, gdim) increments along constrained directions [L]. tilt: (n, gdim) what friction adds to the contact
        force where a node slips, per force along direction `normal`, else the zero vector.
        normal: (n) index of the normal direction.
        pointers, columns, values: rows of P = D^-1 M (global master nodes); empty rows for rigid masters.
    """

    rows: np.ndarray
    nodes: np.ndarray
    frames: np.ndarray
    over: np.ndarray
    constrained: np.ndarray
    known: np.ndarray
    tilt: np.ndarray
    normal: np.ndarray
    pointers: np.ndarray
    columns: np.ndarray
    values: np.ndarray


def frames_at(normals, fixed):
    """Orthonormal frames: prescribed axes keep their place, one direction is the normal freed of them.

    Args:
        normals: (n, gdim) unit vectors. fixed: (n, gdim) prescribed components.

    Returns:
        frames (n, gdim, gdim); place (n) of the normal direction, -1 where every direction it has is prescribed;
        length (n) of the normal's free part.
    """
    num, gdim = normals.shape
    frames = np.tile(np.eye(gdim), (num, 1, 1))
    free = np.where(fixed, 0.0, normals)
    length = np.linalg.norm(free, axis=1)
    place = np.full(num, -1)
    usable = length > 1e-3
    direction = np.where(usable[:, None], free / np.maximum(length, 1e-300)[:, None], 0.0)
    place[usable] = np.argmax(np.abs(direction[usable]), axis=1)
    rows = np.flatnonzero(usable)
    # Gram-Schmidt over the other free axes, normal first.
    frames[rows, :, place[rows]] = direction[rows]
    for d in range(gdim):
        todo = rows[(place[rows] != d) & ~fixed[rows, d]]
        vector = np.tile(np.eye(gdim)[d], (len(todo), 1))
        done = np.zeros((len(todo), gdim), dtype=bool)
        done[np.arange(len(todo)), place[todo]] = True
        done[:, :d] |= True
        done |= fixed[todo]
        done[:, d] = False
        for e in range(gdim):
            other = np.where(done[:, e, None], frames[todo, :, e], 0.0)
            vector = vector - np.sum(vector * other, axis=1)[:, None] * other
        frames[todo, :, d] = vector / np.linalg.norm(vector, axis=1)[:, None]
    return frames, place, length


class Transformation:
    """T, T_L and the known increments of all contacts of a problem.

    Args:
        comm: MPI communicator. num_owned: degrees of freedom of this rank. start: its first global one.
        gdim: components per node. parts: list of Constraints.
    """

    def __init__(self, comm, num_owned, start, gdim, parts):
        self.known = np.zeros(num_owned)
        self.dummies = np.zeros(num_owned, dtype=bool)
        self.symmetric = not comm.allreduce(int(any(np.any(p.tilt) for p in parts)))
        keep = np.ones(num_owned, dtype=bool)
        right, left = [], []
        self._frames = []
        for p in parts:
            if len(p.nodes) == 0:
                continue
            dofs = gdim * p.nodes[:, None] + np.arange(gdim)
            self._frames.append((dofs, p.frames))
            keep[dofs.ravel()] = False
            self.dummies[dofs[p.constrained]] = True
            known = np.einsum("nad,nd->na", p.frames, np.where(p.constrained, p.known, 0.0))
            self.known[dofs] = known
            rows = np.broadcast_to((start + dofs)[:, :, None], p.frames.shape)
            cols = np.broadcast_to((start + dofs)[:, None, :], p.frames.shape)
            own = p.frames * ~p.constrained[:, None, :]
            right.append((rows, cols, own))
            # Test functions of a slipping node: tangential ones lean on the normal one, t - (t . tilt) n.
            normals = p.frames[np.arange(len(p.nodes)), :, p.normal]
            lean = np.einsum("nad,na->nd", p.frames, p.tilt)
            left.append((rows, cols, own - normals[:, :, None] * (lean * ~p.constrained)[:, None, :]))
            counts = np.diff(p.pointers)
            owner = np.repeat(np.arange(len(p.nodes)), counts)
            held = np.where(p.constrained[:, None, :], p.frames, 0.0)
            projector = np.einsum("nad,nbd->nab", held, p.over)
            tilted = projector + normals[:, :, None] * p.tilt[:, None, :]
            shape = (len(owner), gdim, gdim)
            m_rows = np.broadcast_to((start + dofs)[owner][:, :, None], shape)
            m_cols = np.broadcast_to((gdim * p.columns[:, None] + np.arange(gdim))[:, None, :], shape)
            right.append((m_rows, m_cols, projector[owner] * p.values[:, None, None]))
            left.append((m_rows, m_cols, tilted[owner] * p.values[:, None, None]))
        identity = start + np.flatnonzero(keep)
        right.append((identity, identity, np.ones(len(identity))))
        left.append((identity, identity, np.ones(len(identity))))
        self.right = matrix(comm, num_owned, *_flat(right), gdim)
        self.left = self.right if self.symmetric else matrix(comm, num_owned, *_flat(left), gdim)

    def residual(self, values):
        """T_L^T times a nodal residual, zero where the equations are those of multipliers. Collective."""
        vector = self.right.createVecLeft()
        vector.array[:] = values
        product = self.left.createVecRight()
        self.left.multTranspose(vector, product)
        out = product.array.copy()
        out[self.dummies] = 0.0
        for v in (vector, product):
            v.destroy()
        return out

    def unknowns(self, increments):
        """Unknowns y that stand for displacement increments (arrays over owned dofs), as a first guess."""
        y = increments.copy()
        for dofs, frames in self._frames:
            y[dofs] = np.einsum("nad,na->nd", frames, increments[dofs])
        y[self.dummies] = 0.0
        return y

    def destroy(self):
        """Free the matrices. Collective."""
        self.right.destroy()
        if not self.symmetric:
            self.left.destroy()

    def increment(self, y):
        """Displacement increments T y + known, array over owned dofs. Collective."""
        product = self.right.createVecLeft()
        self.right.mult(y, product)
        out = product.array + self.known
        product.destroy()
        return out

    def condense(self, K):
        """T_L^T K T."""
        if self.symmetric:
            return K.ptap(self.right)
        product = K.matMult(self.right)
        condensed = self.left.transposeMatMult(product)
        product.destroy()
        return condensed


def _flat(parts):
    return tuple(np.concatenate([np.ravel(p[i]) for p in parts]) for i in range(3))
