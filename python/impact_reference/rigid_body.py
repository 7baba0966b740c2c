# SPDX-License-Identifier: MIT
"""A rigid body as docs/rigid_bodies.md states it: what it is, how it turns freely, and equilibrium with contact."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from .array_types import ArrayLike, FloatArray, IntArray, floats
from .contact import Contact, ContactSolution, Obstacle
from .rotation import angle_of, matrix_of


def _three(values: ArrayLike) -> FloatArray:
    given = floats(values).ravel()
    return np.pad(given, (0, 3 - len(given)))


@dataclass
class RigidBody:
    """A rigid body that contact and constant loads move; the obstacle is its surface, which it displaces and turns.

    Args:
        obstacle: its surface; the pivot is the centre of mass.
        mass: mass [M].
        inertia: tensor of inertia about the centre at the start, shape (3, 3) [M L^2].
        velocity: velocity of the centre at the start, shape (gdim) [L/T].
        spin: angular velocity at the start, shape (3) [1/T].
        force: external force, shape (gdim) [F].
        torque: external torque about the centre, shape (3) [F L].
        free: components that move, of x, y, z, rx, ry, rz in this order.
    """

    obstacle: Obstacle
    mass: float = 1.0
    inertia: FloatArray = field(default_factory=lambda: np.eye(3))
    velocity: ArrayLike = (0.0, 0.0, 0.0)
    spin: ArrayLike = (0.0, 0.0, 0.0)
    force: ArrayLike = (0.0, 0.0, 0.0)
    torque: ArrayLike = (0.0, 0.0, 0.0)
    free: tuple[int, ...] = (0, 1, 2, 3, 4, 5)

    @property
    def loads(self) -> FloatArray:
        """External force and torque, shape (6)."""
        return np.concatenate([_three(self.force), _three(self.torque)])

    def centre(self) -> FloatArray:
        """Centre of mass before the displacement, shape (3) [L]."""
        assert self.obstacle.pivot is not None
        return _three(self.obstacle.pivot)

    def spin_of(self, momentum: FloatArray, rotation: FloatArray) -> FloatArray:
        """Angular velocity, shape (3) [1/T].

        Args:
            momentum: angular momentum, shape (3) [M L^2/T].
            rotation: since the start, shape (3, 3) [1].
        """
        out: FloatArray = np.zeros(3)
        free = [c - 3 for c in self.free if c > 2]
        J = rotation @ self.inertia @ rotation.T
        if free:
            out[free] = np.linalg.solve(J[np.ix_(free, free)], momentum[free])
        return out

    def turned(self, rotation: FloatArray, momentum: FloatArray, dt: float) -> FloatArray:
        """Rotation after a free motion, shape (3, 3) [1].

        Args:
            rotation: before, shape (3, 3) [1].
            momentum: angular momentum, shape (3) [M L^2/T].
            dt: time [T].

        Raises:
            ValueError: some rotations are fixed, and not about one axis of inertia alone.
        """
        free = [c - 3 for c in self.free if c > 2]
        if not free:
            return rotation
        if len(free) == 1:
            axis = np.eye(3)[free[0]]
            if np.abs(np.cross(self.inertia @ axis, axis)).max() > 1e-14 * np.abs(self.inertia).max():
                raise ValueError("a body turns about one axis of inertia, or freely")
            return matrix_of(dt * momentum[free[0]] / (axis @ self.inertia @ axis) * axis) @ rotation
        if len(free) != 3:
            raise ValueError("a body turns about one axis of inertia, or freely")
        moments, axes = np.linalg.eigh(self.inertia)
        # The two axes whose mobilities differ least come first.
        if 1.0 / moments[0] - 1.0 / moments[1] > 1.0 / moments[1] - 1.0 / moments[2]:
            moments, axes = moments[[1, 2, 0]], axes[:, [1, 2, 0]]
        more = 1.0 / moments - 1.0 / moments[0]

        def about(k: int, R: FloatArray, part: float) -> FloatArray:
            e: FloatArray = axes[:, k]
            turn: FloatArray = R @ matrix_of(part * dt * more[k] * (R @ e) @ momentum * e)
            return turn

        R = about(1, rotation, 0.5)
        R = matrix_of(dt / moments[0] * momentum) @ about(2, R, 1.0)
        return about(1, R, 0.5)


def forces_on(contact: Contact, force: FloatArray, u: FloatArray, centre: FloatArray) -> FloatArray:
    """Contact force on a rigid master and its torque about a point, shape (6) [F], [F L].

    Args:
        contact: contact of the slave with the master.
        force: nodal contact force, shape (num_dofs) [F].
        u: displacements, shape (num_dofs) [L].
        centre: the point, shape (3) [L].
    """
    gdim = contact.gdim
    f = np.pad(force.reshape(-1, gdim), ((0, 0), (0, 3 - gdim)))
    x = np.pad(contact.model.field_points + u.reshape(-1, gdim), ((0, 0), (0, 3 - gdim)))
    return -np.concatenate([f.sum(axis=0), np.cross(x - centre, f).sum(axis=0)])


def find_root(
    missing: Callable[[FloatArray], tuple[FloatArray, float]], start: FloatArray, way: float, tolerance: float
) -> FloatArray:
    """Newton's method with differences over small motions: a root of a few equations.

    Args:
        missing: function of the unknowns that gives what the equations lack, and a size of it.
        start: where it begins, shape (n).
        way: length of the differences.
        tolerance: bound on what is lacking over its size.

    Raises:
        RuntimeError: it does not converge.
    """
    q = start.copy()
    for _ in range(40):
        now, size = missing(q)
        if np.linalg.norm(now) <= tolerance * size:
            return q
        columns = [(missing(q + way * e)[0] - now) / way for e in np.eye(len(q))]
        q = q - np.linalg.solve(np.array(columns).T, now)
    raise RuntimeError("the rigid body found no equilibrium")


def solve_static(
    contact: Contact,
    body: RigidBody,
    solve: Callable[[ContactSolution | None], ContactSolution],
    start: ContactSolution | None = None,
    guess: ArrayLike = 0.0,
    tolerance: float = 1e-11,
) -> ContactSolution:
    """Static equilibrium of a rigid body and the deformable ones: one increment of history.

    Args:
        contact: contact whose master is the body's surface.
        body: the body; its surface stays where it is found.
        solve: function that solves the deformable bodies from a solution, with the obstacle held.
        start: solution that the increment begins with, the obstacle where it was.
        guess: unknowns to begin with, displacement [L] and rotation vector [1] of the free components.
        tolerance: bound on what is lacking over the largest force.

    Returns:
        Solution of the deformable bodies.

    Raises:
        RuntimeError: the body or the deformable ones find no equilibrium.
    """
    obstacle, free = body.obstacle, list(body.free)
    gdim = contact.gdim
    before = np.broadcast_to(floats(obstacle.displacement), (gdim,)).copy()
    turned = matrix_of(_three(obstacle.angle))
    found: list[ContactSolution] = []

    def missing(q: FloatArray) -> tuple[FloatArray, float]:
        all_six = np.zeros(6)
        all_six[free] = q
        obstacle.displacement = before + all_six[:gdim]
        obstacle.angle = angle_of(matrix_of(all_six[3:]) @ turned)
        solution = solve(start)
        found[:] = [solution]
        centre = body.centre() + _three(obstacle.displacement)
        forces = forces_on(contact, solution.contact_force, solution.u, centre)
        return (body.loads + forces)[free], float(np.abs(forces[free]).max())

    first: FloatArray = np.broadcast_to(floats(guess), (len(free),)).copy()
    find_root(missing, first, 1e-6, tolerance)
    return found[0]


@dataclass
class RigidState:
    """A rigid body at one time level of an implicit run."""

    displacement: FloatArray  # of the centre (3) [L]
    rotation: FloatArray  # since the start (3, 3) [1]
    rate: FloatArray  # velocity and angular momentum (6)
    change: FloatArray  # acceleration and torque (6)
    mean: FloatArray  # their means of the scheme (6)
    forces: FloatArray  # of contact, force and torque (6)
    spin: FloatArray  # angular velocity (3) [1/T]
    kinetic: float  # energy [F L]
    work: float  # of the loads so far [F L]


class MovingBody:
    """A rigid body in implicit steps, in the scheme of the nodes: its angular momentum is a velocity of the scheme.

    Args:
        body: the body.
        gdim: dimension of space.
        scheme: parameters of a NewmarkScheme.
    """

    def __init__(self, body: RigidBody, gdim: int, scheme: object) -> None:
        self.body, self.scheme = body, scheme
        in_plane = (0, 1, 5) if gdim == 2 else (0, 1, 2, 3, 4, 5)
        body.free = tuple(c for c in body.free if c in in_plane)
        self.free: IntArray = np.array(body.free, dtype=np.int64)
        self.inertia: FloatArray = np.where(np.arange(6) < 3, body.mass, 1.0)

    def _state(
        self, displacement: FloatArray, rotation: FloatArray, rate: FloatArray, change: FloatArray, mean: FloatArray,
        forces: FloatArray, work: float,
    ) -> RigidState:  # fmt: skip
        spin = self.body.spin_of(rate[3:], rotation)
        kinetic = self.body.mass * rate[:3] @ rate[:3] / 2.0 + rate[3:] @ spin / 2.0
        return RigidState(displacement, rotation, rate, change, mean, forces, spin, float(kinetic), work)

    def start(self, forces: FloatArray) -> RigidState:
        """State at the start.

        Args:
            forces: of contact, force and torque on the body, shape (6).
        """
        body = self.body
        rate = np.concatenate([_three(body.velocity), floats(body.inertia) @ _three(body.spin)])
        change: FloatArray = np.zeros(6)
        change[self.free] = ((body.loads + forces) / self.inertia)[self.free]
        return self._state(np.zeros(3), np.eye(3), rate, change, change.copy(), forces, 0.0)

    def end(self, old: RigidState, h: float, q: FloatArray, forces: FloatArray) -> RigidState:
        """State at the end of a step.

        Args:
            old: state at its start.
            h: step [T].
            q: increments of displacement and integral of the angular momentum, of the free components.
            forces: of contact at the end, force and torque on the body, shape (6).
        """
        s = self.scheme
        way = h * old.rate
        way[self.free] = q
        mean = np.zeros(6)
        change, rate = np.zeros(6), old.rate.copy()
        k = self.free
        A = (way - h * old.rate) / (s.beta * h**2) - (0.5 - s.beta) / s.beta * old.mean  # type: ignore[attr-defined]
        mean[k] = A[k]
        a = (1 - s.alpha_m) * A + s.alpha_m * old.mean - s.alpha_f * old.change  # type: ignore[attr-defined]
        change[k] = a[k] / (1 - s.alpha_f)  # type: ignore[attr-defined]
        rate[k] += h * ((1 - s.gamma) * old.mean + s.gamma * mean)[k]  # type: ignore[attr-defined]
        rotation = self.body.turned(old.rotation, floats(way[3:] / h), h)
        turned = angle_of(rotation @ old.rotation.T)
        work = old.work + float(self.body.loads @ np.concatenate([way[:3], turned]))
        return self._state(old.displacement + way[:3], rotation, rate, change, mean, forces, work)

    def lacks(self, state: RigidState) -> tuple[FloatArray, float]:
        """What the equations of motion lack at the end of a step, and its size.

        Args:
            state: of `end`.
        """
        inertia, loads = self.inertia * state.change, self.body.loads
        size = max(float(np.abs(v[self.free]).max()) for v in (inertia, loads, state.forces))
        return (inertia - loads - state.forces)[self.free], size if size > 0.0 else 1.0
