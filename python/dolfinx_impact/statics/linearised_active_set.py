# SPDX-License-Identifier: MIT
"""Active sets settled on a small dense problem: responses of the bodies to unit changes at single nodes.

With the factors of one active set at hand, the solution for another one is that of the first and, superposed, a normal
force at every node that has closed and a gap at every node that has opened. Their responses are columns of one linear
solution with many right-hand sides; which nodes close and open is then found without any more of these.
"""

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

LARGEST = 50_000_000  # entries of all columns together
MAX_CHANGES = 60


class LinearisedActiveSet:
    """Responses of a frictionless contact about a solution with the system's own active set. Collective.

    Args:
        contact: LagrangeContact after `predict` and `measure` of the solution. system: the solution's LinearSystem.
        factors: PETSc factor matrix of that. product: function (increments) -> forces, arrays over owned dofs.
    """

    def __init__(self, contact, system, factors, product):
        self.contact, self.system, self.factors, self.product = contact, system, factors, product
        self.comm = contact.comm
        self.base = contact.active.copy()
        self.gap, self.multiplier = contact._gap.copy(), contact.multiplier.copy()
        self.columns = []  # numbers of the nodes
        self.increments = np.empty((contact.gdim * contact.geometry.index_map.size_local, 0))
        self.gaps = np.empty((len(contact.nodes), 0))
        self.multipliers = np.empty((len(contact.nodes), 0))

    def update(self):
        """Change the contact's active set until no node is wrong.

        Returns:
            increments of displacement to add to the solution's (array over owned dofs), number of changes; or None
            where there is no end or there are too many columns: the contact is as before then.
        """
        contact = self.contact
        z, changes = np.zeros(0), 0
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
            contact._gap = self.gap + self.gaps @ z
            pressed = np.where(self.base, self.multiplier + self.multipliers @ z, self._at(z))
            contact.multiplier = np.where(contact.active, pressed, 0.0)
        contact.active = self.base.copy()
        contact._gap, contact.multiplier = self.gap, self.multiplier
        return None

    def _at(self, z):
        """Values of the columns at this rank's nodes."""
        order = np.argsort(self.columns)
        numbers = self.contact.geometry.numbers
        place = np.searchsorted(np.asarray(self.columns)[order], numbers)
        place = order[np.minimum(place, len(order) - 1)]
        return np.where(np.asarray(self.columns)[place] == numbers, z[place], 0.0)

    def _solve(self, wanted):
        """Forces of closed and gaps of opened nodes, one value per column, zero for nodes that are as in the base."""
        numbers = self.contact.geometry.numbers
        rows = [self.columns.index(n) for n in wanted]
        A, b = np.zeros((len(wanted), len(wanted))), np.zeros(len(wanted))
        mine = np.flatnonzero(np.isin(numbers, wanted))
        at = np.searchsorted(wanted, numbers[mine])
        opened = self.base[mine]
        A[at] = np.where(opened[:, None], self.multipliers[mine], self.gaps[mine])[:, rows]
        b[at] = -np.where(opened, self.multiplier[mine], self.gap[mine])
        A, b = self.comm.allreduce(A, MPI.SUM), self.comm.allreduce(b, MPI.SUM)
        z = np.zeros(len(self.columns))
        z[rows] = np.linalg.solve(A, b)
        return z

    def _add(self, new):
        """Columns of more nodes."""
        contact, system = self.contact, self.system
        geometry, transformation = contact.geometry, system.transformation
        known = transformation.known.copy()
        rows = len(self.increments)
        right = PETSc.Mat().createDense(((rows, None), (None, len(new))), comm=self.comm)
        right.setUp()
        answer = right.duplicate()
        x, b = system.create(), system.create()
        x.set(0.0)
        columns = right.getDenseLocalMatrix().getDenseArray()
        opened = self.comm.allreduce(np.isin(new, geometry.numbers[self.base]).astype(int), MPI.SUM)
        for k, number in enumerate(new):
            here = geometry.numbers == number
            if opened[k]:
                transformation.known[:] = contact.unit_gap(number)
                system.load(np.zeros(rows), x, b)
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
            increments[:, k] = system.displacements(x)
            gaps[:, k], multipliers[:, k] = contact.linearised_response(
                increments[:, k], self.product(increments[:, k])
            )
        transformation.known[:] = known
        for thing in (right, answer, x, b):
            thing.destroy()
        self.columns += [int(n) for n in new]
        self.increments = np.hstack([self.increments, increments])
        self.gaps, self.multipliers = np.hstack([self.gaps, gaps]), np.hstack([self.multipliers, multipliers])
