# SPDX-License-Identifier: MIT
"""Torque on a spinning body, and the spin that follows from a given torque."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from ..common.types import FloatArray, IntArray
from ..statics.problem import StaticProblem
from .contact import RollingContact
from .flow import Flow
from .motions import Spin
from .saddle_system import SteadySystem

# Of the speed: changes of slip velocity that are allowed in an iteration, besides the largest slip; where all nodes
# slip, and where some stick, so that the derivative tells more.
FURTHER, STUCK = 1e-4, 2e-3

HALVED = 3  # bisections in a row towards the same bound, which is then given up
LIMITED = 8  # iterations in a row with the largest change, in which the slip velocity doubles each time


class Torque:
    """Moment of the contact forces on a body about the axis of its spin.

    Args:
        problem: static problem of the bodies.
        spin: spin of the body.
        nodes: its nodes, owned.
    """

    def __init__(self, problem: StaticProblem, spin: Spin, nodes: IntArray) -> None:
        self._problem, self._spin, self._nodes = problem, spin, nodes
        gdim = problem.space.mesh.geometry.dim
        self._arm = np.zeros((len(nodes), 3))
        self._arm[:, :gdim] = problem.space.tabulate_dof_coordinates()[nodes, :gdim] - spin.point
        self._gdim = gdim

    def _turned(self, vectors: FloatArray) -> FloatArray:
        """axis x vectors, (nodes, gdim)."""
        full = np.zeros((len(self._nodes), 3))
        full[:, : vectors.shape[1]] = vectors
        return np.cross(self._spin.axis, full)[:, : self._gdim]

    def _here(self, values: FloatArray) -> FloatArray:
        return values[: self._problem.num_owned].reshape(-1, self._gdim)[self._nodes]

    def of(self, forces: FloatArray, moved: FloatArray | None = None) -> float:
        """Torque that forces take: minus their moment at deformed places, or what displacements add to it [F L].
        Collective.

        Args:
            forces: contact forces, owned dofs [F].
            moved: displacements by which places change; None: the moment itself [L].
        """
        lever = self._turned(self._arm) + self._turned(self._here(self._problem.u.x.array))
        if moved is not None:
            lever = self._turned(self._here(moved))
        return -float(self._problem.space.mesh.comm.allreduce(float(np.sum(self._here(forces) * lever))))

    @property
    def reach(self) -> float:
        """Largest distance of a node from the axis [L]. Collective."""
        arm = np.cross(self._spin.axis, self._arm)
        largest = float(np.linalg.norm(arm, axis=1).max(initial=0.0))
        return float(self._problem.space.mesh.comm.allreduce(largest, MPI.MAX))


class TorqueControl:
    """The angular velocity at which a body's torque has a given value, an unknown of RollingNewton.

    Each linearised problem is solved twice with one matrix, once for the derivative by the angular velocity.

    Args:
        problem: static problem of the bodies.
        flow: flow of the bodies.
        spin: spin of the body; its omega changes.
        torque: of the body.
        target: wanted value [F L].
    """

    def __init__(self, problem: StaticProblem, flow: Flow, spin: Spin, torque: Torque, target: float) -> None:
        self._problem, self._flow, self._spin, self._torque, self.target = problem, flow, spin, torque, target
        self._reach = torque.reach
        self._slopes: list[FloatArray] = []
        self._load: FloatArray = np.zeros(0)
        self._most, self._limited, self._rubs = np.inf, 0, False
        self._low, self._high = -np.inf, np.inf
        self._halved = 0  # bisections in a row: upwards positive, downwards negative

    def error(self, contacts: Sequence[RollingContact]) -> float:
        """Torque less its target, over contact force times largest radius [1]. Collective."""
        forces = [c.contact_forces() for c in contacts]
        total = sum(float(np.abs(f) @ np.abs(f)) for f in forces)
        scale = float(np.sqrt(self._problem.space.mesh.comm.allreduce(total))) * self._reach
        off = abs(sum(self._torque.of(f) for f in forces) - self.target)
        return off / scale if scale > 0.0 else off

    def linearise(self, contacts: Sequence[RollingContact]) -> None:
        """Derivatives of loads and slip velocities by the angular velocity at the present state. Collective.

        Args:
            contacts: contacts at the present state.
        """
        omega = self._spin.omega
        step = 0.5 * omega or 1.0  # the forces are quadratic in omega: any step gives the exact derivative
        residuals = []
        for way in (1.0, -1.0):
            self._set(omega + way * step)
            residuals.append(self._problem.assemble_residual().array.copy())
        self._set(omega)
        self._load = (residuals[0] - residuals[1]) / (2.0 * step)
        self._slopes = [c.velocity_slope(self._spin) for c in contacts]
        comm = self._problem.space.mesh.comm

        def largest(vectors: FloatArray, c: RollingContact) -> float:
            return float(np.linalg.norm(vectors, axis=1)[c.active].max(initial=0.0))

        slip = comm.allreduce(max(largest(c.slip_velocity, c) for c in contacts), MPI.MAX)
        slope = comm.allreduce(max(largest(s, c) for s, c in zip(self._slopes, contacts)), MPI.MAX)
        stuck = comm.allreduce(sum(int(np.count_nonzero(c.active & ~c.sliding)) for c in contacts))
        # Where all slips, the torque hardly depends on the spin: no further at a time than slip may turn round.
        self._rubs = slope > 0.0
        further = STUCK if stuck else FURTHER * 2.0**self._limited
        self._most = float((further * max(c.speed() for c in contacts) + slip) / slope) if slope > 0.0 else np.inf

    def _set(self, omega: float) -> None:
        self._spin.omega = omega
        self._flow.update()

    def correction(
        self,
        system: SteadySystem,
        solve: Callable[[PETSc.Vec, PETSc.Vec], str | None],
        x: PETSc.Vec,
        forces: FloatArray,
    ) -> tuple[str | None, float]:
        """Add to a solution what the change of the angular velocity causes. Collective.

        Args:
            system: linear system.
            solve: solves it for a right-hand side.
            x: solution at the present angular velocity; is changed.
            forces: contact forces of the state that is linearised about, owned dofs [F].

        Returns:
            What is wrong with the linear solution, or None; change of the angular velocity [1/T].
        """
        b = system.load(self._load, np.zeros(len(system.fixed)), system.right_of_velocities(self._slopes))
        response = system.create()
        fault = solve(b, response)
        b.destroy()
        if fault:
            response.destroy()
            return fault, 0.0
        values = []
        for y in (x, response):
            values.append(self._torque.of(system.contact_forces(y)) + self._torque.of(forces, system.displacements(y)))
        change = 0.0
        off = self.target - values[0]
        if not self._rubs:
            fault = "the torque does not depend on the spin: nothing touches, or nothing rubs"
        else:
            # A larger spin slips more and takes more torque; where all slips, round-off may say otherwise.
            far = values[1] <= 0.0 or abs(off) > self._most * values[1]
            change = float(np.copysign(self._most, off)) if far else off / values[1]
            change = self._within_bracket(change, off)
            x.axpy(change, response)
        response.destroy()
        return fault, change

    def _within_bracket(self, change: float, off: float) -> float:
        """A change of spin that stays between spins known to be too small and too large: else half the way."""
        omega = self._spin.omega
        if off > 0.0:
            self._low = omega
        else:
            self._high = omega
        if not self._low < self._high:  # known from states that were not solved yet
            self._low, self._high = (omega, np.inf) if off > 0.0 else (-np.inf, omega)
        if self._low < omega + change < self._high:
            self._halved = 0
            return change
        # Bounds may come from a status that has changed since: one that is approached again and again is given up.
        self._halved = max(self._halved, 0) + 1 if off > 0.0 else min(self._halved, 0) - 1
        if abs(self._halved) > HALVED:
            self._low, self._high, self._halved = (omega, np.inf, 0) if off > 0.0 else (-np.inf, omega, 0)
            return change
        return 0.5 * (self._low + self._high) - omega if np.isfinite(self._high - self._low) else change

    def apply(self, change: float) -> None:
        """Change the angular velocity. Collective.

        Args:
            change: by which [1/T].
        """
        self._set(self._spin.omega + change)
        self._limited = self._limited + 1 if abs(change) >= self._most else 0

    @property
    def fault(self) -> str:
        """Why the torque is out of reach; an empty text if it may be in reach."""
        if self._limited < LIMITED:
            return ""
        return (
            f"the torque {self.target:.4g} was not reached at omega = {self._spin.omega:.6g}: friction cannot bear it, "
            "or the spin to begin with is too far from the solution"
        )

    def slopes(self) -> list[FloatArray]:
        """Derivatives of the slip velocities by the angular velocity, (n, gdim) each [L]."""
        return self._slopes
