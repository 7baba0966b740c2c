"""Coulomb's law at the nodes of a contact by multipliers, seed (3.40)-(3.44); docs/contact.md."""

import numpy as np


class Coulomb:
    """Trial tractions and what Newton's method sees of friction, for a class with a contact's nodal state: active,
    sliding, opening, direction, multiplier, friction_traction, nodal_stiffness, frames, usable, fixed, and the gaps and
    slips _gap, _slip and _at (the latter at the state that is linearised about).
    """

    def _pressing(self, closing):
        """Pressure, (n) [F/L^2]; of a node that closes what its overlap would call for: it has no multiplier yet."""
        overlap = self._stiffness_per_area() * np.where(closing, np.minimum(self._gap, 0.0), 0.0)
        return np.maximum(self.multiplier - overlap, 0.0)

    def _stiffness_per_area(self):
        return self.nodal_stiffness / np.where(self.usable, self.geometry.weight, 1.0)

    def _free_slip(self, slip):
        return np.where(self.fixed, 0.0, slip)

    def _trial(self, bound, moving):
        """Traction that friction would have if it held the nodes, up to a factor beyond the bound, (n, gdim)."""
        slip = self._free_slip(self._slip)
        trial = self.friction_traction - self._stiffness_per_area()[:, None] * np.where(moving[:, None], slip, 0.0)
        # Closed in this increment, from a gap: t = -p s / gap, see docs/contact.md.
        fresh = self.opening > 0.0
        rate = bound / (self.pair.friction * np.where(fresh, self.opening, 1.0))
        return np.where(fresh[:, None], -rate[:, None] * slip, trial)

    def _tilt(self):
        """Friction traction per pressure, (n, gdim), of nodes that slip or have closed in this increment; else zero."""
        if self.pair.friction == 0.0:
            return np.zeros_like(self.direction)
        tilt = np.where(self.sliding[:, None], self.pair.friction * self.direction, 0.0)
        grips = self._grips()
        tilt[grips] = -self._free_slip(self._slip)[grips] / self.opening[grips, None]
        return tilt

    def _grips(self):
        """Nodes that have closed in this increment and do not slip, mask (n)."""
        return self.active & self.usable & ~self.sliding & (self.opening > 0.0) & (self.pair.friction > 0.0)

    def springs(self):
        """Tractions that change with the slip: Newton's method sees springs. Collective.

        In 3D the traction of a node that slips turns with the slip: across its direction, friction bound over slip
        (return mapping t = bound trial / |trial|, linearised). Of a node that has closed in this increment, pressure
        over the gap it has closed.

        Returns:
            matrix, and force (array over owned dofs) to take from the right-hand side; or None.
        """
        self._spring = np.zeros((len(self.nodes), self.gdim, self.gdim))  # stiffness per area
        self._rest = np.zeros((len(self.nodes), self.gdim))  # slip at which springs are slack
        if self.pair.friction == 0.0:
            return None
        grips, slides = self._grips(), self.sliding & self.active & self.usable & (self.gdim == 3)
        rows = np.flatnonzero(grips | slides)
        if not self.comm.allreduce(len(rows)):
            return None
        slip = self._free_slip(self._slip)
        pressure = np.maximum(self.multiplier[rows], 0.0)
        along = self._normal_direction()[rows]
        plane = np.eye(self.gdim) - np.einsum("na,nb->nab", along, along)
        across = plane - np.einsum("na,nb->nab", self.direction[rows], self.direction[rows])
        bound, length = self.pair.friction * pressure, np.linalg.norm(slip[rows], axis=1)
        turning = np.minimum(bound / np.maximum(length, 1e-300), 1e3 * self._stiffness_per_area()[rows])
        gripping = pressure / np.where(grips[rows], self.opening[rows], 1.0)
        blocks = np.where(grips[rows, None, None], gripping[:, None, None] * plane, turning[:, None, None] * across)
        self._spring[rows] = blocks
        self._rest[grips] = slip[grips]
        traction = np.zeros((len(self.nodes), self.gdim))
        traction[rows] = np.einsum("nab,nb->na", blocks, (self._free_slip(self._at[1]) - self._rest)[rows])
        # Forces go with the diagonal of D, slips are means over the cover.
        area = self.geometry.weight[rows] ** 2 / self.geometry.cover[rows]
        return self.geometry.springs(rows, area[:, None, None] * blocks), self.geometry.forces(traction)
