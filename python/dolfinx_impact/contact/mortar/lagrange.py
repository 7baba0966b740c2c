# SPDX-License-Identifier: MIT
"""Contact by Lagrange multipliers: dual mortar, primal-dual active set, multipliers condensed; docs/contact.md."""

import copy

import numpy as np
from mpi4py import MPI

from ... import _cpp
from ...common.collective import comm_of, guard
from ...common.types import FloatArray
from .friction import Coulomb
from .geometry import RigidGeometry
from .mortar_geometry import MortarGeometry
from .prescribed_overlap import prescribed_overlap
from ..pair import ContactStatus, check_pair, check_quadrature_degree
from ..output import ContactOutput

BASES = ("dual", "standard", "linear")


class Lagrange:
    """Enforce contact of a pair by Lagrange multipliers, seed (3.47), corrected.

    Args:
        pair: ContactPair.
        quadrature_degree: of the integrals over segments; None: exact on flat, affine facets.
        basis: "dual": multipliers are condensed, the linear system keeps the size and character of elasticity;
            "standard": the shape functions of the displacements; "linear": linear functions also for displacements of
            degree 2. These two stay in the system, a saddle point for a direct solver. Obstacles take the dual one.

    Raises:
        TypeError: not a ContactPair. ValueError: another basis, or one that an obstacle does not take.
    """

    def __init__(self, pair, quadrature_degree=None, basis="dual"):
        with guard(comm_of(pair), "Lagrange", pair=pair, quadrature_degree=quadrature_degree, basis=basis):
            check_pair(pair)
            if basis not in BASES:
                raise ValueError(f"basis is {basis!r}: give one of {', '.join(BASES)}")
            if pair.rigid and basis != "dual":
                raise ValueError(f"basis is {basis!r}: against a rigid obstacle multipliers are nodal, give 'dual'")
            quadrature_degree = check_quadrature_degree(quadrature_degree)
        self.pair, self.quadrature_degree, self.basis = pair, quadrature_degree, basis

    def __repr__(self):
        return f"Lagrange({self.pair!r}, basis={self.basis!r})"

    def _bind_explicit(self, problem):
        raise ValueError("multipliers are for static problems: use Penalty or Kinematic in an ExplicitProblem")

    def _bind(self, problem):
        return LagrangeContact(self, problem)


class LagrangeContact(Coulomb, ContactOutput):
    """Multipliers of one pair in a problem. Points are the slave's nodes that this rank owns; see ContactOutput."""

    def __init__(self, spec, problem):
        self.pair, self.comm, self.problem = spec.pair, problem.space.mesh.comm, problem
        where = spec, problem.space, problem.axisymmetric, problem.fixed
        self.geometry = RigidGeometry(*where) if self.pair.rigid else MortarGeometry(*where, spec.basis)
        self.nodes, self.gdim = self.geometry.nodes, self.geometry.gdim
        n = len(self.nodes)
        self.fixed = problem.fixed.reshape(-1, self.gdim)[self.nodes]
        self.active = np.zeros(n, dtype=bool)
        self.sliding = np.zeros(n, dtype=bool)
        self.direction = np.zeros((n, self.gdim))  # of the friction traction of slipping nodes
        self.multiplier: FloatArray = np.zeros(n)
        self.friction_traction = np.zeros((n, self.gdim))
        self.traction_n = np.zeros((n, self.gdim))  # friction's, of the last converged state
        self.imposed = np.zeros((n, self.gdim))  # see Coulomb
        self.total_slip = np.zeros((n, self.gdim))
        self.opening = None  # gap at the start of the increment where a node is open then, else zero [L]
        self.nodal_stiffness = np.ones(n)  # of the bodies at the slave's nodes [F/L]
        self.facing_stiffness = np.zeros(n)  # of the master opposite to them [F/L]

    # --- state of an increment -------------------------------------------------------------------------------------

    def save_state(self):
        """State that an increment starts from, as a dict of copies."""
        names = ("active", "sliding", "direction", "multiplier", "friction_traction", "total_slip", "opening")
        names += ("traction_n", "imposed")
        return {name: copy.copy(getattr(self, name)) for name in names} | {"geometry": self.geometry.save_state()}

    def restore_state(self, state):
        """Back to a saved state."""
        for name, value in state.items():
            if name == "geometry":
                self.geometry.restore_state(value)
            else:
                setattr(self, name, copy.copy(value))

    def begin_step(self, u, displacement, target=None):
        """An increment starts at u; a rigid master goes to `displacement` in it, prescribed degrees of freedom to
        `target` (array over all dofs, prescribed entries count; None: they stay). Collective."""
        if self.opening is None:
            self.geometry.update_gap(u)
            self.opening = self._opened(self.geometry.gap)
        self.geometry.begin_step(u, displacement, target)

    def _opened(self, gap):
        return np.where(~self.active & (gap > self.geometry.tolerance), gap, 0.0)

    def accept_step(self):
        """The increment has converged: slip adds up, less what a node slides before it closes."""
        slip = self._slipping(self._slip)
        length = np.linalg.norm(slip, axis=1)
        free = np.where(np.isfinite(self.opening), self.opening, 0.0) * self.pair.friction
        part = np.where(self.opening > 0.0, np.maximum(0.0, 1.0 - free / np.maximum(length, 1e-300)), 1.0)
        self.total_slip += np.where(self.active[:, None], part[:, None] * slip, 0.0)
        self.total_slip[~self.active] = 0.0
        self.opening = self._opened(self._gap)
        self.traction_n = np.where(self.active[:, None], self.friction_traction, 0.0)
        self.update_totals()

    def update_gap(self, u):
        """Search, gaps and normals at the displacements u (array over owned and ghost dofs). Collective."""
        self.geometry.update_gap(u)
        self.frames, self.place, self.free_length = _cpp.multipliers.frames_at(self.geometry.normal, self.fixed)
        self.usable = self.geometry.participates & (self.place >= 0)
        self._gap, self._slip = self.geometry.gap, self.geometry.slip()
        self._at = self._gap, self._slip
        self._spring = None  # those of a linear problem
        if self.pair.friction > 0.0:
            self._split()

    def update_linearised_gap(self, increments):
        """Gaps and slips after displacement increments (array over owned dofs) of a linear solution, linear in them.
        Collective."""
        jump = self.geometry.jump(increments)
        gap, slip = self._at
        self._gap = gap + np.einsum("na,na->n", self.geometry.normal, jump)
        self._slip = slip + self.geometry.tangential(jump)
        if self.pair.friction > 0.0:
            self._drive_on()

    def linearised_response(self, increments, forces):
        """What gaps and multipliers gain by displacement increments and the nodal forces they cause (arrays over owned
        dofs), without friction: (n), (n). Collective."""
        gap = np.einsum("na,na->n", self.geometry.normal, self.geometry.jump(increments))
        along, weight = self._along(forces)[1:]
        return gap, along / (weight * np.maximum(self.free_length, 1e-3))

    def correct_linearisation(self, u):
        """After update_linearised_gap: take in what gaps and slips at the displacements u differ from the linear ones.

        A second-order correction, as in sequential quadratic programming: normals turn and points slide over the master
        also in the conditions, which condensed multipliers cannot see in their matrix. Collective.
        """
        gap, slip = self.geometry.evaluate_at(u)
        known = self.usable & np.isfinite(gap)
        gap = np.where(known, gap, 0.0) - np.where(known, self._gap, 0.0)
        slip = np.where(known[:, None], self.geometry.tangential(slip) - self._slip, 0.0)
        self._at = self._at[0] + gap, self._at[1] + slip

    # --- active set ------------------------------------------------------------------------------------------------

    def _state(self):
        """Arrays of the nodes' state, as C++ names them (NodalMultipliers)."""
        friction = self.pair.friction > 0.0
        return {
            "usable": self.usable, "active": self.active, "sliding": self.sliding, "gap": self._gap,
            "multiplier": self.multiplier, "slip": self._slip, "traction": self.friction_traction,
            "direction": self.direction, "stiffness": self._stiffness_per_area(),
            "opening": np.zeros(0) if self.opening is None else self.opening,
            "lock": self._lock if friction else np.zeros(0),
        }  # fmt: skip

    def _geometry(self):
        """Arrays of the nodes where the linear problem is linearised, as C++ names them (NodalGeometry)."""
        g = self.geometry
        return {
            "nodes": self.nodes, "normal": g.normal, "gap": self._at[0], "slip": self._at[1], "weight": g.weight,
            "cover": g.cover, "fixed": self.fixed, "ahead": g.ahead(), "frames": self.frames, "place": self.place,
            "length": self.free_length,
        }  # fmt: skip

    def _normal_direction(self):
        return self.frames[np.arange(len(self.nodes)), :, self.place]

    def _along(self, residual):
        """Free nodal forces, their parts along the constrained normal directions, and the nodes' weights."""
        free = np.where(self.fixed, 0.0, residual.reshape(-1, self.gdim)[self.nodes])
        weight = np.where(self.usable, self.geometry.weight, 1.0)
        return free, np.einsum("na,na->n", self._normal_direction(), free), weight

    def update_multipliers(self, residual):
        """Multipliers from the nodal residual (owned entries, without contact forces): equilibrium of slave nodes."""
        tilt, known, follow = np.zeros((len(self.nodes), self.gdim)), np.zeros(0), np.zeros(0)
        if self.pair.friction > 0.0:
            tilt = self._tilt() if self._spring is None else self._linear_tilt
            known, follow = self._explicit(), self._drive + self._lock
        at_nodes = residual.reshape(-1, self.gdim)[self.nodes]
        found = _cpp.multipliers.evaluate_multipliers(
            self._state(), self._geometry(), self.gdim, self.pair.friction, at_nodes, tilt, known, follow
        )
        self.multiplier = found[0]
        if self.pair.friction > 0.0:
            self.friction_traction = found[1]

    def set_multipliers(self, forces):
        """Multipliers from a saddle point: forces (n, gdim) along the directions of the frames, zero where nothing is
        constrained. After `constraints`, `friction_springs`, whose state the solution is of, and
        `update_linearised_gap`."""
        on = (self.active & self.usable)[:, None]
        forces = np.einsum("nad,nd->na", self.frames, forces)
        weight = np.where(self.usable, self.geometry.weight, 1.0)
        along = np.einsum("na,na->n", self._normal_direction(), forces)
        self.multiplier = np.where(on[:, 0], along / (weight * self._lean(self._linear_tilt)), 0.0)
        tangential = (forces - along[:, None] * self._normal_direction()) / weight[:, None]
        tangential += self.multiplier[:, None] * self._linear_tilt + self._explicit()
        self.friction_traction = np.where(on, tangential, 0.0)

    def rotate_friction_traction(self):
        """Friction tractions known from a saddle point follow the surface and the slip to the present state."""
        t = self.geometry.tangential(self.friction_traction)
        size, length = np.linalg.norm(self.friction_traction, axis=1), np.linalg.norm(t, axis=1)
        t *= np.where(length > 0.0, size / np.maximum(length, 1e-300), 0.0)[:, None]
        grips = self._grips()
        t[grips] = (self.multiplier[:, None] * self._tilt())[grips]
        self.friction_traction = t

    def update_active_set(self, first, last=None):
        """Change the active set and who sticks; returns how many nodes of all ranks would change. Collective.

        Args:
            first: the increment has just begun: no multipliers yet, only gaps count.
            last: change no node but the one with this number, of all nodes of all ranks; see `last_change`.
        """
        active, sliding, direction = self._proposal(first)
        stuck = self._stuck()
        changed = (active != self.active) | (sliding != self.sliding)
        number = self.geometry.numbers
        self.last_change = self.comm.allreduce(int(np.max(number[changed], initial=-1)), MPI.MAX)
        take = np.ones_like(changed) if last is None else number == last
        self.active = np.where(take, active, self.active)
        self.sliding = np.where(take, sliding, self.sliding)
        self.direction = np.where(take[:, None], direction, self.direction)
        if self.pair.friction > 0.0 and not first:
            changed = changed | self._impose(stuck)
        return self.comm.allreduce(int(np.count_nonzero(changed)))

    def _proposal(self, first):
        """Active and sliding masks and friction's directions that gaps, multipliers and slips ask for."""
        tolerance = self.geometry.tolerance
        largest = self.comm.allreduce(float(np.max(self.multiplier, initial=0.0)), MPI.MAX)
        return _cpp.multipliers.update_active_set(
            self._state(), self.gdim, self.pair.friction, first, tolerance, largest
        )

    @property
    def num_active(self):
        """Active nodes of all ranks. Collective."""
        return self.comm.allreduce(int(np.count_nonzero(self.active)))

    def _violations(self):
        """Gaps of active nodes and slips of those that stick, (n), (n) [L]."""
        gap = np.where(self.active & self.usable, np.abs(self.geometry.gap), 0.0)
        slip = np.zeros(len(gap))
        if self.pair.friction > 0.0:
            slip = np.where(self._stuck(), np.linalg.norm(self._slipping(self._slip), axis=1), 0.0)
        return gap, slip

    def violation(self):
        """Largest gap of an active node, or slip of one that sticks, of all ranks, in sizes of the bodies [1].
        Collective."""
        largest = float(np.max(self._violations(), initial=0.0))
        return self.comm.allreduce(largest, MPI.MAX) / self.geometry.size

    def largest_violation(self):
        """The node whose gap or slip is largest. Collective."""
        mine = []
        for what, values in zip(("a gap of an active node", "a slip of a node that sticks"), self._violations()):
            if len(values):
                at = int(np.argmax(values))
                mine.append((float(values[at]), what, int(self.geometry.numbers[at]), self.points[at].tolist()))
        value, what, number, x = max(sum(self.comm.allgather(mine), []))
        return f"{self.pair.name}: {what}, number {number} at ({', '.join(f'{c:.4g}' for c in x)}), is {value:.3e}"

    def prescribed_overlap(self):
        """Slave nodes whose displacement along the normal is prescribed and that lie in the master, or an empty text:
        there is nothing that a multiplier could move. Collective."""
        return prescribed_overlap(
            self.pair.name, self.comm, self.geometry, self.geometry.participates & (self.place < 0)
        )

    def augment(self):
        """Multipliers need no further rounds."""
        return False

    def close_nearest(self):
        """Close the nodes nearest to the master, if they nearly touch; returns whether there are any. Collective."""
        near = self.geometry.nearest()
        if near is None:
            return False
        self.active = self.active | (near & self.usable)
        return True

    def closing_forces(self):
        """No force besides: constraints close the nearest nodes. See close_nearest."""

    # --- linear system ---------------------------------------------------------------------------------------------

    @property
    def displacement(self):
        """Of a rigid master, as reached [L]."""
        return self.geometry.displacement

    has_multipliers = True
    symmetric = True  # what makes it not so is known to the transformation

    def constraints(self):
        """Constraints of the active nodes for the linear system."""
        rows = np.flatnonzero(self.active & self.usable)
        self._linear_tilt = self._tilt()
        return _cpp.multipliers.constrain(
            self._state(), self._geometry(), self.gdim, self.pair.friction, self._linear_tilt,
            self.geometry.master_rows(rows),
        )  # fmt: skip

    def update_nodal_stiffness(self, K):
        """Take from the bodies' stiffness what the changes of state need. Collective."""
        self.nodal_stiffness, self.facing_stiffness = self.geometry.diagonal_stiffness(K)

    def tangent(self):
        """Geometric stiffness of the contact forces: a matrix, or None. Collective."""
        return self.geometry.stiffness(self.multiplier, self.traction, self.active & self.usable)

    def rigid_body_constraints(self, motions):
        """Jumps at active nodes under the rigid body modes; see StaticContact. Collective."""
        held = np.flatnonzero(self.active & self.usable)
        rows = self.geometry.rigid_body_jumps(motions, held)
        return list(rows) if self.pair.friction > 0.0 else [np.einsum("na,anm->nm", self.normal[held], rows)]

    # --- results ---------------------------------------------------------------------------------------------------

    @property
    def points(self):
        """Current positions of the slave's nodes, (n, gdim) [L]."""
        return self.geometry.points

    @property
    def gap(self):
        """Gap, positive open; infinite where there is no master, (n) [L]."""
        return self.geometry.gap

    @property
    def pressure(self):
        """Contact pressure per reference area, (n) [F/L^2]."""
        return np.maximum(np.where(self.active, self.multiplier, 0.0), 0.0)

    @property
    def normal(self):
        """Unit normals out of the master, (n, gdim)."""
        return self.geometry.normal

    @property
    def traction(self):
        """Contact traction on the slave per reference area, (n, gdim) [F/L^2]."""
        return np.where(
            self.active[:, None], self.multiplier[:, None] * self.geometry.normal + self.friction_traction, 0.0
        )

    @property
    def slip(self):
        """Tangential displacement of slave against master since it last stuck to it, (n, gdim) [L]."""
        return self.total_slip

    @property
    def status(self):
        """ContactStatus numbers, (n)."""
        slips = self.sliding | (self.pair.friction == 0.0)
        return np.where(~self.active, ContactStatus.open, np.where(slips, ContactStatus.slip, ContactStatus.stick))

    @property
    def weight(self):
        """Area that belongs to each point, (n) [L^2]; a length in 2D."""
        return self.geometry.cover

    def covered(self):
        """Part of each point's area that is in contact, (n). Collective."""
        return self.geometry.covered(self.pressure, self.active & self.usable)

    def contact_forces(self):
        """Nodal contact forces on both bodies, array over owned dofs [F]. Collective."""
        return self.geometry.forces(self.traction)
