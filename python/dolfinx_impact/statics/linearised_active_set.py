# SPDX-License-Identifier: MIT
"""Updates of an active set on a small dense problem, from responses of the bodies to unit changes at single nodes.

If the factors for one active set are known, the solution for another set is the sum of the solution for the first set,
the responses to normal forces at the nodes that have closed, and the responses to gaps at the nodes that have opened.
All responses are columns of one linear solution with several right-hand sides. The active set is then updated without
further linear solutions.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from .. import _cpp
from ..common.types import BoolArray, FloatArray, IntArray

if TYPE_CHECKING:
    from ..contact.mortar.lagrange import LagrangeContact

LARGEST = 50_000_000  # largest number of entries of all columns
MAX_CHANGES = 60  # updates of the active set


class LinearisedSystem(NamedTuple):
    """A linear system that was solved.

    Attributes:
        system: the system (C++).
        transformation: condensation of the multipliers.
        pinned: mask of the pinned unknowns.
    """

    system: _cpp.solve.LinearSystem
    transformation: _cpp.multipliers.Condensation
    pinned: BoolArray


class LinearisedActiveSet:
    """Responses of a frictionless contact, linearised about the solution of a linear system. Collective.

    Args:
        contact: contact with linearised gap and multipliers of the solution.
        system: linear system of the solution.
        factors: factor matrix of the system.
        product: function that returns the forces [F] of displacement increments [L], over owned degrees of freedom.
    """

    def __init__(
        self,
        contact: LagrangeContact,
        system: LinearisedSystem,
        factors: PETSc.Mat,
        product: Callable[[FloatArray], FloatArray],
    ) -> None:
        self.contact, self.system, self.factors, self.product = contact, system, factors, product
        self.comm = contact.comm
        self.base = contact.active.copy()
        self.gap, self.multiplier = contact.linearised_gap.copy(), contact.multiplier.copy()
        self.columns: list[int] = []  # global numbers of the nodes
        self.increments: FloatArray = np.empty((contact.gdim * contact.geometry.index_map.size_local, 0))
        self.gaps: FloatArray = np.empty((len(contact.nodes), 0))
        self.multipliers: FloatArray = np.empty((len(contact.nodes), 0))

    def update(self) -> tuple[FloatArray, int] | None:
        """Update the contact's active set until no node is wrong. Collective.

        Returns:
            Displacement increments that are added to the solution, over owned degrees of freedom [L], and number of
            changes [1]. None if the updates do not end or there are too many columns; the contact is then unchanged.
        """
        contact = self.contact
        z: FloatArray = np.zeros(0)
        changes = 0
        for _ in range(MAX_CHANGES):
            found = contact.update_active_set(False)
            if found == 0:
                return self.increments @ z, changes
            changes += found
            numbers = contact.geometry.numbers
            differ = contact.active != self.base
            wanted = np.unique(np.concatenate(self.comm.allgather(numbers[differ])))
            new = np.setdiff1d(wanted, self.columns)
            size = contact.geometry.index_map.size_global * contact.gdim * (len(self.columns) + len(new))
            if size > LARGEST:
                break
            if len(new):
                self._add(new)
            try:
                z = self._solve(wanted)
            except np.linalg.LinAlgError:  # a set that does not hold the bodies: the same on all ranks
                break
            contact.linearised_gap = self.gap + self.gaps @ z
            pressed: FloatArray = np.where(self.base, self.multiplier + self.multipliers @ z, self._at(z))
            contact.multiplier = np.where(contact.active, pressed, 0.0)
        contact.active = self.base.copy()
        contact.linearised_gap, contact.multiplier = self.gap, self.multiplier
        return None

    def _at(self, z: FloatArray) -> FloatArray:
        """Values `z` of the columns at this rank's nodes, zero at nodes without a column."""
        order = np.argsort(self.columns)
        numbers = self.contact.geometry.numbers
        place = np.searchsorted(np.asarray(self.columns)[order], numbers)
        place = order[np.minimum(place, len(order) - 1)]
        return np.where(np.asarray(self.columns)[place] == numbers, z[place], 0.0)

    def _solve(self, wanted: IntArray) -> FloatArray:
        """Solve for the forces of closed and gaps of opened nodes. Collective.

        Args:
            wanted: global numbers of the nodes whose state differs from that of the system.

        Returns:
            One value per column, zero for the other nodes.
        """
        numbers = self.contact.geometry.numbers
        rows = [self.columns.index(n) for n in wanted]
        A: FloatArray = np.zeros((len(wanted), len(wanted)))
        b: FloatArray = np.zeros(len(wanted))
        mine = np.flatnonzero(np.isin(numbers, wanted))
        at = np.searchsorted(wanted, numbers[mine])
        opened = self.base[mine]
        A[at] = np.where(opened[:, None], self.multipliers[mine], self.gaps[mine])[:, rows]
        b[at] = -np.where(opened, self.multiplier[mine], self.gap[mine])
        A, b = self.comm.allreduce(A, MPI.SUM), self.comm.allreduce(b, MPI.SUM)
        z = np.zeros(len(self.columns))
        z[rows] = np.linalg.solve(A, b)
        return z

    def _add(self, new: IntArray) -> None:
        """Add the columns of nodes, given by their global numbers. Collective."""
        contact, system = self.contact, self.system
        geometry, transformation = contact.geometry, system.transformation
        known = transformation.known.copy()
        rows = len(self.increments)
        right = PETSc.Mat().createDense(((rows, None), (None, len(new))), comm=self.comm)
        right.setUp()
        answer = right.duplicate()
        x, b = system.system.create_vector(), system.system.create_vector()
        x.set(0.0)
        columns = right.getDenseLocalMatrix().getDenseArray()
        opened = self.comm.allreduce(np.isin(new, geometry.numbers[self.base]).astype(int), MPI.SUM)
        for k, number in enumerate(new):
            here = geometry.numbers == number
            if opened[k]:
                transformation.known[:] = contact.unit_gap(int(number))
                system.system.load(np.zeros(rows), x, b)
                columns[:, k] = b.array_r
            else:
                force = geometry.forces(np.where(here[:, None], geometry.normal, 0.0))
                columns[:, k] = transformation.residual(force)
                columns[system.pinned, k] = 0.0
        right.assemble()
        self.factors.matSolve(right, answer)
        values = answer.getDenseLocalMatrix().getDenseArray()
        increments = np.empty((rows, len(new)))
        gaps, multipliers = (np.empty((len(contact.nodes), len(new))) for _ in range(2))
        for k in range(len(new)):
            transformation.known[:] = contact.unit_gap(new[k]) if opened[k] else 0.0
            x.array[:] = values[:, k]
            increments[:, k] = system.system.displacements(x)
            gaps[:, k], multipliers[:, k] = contact.linearised_response(
                increments[:, k], self.product(increments[:, k])
            )
        transformation.known[:] = known
        for thing in (right, answer, x, b):
            thing.destroy()
        self.columns += [int(n) for n in new]
        self.increments = np.hstack([self.increments, increments])
        self.gaps, self.multipliers = np.hstack([self.gaps, gaps]), np.hstack([self.multipliers, multipliers])
