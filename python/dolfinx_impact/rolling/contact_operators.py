# SPDX-License-Identifier: MIT
"""Contacts of a rolling problem at one geometry: forces of nodal multipliers, and the nodes that may carry one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from .. import _cpp
from ..common.types import AnyArray, BoolArray, FloatArray, IntArray
from .contact import RollingContact
from .friction_law import tangents


class Candidates:
    """Slave nodes of all contacts and ranks for which contact is decided, in one order.

    Args:
        comm: communicator.
        chosen: masks of the nodes of each contact, (n).

    Attributes:
        local: numbers of the chosen nodes of each contact.
        count: of all ranks.
    """

    def __init__(self, comm: MPI.Intracomm, chosen: Sequence[BoolArray]) -> None:
        self._comm = comm
        self.local = [np.flatnonzero(mask) for mask in chosen]
        here = sum(len(nodes) for nodes in self.local)
        self._first = int(comm.exscan(here) or 0)
        self.count = int(comm.allreduce(here))

    def gather(self, values: Sequence[AnyArray]) -> Any:
        """Values of the candidates of all ranks, (count, ...), on rank 0; None on others. Collective.

        Args:
            values: of all nodes of each contact on this rank, (n, ...).
        """
        parts = self._comm.gather([v[nodes] for v, nodes in zip(values, self.local)])
        return None if parts is None else np.concatenate([part for own in parts for part in own])

    def scatter(self, values: Any, fill: Sequence[FloatArray]) -> list[FloatArray]:
        """Values of all nodes of each contact on this rank. Collective.

        Args:
            values: of the candidates on rank 0, (count, ...).
            fill: values of the other nodes, (n, ...) each; copied.
        """
        values, out, start = self._comm.bcast(values), [], self._first
        for old, nodes in zip(fill, self.local):
            new = old.copy()
            new[nodes] = values[start : start + len(nodes)]
            start += len(nodes)
            out.append(new)
        return out


class ContactOperators:
    """Maps between multipliers and the forces on the bodies. Multipliers are nodal forces, in the axes of the mesh.

    Args:
        K: tangent of the bodies [F/L].
        contacts: contacts, after update_matrices.

    Attributes:
        contacts: as given.
        frames: normal and tangents of each contact's nodes as rows, (n, gdim, gdim).
        held: mask of normals and tangents along which nothing can move, (n, gdim) each.
        forces: matrix from multipliers to nodal forces, (dofs, multipliers).
    """

    def __init__(self, K: PETSc.Mat, contacts: Sequence[RollingContact]) -> None:
        self.contacts = list(contacts)
        self._num = K.getLocalSize()[0]
        self.gdim = self.contacts[0].gdim
        self.frames = [self._frame(c) for c in self.contacts]
        self.held = [np.any((np.abs(f) > 0.9) & c.held[:, None, :], axis=2) for c, f in zip(self.contacts, self.frames)]
        self._starts = np.cumsum([0, *(self.gdim * len(c.nodes) for c in self.contacts)])
        self.forces = self._force_matrix(K.getComm().tompi4py())

    def _frame(self, c: RollingContact) -> FloatArray:
        normal = c.geometry.normal
        first = np.where(np.abs(c.slip_velocity) > 0.0, c.slip_velocity, c.main_direction())
        return np.concatenate([normal[:, None, :], tangents(normal, first, c.fixed)], axis=1)

    def _force_matrix(self, comm: MPI.Intracomm) -> PETSc.Mat:
        none = np.zeros(0, dtype=np.int64)
        rows, cols, values = [none], [none], [np.zeros(0)]
        first = int(comm.exscan(int(self._starts[-1])) or 0)
        for k, c in enumerate(self.contacts):
            assert c.jump is not None
            starts, at, value = c.jump.getValuesCSR()
            lengths = np.diff(starts)[c.nodes]
            node = np.repeat(np.arange(len(c.nodes)), lengths)
            entries = np.concatenate([none, *(np.arange(starts[i], starts[i + 1]) for i in c.nodes)]).astype(np.int64)
            carried = c.carriers & c.geometry.participates
            force = np.where(carried, 1.0 / np.where(carried, c.geometry.weight, 1.0), 0.0)[node] * value[entries]
            for a in range(self.gdim):
                rows.append(self.gdim * at[entries].astype(np.int64) + a)
                cols.append(first + self._starts[k] + self.gdim * node + a)
                values.append(force)
        return _cpp.multipliers.coo_matrix(
            comm, self._num, int(self._starts[-1]), np.concatenate(rows), np.concatenate(cols), np.concatenate(values)
        )

    def columns(self, candidates: Candidates) -> IntArray:
        """Global columns of the candidates in the matrix of forces, (count gdim), on all ranks. Collective."""
        comm = self.forces.getComm().tompi4py()
        first = self.forces.getOwnershipRangeColumn()[0]
        own = [
            (first + start + self.gdim * nodes[:, None] + np.arange(self.gdim)).ravel()
            for start, nodes in zip(self._starts, candidates.local)
        ]
        return np.concatenate(comm.allgather(np.concatenate(own))).astype(np.int64)

    def weights(self) -> list[FloatArray]:
        """Areas by which tractions become nodal forces, zero where no multiplier lives, (n) each [L^2]."""
        return [np.where(c.carriers, c.geometry.weight, 0.0) for c in self.contacts]

    def nodal_forces(self, multipliers: Sequence[FloatArray]) -> FloatArray:
        """Forces on both bodies, owned dofs [F]. Collective.

        Args:
            multipliers: nodal forces, (n, gdim) each [F].
        """
        x, y = self.forces.createVecRight(), self.forces.createVecLeft()
        x.array[:] = np.concatenate([m.ravel() for m in multipliers])
        self.forces.mult(x, y)
        out: FloatArray = y.array_r.copy()
        x.destroy()
        y.destroy()
        return out

    def jumps(self, values: FloatArray) -> list[FloatArray]:
        """Transpose of `nodal_forces`: the work of unit multipliers, (n, gdim) each. Collective.

        Args:
            values: over owned dofs.
        """
        x, y = self.forces.createVecRight(), self.forces.createVecLeft()
        y.array[:] = values
        self.forces.multTranspose(y, x)
        parts = [x.array_r[a:b].reshape(-1, self.gdim).copy() for a, b in zip(self._starts, self._starts[1:])]
        x.destroy()
        y.destroy()
        return parts

    def destroy(self) -> None:
        """Give back the memory. Collective."""
        self.forces.destroy()
