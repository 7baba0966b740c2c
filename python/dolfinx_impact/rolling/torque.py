# SPDX-License-Identifier: MIT
"""Torque on a spinning body, and the spin that follows from a given torque."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from mpi4py import MPI

from ..common.types import FloatArray, IntArray
from ..statics.problem import StaticProblem
from .body_response import BodyResponse
from .contact import RollingContact
from .contact_operators import Candidates, ContactOperators
from .flow import Flow
from .friction_problem import FrictionProblem, State
from .motions import Spin

FIRST = 1e-5  # of the speed: change of slip velocity with which the torque's change is looked at first
NO_FRICTION = "it does not depend on the spin: nothing touches, or nothing rubs"
OUT_OF_REACH = "friction cannot bear it, or the spin to begin with is too far from the solution"
FARTHEST = 0.1  # of the speed: changes of slip velocity beyond which the torque is out of reach


class Torque:
    """Moment of the contact forces on a body about the axis of its spin, which moves with the body's supports.

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

    @property
    def axle(self) -> FloatArray:
        """Displacement of the axis, (3): in each component the mean of the body's prescribed ones [L]. Collective."""
        p = self._problem
        held = p.fixed[: p.num_owned].reshape(-1, self._gdim)[self._nodes]
        sums = np.array([held.sum(axis=0), np.where(held, self._here(p.u.x.array), 0.0).sum(axis=0)], dtype=float)
        count, total = p.space.mesh.comm.allreduce(sums)
        moved: FloatArray = np.zeros(3)
        moved[: self._gdim] = total / np.maximum(count, 1.0)
        return moved

    def _deformed(self) -> FloatArray:
        """axis x (deformed place - a point on the axis), (nodes, gdim) [L]. Collective."""
        return self._turned(self._arm - self.axle) + self._turned(self._here(self._problem.u.x.array))

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
        lever = self._deformed() if moved is None else self._turned(self._here(moved))
        return -float(self._problem.space.mesh.comm.allreduce(float(np.sum(self._here(forces) * lever))))

    def lever(self) -> FloatArray:
        """Derivative of the torque by forces, owned dofs [L]. Collective."""
        return self._spread(-self._deformed())

    def lever_of(self, forces: FloatArray) -> FloatArray:
        """Derivative of `of(forces, moved)` by the displacements, owned dofs [F].

        Args:
            forces: contact forces, owned dofs [F].
        """
        return self._spread(self._turned(self._here(forces)))

    def _spread(self, vectors: FloatArray) -> FloatArray:
        out = np.zeros((self._problem.num_owned // self._gdim, self._gdim))
        out[self._nodes] = vectors
        return out.ravel()

    def velocities(self) -> FloatArray:
        """Velocities of a rigid body that turns with the spin about the axis, owned nodes, (nodes, gdim) [L/T].
        Collective."""
        return self._spin.omega * self._deformed()

    @property
    def nodes(self) -> IntArray:
        """Owned nodes of the body."""
        return self._nodes

    @property
    def reach(self) -> float:
        """Largest distance of a node from the axis [L]. Collective."""
        arm = np.cross(self._spin.axis, self._arm)
        largest = float(np.linalg.norm(arm, axis=1).max(initial=0.0))
        return float(self._problem.space.mesh.comm.allreduce(largest, MPI.MAX))


class TorqueControl:
    """The angular velocity at which a body's torque has a given value, an unknown of RollingNewton.

    Args:
        problem: static problem of the bodies.
        flow: flow of the bodies.
        spin: spin of the body; its omega changes.
        torque: of the body.
        target: wanted value [F L].
    """

    def __init__(self, problem: StaticProblem, flow: Flow, spin: Spin, torque: Torque, target: float) -> None:
        self._problem, self._flow, self._spin, self.torque, self.target = problem, flow, spin, torque, target
        self._reach = torque.reach

    @property
    def omega(self) -> float:
        """Present angular velocity [1/T]."""
        return self._spin.omega

    def error(self, contacts: Sequence[RollingContact]) -> float:
        """Torque less its target, over contact force times largest radius [1]. Collective."""
        forces = [c.contact_forces() for c in contacts]
        return self.relative(sum(self.torque.of(f) for f in forces), forces)

    def relative(self, torque: float, forces: Sequence[FloatArray]) -> float:
        """A torque less the target, over contact force times largest radius [1]. Collective."""
        total = sum(float(f @ f) for f in forces)
        scale = float(np.sqrt(self._problem.space.mesh.comm.allreduce(total))) * self._reach
        off = abs(torque - self.target)
        return off / scale if scale > 0.0 else off

    def linearise(
        self, contacts: Sequence[RollingContact], operators: ContactOperators, response: BodyResponse
    ) -> ReducedTorque:
        """Torque, loads and slip velocities by the angular velocity at the present state. Collective.

        Args:
            contacts: contacts at the present state.
            operators: of the contacts.
            response: of the bodies.
        """
        omega = self._spin.omega
        step = 0.5 * omega or 1.0  # the forces are quadratic in omega: any step gives the exact derivative
        residuals = []
        for way in (1.0, -1.0):
            self._set(omega + way * step)
            residuals.append(self._problem.assemble_residual().array.copy())
        self._set(omega)
        load = (residuals[0] - residuals[1]) / (2.0 * step)
        slopes = [c.velocity_slope(self._spin) for c in contacts]
        return ReducedTorque(self, contacts, load, slopes, response, max(c.speed() for c in contacts))

    def _set(self, omega: float) -> None:
        self._spin.omega = omega
        self._flow.update()

    def apply(self, change: float) -> None:
        """Change the angular velocity. Collective.

        Args:
            change: by which [1/T].
        """
        self._set(self._spin.omega + change)


class ReducedTorque:
    """The torque of linearised bodies as a function of multipliers and of the change of spin.

    Args:
        control: target and torque.
        contacts: contacts at the state that is linearised about.
        load: derivative of the residual by the angular velocity, owned dofs [F T].
        slopes: derivatives of the slip velocities by the angular velocity, (n, gdim) each [L].
        response: of the bodies.
        speed: of the surfaces [L/T].
    """

    def __init__(
        self,
        control: TorqueControl,
        contacts: Sequence[RollingContact],
        load: FloatArray,
        slopes: list[FloatArray],
        response: BodyResponse,
        speed: float,
    ) -> None:
        self._control, self._contacts, self.load, self.slopes, self._speed = control, contacts, load, slopes, speed
        self._forces: FloatArray = np.sum([c.contact_forces() for c in contacts], axis=0)
        self._turned, self.fault = response.solve(-load)
        self._lever = response.solve(control.torque.lever_of(self._forces))[0]
        self._now = 0.0

    def _value(self, operators: ContactOperators, forces: Sequence[FloatArray], moved: FloatArray) -> float:
        torque = self._control.torque
        return torque.of(operators.nodal_forces(forces)) + torque.of(self._forces, moved)

    def missing(self, operators: ContactOperators, forces: Sequence[FloatArray], moved: FloatArray) -> float:
        """Torque less its target, relative [1]. Collective.

        Args:
            operators: of the contacts.
            forces: multipliers, (n, gdim) each [F].
            moved: displacements from the state that is linearised about, owned dofs [L].
        """
        here = [operators.nodal_forces(forces)]
        return self._control.relative(self._value(operators, forces, moved), here)

    def at(self, operators: ContactOperators, forces: Sequence[FloatArray], moved: FloatArray) -> None:
        """Take the state that `gathered` counts from. Collective.

        Args:
            operators: of the contacts.
            forces: multipliers, (n, gdim) each [F].
            moved: displacements from the state that is linearised about, owned dofs [L].
        """
        self._now = self._value(operators, forces, moved)

    def gathered(self, operators: ContactOperators, candidates: Candidates) -> TorqueOfCandidates | None:
        """What rank 0 needs; None on others. Collective.

        Args:
            operators: of the contacts.
            candidates: nodes.
        """
        torque, contacts = self._control.torque, self._contacts
        by_place, by_motion = operators.jumps(torque.lever()), operators.jumps(self._lever)
        row = candidates.gather([a + b for a, b in zip(by_place, by_motion)])
        gaps, slips = [], []
        for c, slope in zip(contacts, self.slopes):
            assert c.jump is not None and c.velocity_jump is not None
            shift = c.means(c.jump, self._turned)
            gaps.append(np.einsum("na,na->n", c.geometry.normal, shift))
            slips.append(slope + c.tangential(c.means(c.velocity_jump, self._turned)))
        zeros = [np.zeros_like(s) for s in slips]
        found = [candidates.gather(v) for v in (zeros, gaps, slips)]
        by_spin = torque.of(self._forces, self._turned)
        if row is None:
            return None
        return TorqueOfCandidates(self._control.target - self._now, row, by_spin, State(*found), self._speed)


@dataclass
class TorqueOfCandidates:
    """Linear parts of the torque, on rank 0.

    Attributes:
        wanted: change of the torque [F L].
        row: derivatives by the forces of the candidates, (n, gdim) [L].
        by_spin: derivative by the angular velocity at constant forces [F L T].
        slope: derivative of the state by the angular velocity.
        speed: of the surfaces [L/T].
    """

    wanted: float
    row: FloatArray
    by_spin: float
    slope: State
    speed: float

    def solve(self, problem: FrictionProblem, state: State) -> tuple[FloatArray, float, str]:
        """Forces and the change of spin that make the wanted change of torque.

        Args:
            problem: contact and friction of the candidates.
            state: of the bodies without a change of spin.

        Returns:
            Forces, (n, gdim) [F]; change of the angular velocity [1/T]; what went wrong, or an empty text.
        """
        largest = float(np.linalg.norm(self.slope.slip, axis=1).max(initial=0.0))
        last, fault = state.forces, ""
        known: dict[float, float] = {}  # not computed twice: at a solution the sign is that of round-off

        def missing(change: float) -> float:
            nonlocal last, fault
            if change not in known:
                last, text = problem.solve(state.plus(change, self.slope), last)
                fault = fault or text
                torque = float(np.sum(self.row * (last - state.forces))) + self.by_spin * change
                known[change] = torque - self.wanted
            return known[change]

        here = missing(0.0)
        touching = np.any(last != 0.0, axis=1)
        if not touching.any() or largest == 0.0:
            return last, 0.0, NO_FRICTION
        # A larger spin slips more and takes more torque.
        low, high, step = 0.0, 0.0, FIRST * self.speed / largest
        sign = -1.0 if here > 0.0 else 1.0
        while not fault:
            high = sign * step
            if missing(high) * sign >= 0.0:
                break
            low, step = high, 4.0 * step
            if step > FARTHEST * self.speed / largest:
                return last, high, OUT_OF_REACH
        if fault:
            return last, 0.0, fault
        if here == 0.0:
            return last, 0.0, ""
        change = float(scipy.optimize.brentq(missing, low, high, xtol=1e-16 * self.speed / largest, rtol=1e-14))
        last, text = problem.solve(state.plus(change, self.slope), last)
        return last, change, fault or text
