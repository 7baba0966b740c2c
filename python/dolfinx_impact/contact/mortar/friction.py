# SPDX-License-Identifier: MIT
"""Coulomb's law at the nodes of a contact by multipliers, seed (3.40)-(3.44); docs/contact.md."""

import numpy as np

from ... import _cpp

# Springs that bring slips along prescribed components to zero, per stiffness of the bodies: what is left of a slip in
# one linear solution.
DRIVEN = 1e3
PART = 1e-3  # of a prescribed axis along the surface, least
KEPT = 1e-10  # of a traction: it has not changed


class Coulomb:
    """Trial tractions and what Newton's method sees of friction, for a class with a contact's nodal state: active,
    sliding, opening, direction, multiplier, friction_traction, traction_n (of the last converged state), imposed,
    nodal_stiffness, facing_stiffness, frames, place, free_length, usable, fixed, and the gaps and slips _gap, _slip and
    _at (the latter at the state that is linearised about).

    The tangent plane of a node has three kinds of directions. Along free ones the node's equilibrium tells the
    traction. Along prescribed ones there is no equation of the node: `imposed` is the traction of nodes that stick,
    raised from one linear solution to the next until nothing slips (driven directions), or kept from the last converged
    state where nothing can slip, because the relative motion is prescribed to be zero (locked directions).
    """

    def _split(self):
        """Projectors on the tangent plane's prescribed directions, of all nodes: locked and driven ones."""
        self._lock = np.zeros((len(self.nodes), self.gdim, self.gdim))
        self._drive = np.zeros_like(self._lock)
        rows = np.flatnonzero(self.usable & self.fixed.any(axis=1))
        normal, frames, fixed = self.geometry.normal[rows], self.frames[rows], self.fixed[rows]
        plane = np.eye(self.gdim) - np.einsum("na,nb->nab", normal, normal)
        own = ~fixed
        own[np.arange(len(rows)), self.place[rows]] = False
        free = np.einsum("nad,nbd->nab", frames * own[:, None, :], frames)
        locked = self.geometry.locked[rows]
        lock = np.zeros_like(plane)
        for c in range(self.gdim):
            axis = plane[:, :, c] - np.einsum("nab,nb->na", lock, plane[:, :, c])
            length = np.linalg.norm(axis, axis=1)
            axis = np.where((locked[:, c] & (length > PART))[:, None], axis / np.maximum(length, PART)[:, None], 0.0)
            lock += np.einsum("na,nb->nab", axis, axis)
        drive = plane - free - lock
        drive[np.einsum("naa->n", drive) < 0.5] = 0.0  # round-off: no direction is left
        self._lock[rows], self._drive[rows] = lock, drive
        self._driven = np.einsum("naa->n", self._drive) > 0.0
        # Tractions known from before follow the surface.
        turned = np.einsum("nab,nb->na", self._lock + self._drive, self.imposed)
        size, length = np.linalg.norm(self.imposed, axis=1), np.linalg.norm(turned, axis=1)
        self.imposed = turned * np.where(length > 0.0, size / np.maximum(length, 1e-300), 0.0)[:, None]

    def _stuck(self):
        """Nodes that stick where they are, mask (n)."""
        return self.active & self.usable & ~self.sliding & (self.opening == 0.0)

    def _impose(self, was_stuck):
        """Imposed tractions after changes of state and pressure: driven nodes that come to rest start from the traction
        they had, locked directions keep that of the last converged state as far as the bound leaves room.

        Returns:
            mask of the nodes whose kept traction is another one than in the last solution.
        """
        stuck = self._stuck()
        driven = np.where(was_stuck[:, None], self.imposed, self.friction_traction)
        driven = np.where(stuck[:, None], np.einsum("nab,nb->na", self._drive, driven), 0.0)
        kept = np.einsum("nab,nb->na", self._lock, self.traction_n)
        rest = self.friction_traction - np.einsum("nab,nb->na", self._lock, self.friction_traction)
        bound = self.pair.friction * np.maximum(self.multiplier, 0.0)
        room = np.sqrt(np.maximum(0.0, bound**2 - np.einsum("na,na->n", rest, rest)))
        size = np.linalg.norm(kept, axis=1)
        part = np.where(stuck & (size > 0.0), np.minimum(room, size) / np.where(size > 0.0, size, 1.0), 0.0)
        kept *= part[:, None]
        change = kept - np.einsum("nab,nb->na", self._lock, self.imposed)
        self.imposed = driven + kept
        return np.linalg.norm(change, axis=1) > KEPT * np.maximum(bound, size)

    def _drive_on(self):
        """After a linear solution: what still slips along driven directions raises the imposed traction."""
        held = (self._stuck() & self._driven)[:, None]
        self.imposed = self.imposed - np.where(held, np.einsum("nab,nb->na", self._driving, self._slip), 0.0)

    def _stiffness_per_area(self):
        return self.nodal_stiffness / np.where(self.usable, self.geometry.weight, 1.0)

    def _slipping(self, values):
        """Slips or tractions, (n, gdim), less their parts along locked directions."""
        return values if self.pair.friction == 0.0 else values - np.einsum("nab,nb->na", self._lock, values)

    def _tilt(self):
        """Friction traction per pressure, (n, gdim), of nodes that slip or have closed in this increment; else zero."""
        return _cpp.multipliers.friction_tilt(self._state(), self.gdim, self.pair.friction)

    def _lean(self, tilt):
        """Parts of a node's normal and friction traction, per pressure, along its constrained direction: (n).

        Friction along prescribed components of a surface that is inclined to them presses, or lifts, the node."""
        along = self.free_length + np.einsum("na,na->n", self._normal_direction(), tilt)
        return np.maximum(along, 1e-3)

    def _explicit(self):
        """Tractions that neither the node's equilibrium nor its pressure tells, after a linear solution: those of
        springs, and imposed ones; (n, gdim)."""
        if self._spring is None:
            return self.imposed
        return self.imposed - np.einsum("nab,nb->na", self._spring, self._slipping(self._slip) - self._rest)

    def _grips(self):
        """Nodes that have closed in this increment and do not slip, mask (n)."""
        return self.active & self.usable & ~self.sliding & (self.opening > 0.0) & (self.pair.friction > 0.0)

    def imposed_friction_forces(self):
        """Nodal forces on both bodies of the imposed tractions, array over owned dofs [F]; or None. Collective."""
        if self.pair.friction == 0.0 or not self.comm.allreduce(int(np.any(self.imposed))):
            return None
        return self.geometry.forces(self.imposed)

    def friction_springs(self):
        """Tractions that change with the slip: Newton's method sees springs. Collective.

        In 3D the traction of a node that slips turns with the slip: across its direction, friction bound over slip
        (return mapping t = bound trial / |trial|, linearised). Of a node that has closed in this increment, pressure
        over the gap it has closed. Along driven directions of a node that sticks, many times the bodies' stiffness.

        Returns:
            matrix, and force (array over owned dofs) to take from the right-hand side, of the springs and of imposed
            tractions; or None.
        """
        self._spring = np.zeros((len(self.nodes), self.gdim, self.gdim))  # stiffness per area
        self._driving = np.zeros_like(self._spring)
        self._rest = np.zeros((len(self.nodes), self.gdim))  # slip at which springs are slack
        if self.pair.friction == 0.0:
            return None
        grips, slides = self._grips(), self.sliding & self.active & self.usable & (self.gdim == 3)
        drives = self._stuck() & self._driven
        rows = np.flatnonzero(grips | slides | drives)
        if not self.comm.allreduce(len(rows) + int(np.any(self.imposed))):
            return None
        slip = self._slipping(self._slip)
        pressure = np.maximum(self.multiplier[rows], 0.0)
        normal = self.geometry.normal[rows]
        plane = np.eye(self.gdim) - np.einsum("na,nb->nab", normal, normal) - self._lock[rows]
        across = plane - np.einsum("na,nb->nab", self.direction[rows], self.direction[rows])
        bound, length = self.pair.friction * pressure, np.linalg.norm(slip[rows], axis=1)
        turning = np.minimum(bound / np.maximum(length, 1e-300), 1e3 * self._stiffness_per_area()[rows])
        gripping = pressure / np.where(grips[rows], self.opening[rows], 1.0)
        blocks = np.where(grips[rows, None, None], gripping[:, None, None] * plane, turning[:, None, None] * across)
        blocks[drives[rows]] = 0.0
        self._spring[rows] = blocks
        self._rest[grips] = slip[grips]
        stiffness = DRIVEN * np.maximum(self.nodal_stiffness, self.facing_stiffness)[rows] / self.geometry.weight[rows]
        self._driving[rows] = np.where(drives[rows], stiffness, 0.0)[:, None, None] * self._drive[rows]
        here = self._slipping(self._at[1])
        traction = np.einsum("nab,nb->na", self._spring, here - self._rest)
        traction += np.einsum("nab,nb->na", self._driving, here) - self.imposed
        # Forces go with the diagonal of D, slips are means over the cover.
        area = self.geometry.weight[rows] ** 2 / self.geometry.cover[rows]
        blocks = blocks + self._driving[rows]
        return self.geometry.springs(rows, area[:, None, None] * blocks), self.geometry.forces(traction)
