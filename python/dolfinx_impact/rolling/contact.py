# SPDX-License-Identifier: MIT
"""Contact by multipliers with friction against the steady slip velocity; seed (3.58)-(3.60), docs/rolling.md."""

from __future__ import annotations

from typing import Any

import numpy as np
from dolfinx.la import InsertMode, vector
from mpi4py import MPI
from petsc4py import PETSc

from .. import _cpp
from ..common.types import BoolArray, Float64Array, FloatArray, IntArray
from ..contact.mortar.lagrange import Lagrange, LagrangeContact
from ..contact.pair import ContactStatus
from .flow import Flow
from .motions import Spin
from .streamlines import StreamlineDerivative, node_matrix


# Part of a node's jump that free displacements make; with less it is prescribed. On a plane of symmetry round surfaces
# have parts of 1e-6, as facets are not opposite to each other exactly; a prescribed slave on a free master has 1.
PRESCRIBED = 0.1


class RollingLagrange(Lagrange):
    """A Lagrange contact that a RollingProblem binds to its flow.

    Args:
        spec: as the user gave it.
        flow: flow of the bodies.
    """

    def __init__(self, spec: Lagrange, flow: Flow) -> None:
        super().__init__(spec.pair, spec.quadrature_degree, spec.basis)
        self.flow = flow

    def _bind(self, problem: Any) -> RollingContact:
        return RollingContact(self, problem)


class RollingContact(LagrangeContact):
    """Multipliers of a pair whose bodies flow past each other, with Coulomb friction.

    Material points have the velocity V = w + (Grad u) w, taken at the nodes of both surfaces with the derivative from
    upstream. The slip velocity of a slave node is the mean, over what its multiplier covers, of V of the slave against
    V of the master, without its normal part: the functional that makes slips of increments in statics.

    Args:
        spec: RollingLagrange.
        problem: static problem of the bodies.

    Attributes:
        held: components in which neither body can move, mask (n, gdim): there is no slip to speak of.
        rate: largest velocity jump per displacement, set by the solver; None: not known yet [1/T].
        jump, velocity_jump: matrices (nodes, nodes): weighted displacements of slave against master, and weighted
            velocities by displacements, at the present state [L^2], [L^2/T].
    """

    may_share_nodes = False

    def __init__(self, spec: RollingLagrange, problem: Any) -> None:
        super().__init__(spec, problem)
        self._flow = spec.flow
        surfaces = [s for s in (self.geometry.slave, self.geometry.master) if s is not None]
        self._streamlines = StreamlineDerivative(problem.space, surfaces)
        self._derivative: PETSc.Mat | None = None
        self._w: FloatArray = np.zeros((len(problem.fixed) // self.gdim, self.gdim))
        self.jump: PETSc.Mat | None = None
        self.velocity_jump: PETSc.Mat | None = None
        self.rate: float | None = None
        self.held: BoolArray = np.zeros((len(self.nodes), self.gdim), dtype=bool)
        self._slip_velocity: Float64Array = np.zeros((len(self.nodes), self.gdim))
        self._friction_power: Float64Array = np.zeros(1)

    def _friction_of_increments(self) -> float:
        """As in statics: there is none."""
        return 0.0

    @property
    def slip_velocity(self) -> FloatArray:
        """Slip velocity of slave against master, (n, gdim) [L/T]."""
        return self._slip_velocity

    @slip_velocity.setter
    def slip_velocity(self, values: FloatArray) -> None:
        self._slip_velocity[...] = values

    @property
    def friction_power(self) -> float:
        """Power that friction takes out of the motion, of all ranks [F L/T]."""
        return float(self._friction_power[0])

    @friction_power.setter
    def friction_power(self, value: float) -> None:
        self._friction_power[0] = value

    # --- velocities --------------------------------------------------------------------------------------------------

    def update_flow(self) -> None:
        """Take over the present rates of the motions. Collective."""
        self._w = self._flow.at_nodes()
        if self._derivative is not None:
            self._derivative.destroy()
        self._derivative = self._streamlines.matrix(self._w)
        self.rate = None

    def update_matrices(self) -> None:
        """Matrices of jumps at the present state, after update_gap. Collective."""
        assert self._derivative is not None
        for matrix in (self.jump, self.velocity_jump):
            if matrix is not None:
                matrix.destroy()
        if self.pair.rigid:
            at = self.geometry.numbers
            self.jump = node_matrix(self.problem.space, at, at, self.geometry.weight)
        else:
            assert isinstance(self.geometry, _cpp.multipliers.DeformableGeometry)
            self.jump = self.geometry.jump_matrix().copy()
        self.velocity_jump = self.jump.matMult(self._derivative)
        self.held = self._held_components(self.jump)

    def _held_components(self, jump: PETSc.Mat) -> BoolArray:
        """Components in which slave and master are both prescribed, as on a plane of symmetry, mask (n, gdim).
        Collective."""
        if not self.comm.allreduce(bool(np.any(self.fixed)), MPI.LOR):
            return np.zeros((len(self.nodes), self.gdim), dtype=bool)
        starts, cols, values = jump.getValuesCSR()
        first = jump.getOwnershipRange()[0]
        rows = np.repeat(np.arange(len(starts) - 1), np.diff(starts)) + first
        size = node_matrix(self.problem.space, rows.astype(np.int64), cols.astype(np.int64), np.abs(values))
        free = ~self.problem.fixed[: self.problem.num_owned]
        shares = self.means(size, free.astype(float))
        size.destroy()
        return (shares < PRESCRIBED) & self.geometry.participates[:, None]

    def means(self, matrix: PETSc.Mat, values: FloatArray) -> FloatArray:
        """A matrix of jumps times nodal vectors, over the cover, (n, gdim); zero where no multiplier lives. Collective.

        Args:
            matrix: jump or velocity_jump.
            values: over owned dofs.
        """
        x, y = matrix.createVecRight(), matrix.createVecLeft()
        out = np.zeros((len(self.nodes), self.gdim))
        for c in range(self.gdim):
            x.array[:] = values.reshape(-1, self.gdim)[:, c]
            matrix.mult(x, y)
            out[:, c] = y.array_r[self.nodes]
        x.destroy()
        y.destroy()
        cover = np.where(self.geometry.participates, self.geometry.cover, 1.0)
        return np.where(self.geometry.participates[:, None], out / cover[:, None], 0.0)

    def relative_velocity(self, u: FloatArray) -> FloatArray:
        """Velocity of slave against master, normal part included, (n, gdim) [L/T]. Collective.

        Args:
            u: displacements, owned dofs [L].
        """
        assert self.jump is not None and self.velocity_jump is not None
        owned = self.geometry.index_map.size_local
        velocity = self.means(self.jump, self._w[:owned].ravel()) + self.means(self.velocity_jump, u)
        return velocity + self.imposed_velocity()

    def imposed_velocity(self) -> FloatArray:
        """Part of the velocity of slave against master that is not of nodes: of a rigid master, and lateral and spin
        creep, (n, gdim) [L/T]. Collective."""
        velocity = self._flow.creepage(self)
        if self.pair.rigid:
            velocity = velocity - self._flow.rigid_velocity(self.pair.rigid_master)[: self.gdim]
        return velocity

    def material_velocity(self) -> FloatArray:
        """Velocity of the material at the nodes of both surfaces, w elsewhere, owned nodes, (nodes, gdim) [L/T].
        Collective."""
        assert self._derivative is not None
        owned = self.geometry.index_map.size_local
        u = self.problem.u.x.array[: self.gdim * owned].reshape(-1, self.gdim)
        x, y = self._derivative.createVecRight(), self._derivative.createVecLeft()
        velocity = self._w[:owned].copy()
        for c in range(self.gdim):
            x.array[:] = u[:, c]
            self._derivative.mult(x, y)
            velocity[:, c] += y.array_r
        x.destroy()
        y.destroy()
        return velocity

    def check_directions(self) -> None:
        """Refuse bodies that move against each other, or not at all, where they are nearest. Collective.

        Raises:
            ValueError: on all ranks.
        """
        self.update_flow()
        self.update_gap(self.problem.u.x.array)
        self.update_matrices()
        assert self.jump is not None
        owned = self.geometry.index_map.size_local
        against = self.means(self.jump, self._w[:owned].ravel())
        if self.pair.rigid:
            against = against - self._flow.rigid_velocity(self.pair.rigid_master)[: self.gdim]
        gap = np.where(self.geometry.participates, self.geometry.gap, np.inf)
        nearest = int(np.argmin(gap)) if len(gap) else 0
        mine = (
            (float(gap[nearest]), self._w[self.nodes[nearest]], against[nearest], self.points[nearest])
            if len(gap)
            else None
        )
        found = [row for row in self.comm.allgather(mine) if row is not None and np.isfinite(row[0])]
        if not found:
            return
        _, slave, jump, place = min(found, key=lambda row: row[0])
        master = slave - jump
        where = f"{self.pair.name}, at {np.round(place, 9).tolist()}"
        if self.friction > 0.0 and not (np.any(slave) or np.any(master)):
            raise ValueError(f"{where}: neither body moves, so that friction has no direction; give a spin or a speed")
        if float(slave @ master) < 0.0:
            raise ValueError(
                f"{where}: the slave's material moves with {slave.tolist()}, the master's with {master.tolist()}: spin "
                "and speed are of opposite sense; change the sign of one"
            )

    def velocity_slope(self, spin: Spin) -> FloatArray:
        """Derivative of the slip velocity by the angular velocity of a body, (n, gdim) [L]. Collective.

        Args:
            spin: of the body.
        """
        assert self.jump is not None
        velocity = self.material_velocity()
        owned = len(velocity)
        turning = self._flow.nodes_of(spin)
        part = np.zeros_like(velocity)
        part[turning[turning < owned]] = velocity[turning[turning < owned]] / spin.omega
        return self.tangential(self.means(self.jump, part.ravel()))

    def tangential(self, vectors: FloatArray) -> FloatArray:
        """Vectors less their parts along the normals and along held components, (n, gdim)."""
        n = self.geometry.normal
        return np.where(self.held, 0.0, vectors - np.einsum("na,na->n", n, vectors)[:, None] * n)

    def main_direction(self) -> FloatArray:
        """Velocity of the slave's material through the mesh, (n, gdim) [L/T]."""
        return self._w[self.nodes]

    def turn_about_normal(self) -> FloatArray:
        """Velocities of a turn with unit rate about the contact's mean normal, through its centre of pressure,
        (n, gdim) [L]. Collective."""
        pressed = np.where(self.active, self.multiplier * self.geometry.weight, 0.0)
        sums = np.concatenate([[pressed.sum()], pressed @ self.points, pressed @ self.geometry.normal])
        total = self.comm.allreduce(sums)
        if total[0] <= 0.0:
            return np.zeros_like(self.points)
        centre, axis = total[1:4] / total[0], total[4:] / np.linalg.norm(total[4:])
        return np.cross(axis, self.points - centre)

    def speed(self) -> float:
        """Largest speed of the material at the surfaces, of all ranks [L/T]. Collective."""
        largest = 0.0
        for surface in (self.geometry.slave, self.geometry.master):
            if surface is not None and len(surface.nodes):
                largest = max(largest, float(np.linalg.norm(self._w[surface.nodes.ravel()], axis=1).max()))
        if self.pair.rigid:
            largest = max(largest, float(np.linalg.norm(self._flow.rigid_velocity(self.pair.rigid_master))))
        return float(self.comm.allreduce(largest, MPI.MAX))

    # --- state -------------------------------------------------------------------------------------------------------

    @property
    def friction(self) -> float:
        """Coefficient of friction [1]."""
        return self.pair.friction

    @property
    def carriers(self) -> BoolArray:
        """Nodes with a multiplier, mask (n)."""
        return self.usable & self.geometry.participates

    def with_neighbours(self, chosen: BoolArray) -> BoolArray:
        """Nodes and those that have a facet in common with one of them, mask (n). Collective.

        Args:
            chosen: mask of the nodes, (n).
        """
        mark = vector(self.geometry.index_map, 1)
        mark.array[:] = 0.0
        mark.array[self.nodes] = chosen
        mark.scatter_forward()
        facets = self.geometry.slave.nodes
        reached = np.unique(facets[np.any(mark.array[facets] > 0.0, axis=1)]) if len(facets) else facets.ravel()
        mark.array[:] = 0.0
        mark.array[reached] = 1.0
        mark.scatter_reverse(InsertMode.add)
        return chosen | (mark.array[self.nodes] > 0.0)

    @property
    def vector(self) -> FloatArray:
        """Multipliers as vectors, (n, gdim) [F/L^2]."""
        return self.traction

    def set_vector(self, vectors: FloatArray, active: BoolArray, sliding: BoolArray) -> None:
        """Store multipliers.

        Args:
            vectors: (n, gdim) [F/L^2].
            active: mask of nodes in contact, (n).
            sliding: mask of those that slip, (n).
        """
        self.active, self.sliding = active.copy(), sliding.copy()
        self.multiplier = np.where(active, np.einsum("na,na->n", self.geometry.normal, vectors), 0.0)
        self.friction_traction = np.where(active[:, None], self.tangential(vectors), 0.0)

    def turn_to_normals(self) -> None:
        """Friction tractions turn with the surface, keeping their size."""
        size = np.linalg.norm(self.friction_traction, axis=1)
        turned = self.tangential(self.friction_traction)
        left = np.linalg.norm(turned, axis=1)
        self.friction_traction = turned * np.where(left > 0.0, size / np.where(left > 0.0, left, 1.0), 0.0)[:, None]

    def state(self) -> _cpp.state.State:
        """State from which an increment starts, as named arrays, views of this contact's memory: copy it before, assign
        the copy to go back."""
        state = super().state()
        state.add("slip_velocity", _cpp.state.Place.node, self._slip_velocity)
        state.add("friction_power", _cpp.state.Place.all, self._friction_power)
        return state

    def saved_state(self) -> _cpp.state.State:
        """What a sweep's file holds of the last converged state, values of its own."""
        saved = super().saved_state()
        saved.add("slip_velocity", _cpp.state.Place.node, self._slip_velocity.copy())
        saved.add("friction_power", _cpp.state.Place.all, self._friction_power.copy())
        return saved

    def resume(self, saved: _cpp.state.State, u: FloatArray) -> None:
        """Continue from what `saved_state` has returned. Collective.

        Args:
            saved: the state.
            u: displacements that belong to it, owned and ghost dofs [L].
        """
        super().resume(saved, u)
        self.slip_velocity, self.friction_power = saved.array("slip_velocity"), saved.array("friction_power")[0]

    def accept_step(self) -> None:
        """The increment has converged. Collective."""
        gap = self.geometry.gap
        self.opening = np.where(~self.active & (gap > self.geometry.tolerance), gap, 0.0)
        self.update_totals()
        if self.velocity_jump is not None:
            power = float(np.sum(self.geometry.cover[:, None] * self.friction_traction * self.slip_velocity))
            self.friction_power = -self.comm.allreduce(power)

    @property
    def status(self) -> IntArray:
        """ContactStatus numbers, (n)."""
        slips = self.sliding | (self.pair.friction == 0.0)
        closed = self.active & self.geometry.part
        return np.where(~closed, ContactStatus.open, np.where(slips, ContactStatus.slip, ContactStatus.stick))

    @property
    def slip(self) -> FloatArray:
        """Steady states have a slip velocity, and no slip that adds up: zeros, (n, gdim) [L]."""
        return np.zeros((len(self.nodes), self.gdim))
