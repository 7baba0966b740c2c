# SPDX-License-Identifier: MIT
"""Rigid bodies that meet each other or obstacles, in explicit steps: docs/rigid_bodies.md, "Two rigid bodies"."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .array_types import FloatArray, floats
from .contact import RigidPlane, RigidSphere
from .rigid_body import RigidBody


class MeetingBody:
    """A rigid body in explicit steps.

    Args:
        body: what it is.
    """

    def __init__(self, body: RigidBody) -> None:
        self.body = body
        self.displacement: FloatArray = np.zeros(3)
        self.rotation: FloatArray = np.eye(3)
        self.before: tuple[FloatArray, FloatArray] = (self.displacement, self.rotation)
        self.momentum: FloatArray = body.mass * np.asarray(body.velocity, dtype=float)
        self.angular: FloatArray = body.inertia @ np.asarray(body.spin, dtype=float)
        self.forces: FloatArray = np.zeros(6)
        self.work = 0.0

    @property
    def centre(self) -> FloatArray:
        """Where the centre is, shape (3) [L]."""
        return self.body.centre() + self.displacement

    def at(self, X: FloatArray) -> FloatArray:
        """Where a point is that was at X at the start.

        Args:
            X: shape (3) [L].
        """
        return self.centre + self.rotation @ (X - self.body.centre())

    def moved(self, x: FloatArray) -> FloatArray:
        """How the point that is at x has moved in the last step, shape (3) [L].

        Args:
            x: shape (3) [L].
        """
        displacement, rotation = self.before
        X = self.body.centre() + self.rotation.T @ (x - self.centre)
        return x - (self.body.centre() + displacement + rotation @ (X - self.body.centre()))

    def mobility(self, arm: float) -> float:
        """Largest acceleration by a unit force at a distance from the centre.

        Args:
            arm: the distance [L].
        """
        return 1.0 / self.body.mass + arm**2 / float(np.linalg.eigvalsh(self.body.inertia)[0])

    def level(self, h: float) -> tuple[FloatArray, FloatArray]:
        """Velocity and spin at the time level, from the momenta half a step before.

        Args:
            h: half of the step before [T].
        """
        total = self.forces + self.body.loads
        L: FloatArray = self.angular + h * total[3:]
        return floats((self.momentum + h * total[:3]) / self.body.mass), self.body.spin_of(L, self.rotation)

    def kinetic(self, h: float, first: bool) -> float:
        """Kinetic energy of the momenta before and after the time level.

        Args:
            h: mean of the steps before and after it [T].
            first: nothing moved before.
        """
        total = self.forces + self.body.loads
        p, L = self.momentum, self.angular
        p1, L1 = p + h * total[:3], L + h * total[3:]
        if first:
            p, L = p - h * total[:3], L - h * total[3:]
        return float(p @ p1 / (2.0 * self.body.mass) + L @ self.body.spin_of(L1, self.rotation) / 2.0)

    def advance(self, dt: float, h: float) -> None:
        """Go on to the next time level.

        Args:
            dt: step [T].
            h: mean of the steps before and after the time level [T].
        """
        total = self.forces + self.body.loads
        self.momentum, self.angular = self.momentum + h * total[:3], self.angular + h * total[3:]
        self.before = self.displacement, self.rotation
        self.displacement = self.displacement + dt / self.body.mass * self.momentum
        self.rotation = self.body.turned(self.rotation, self.angular, dt)
        self.work += float(self.body.loads[:3] @ (self.displacement - self.before[0]))


@dataclass
class Meeting:
    """Springs between points of one body and the surface of another one, or of an obstacle.

    Args:
        slave: body with the points.
        points: of its surface at the start, shape (n, 3) [L].
        areas: that belong to the points, shape (n) [L^2].
        surface: of the master, at the start.
        master: body whose surface it is; None: it stays.
        radius: of the slave's surface around the points [L].
        friction: coefficient [1].
        stiffness: of all springs [F/L].
    """

    slave: MeetingBody
    points: FloatArray
    areas: FloatArray
    surface: RigidPlane | RigidSphere
    master: MeetingBody | None = None
    radius: float = 0.0
    friction: float = 0.0
    stiffness: float = 0.0
    stored: float = 0.0
    dissipated: float = 0.0
    shear: dict[int, FloatArray] = field(default_factory=dict)

    def stiffen(self, dt: float, part: float) -> None:
        """Take a part of the stiffness that a step bears.

        Args:
            dt: step [T].
            part: the part [1].
        """
        rubs = 1.0 if self.friction > 0.0 else 0.0
        arm = np.linalg.norm(self.points - self.slave.body.centre(), axis=1).max() + rubs * self.radius
        mobility = self.slave.mobility(float(arm))
        if self.master is not None:
            centre = self.master.body.centre()
            if isinstance(self.surface, RigidSphere):
                other = float(np.linalg.norm(np.asarray(self.surface.center) - centre)) + rubs * self.surface.radius
            else:
                other = float(np.linalg.norm(self.points - centre, axis=1).max()) + self.radius
            mobility += self.master.mobility(other)
        self.stiffness = part * 4.0 / (dt**2 * mobility)

    def gap(self, x: FloatArray) -> tuple[float, FloatArray]:
        """Gap of a point and normal out of the master.

        Args:
            x: the point, shape (3) [L].
        """
        back, turn = x, np.eye(3)
        if self.master is not None:
            turn = self.master.rotation
            back = self.master.body.centre() + turn.T @ (x - self.master.centre)
        if isinstance(self.surface, RigidPlane):
            n = np.asarray(self.surface.normal, dtype=float)
            n = n / np.linalg.norm(n)
            return float((back - np.asarray(self.surface.point)) @ n) - self.radius, turn @ n
        r = back - np.asarray(self.surface.center)
        distance = float(np.linalg.norm(r))
        return distance - self.surface.radius - self.radius, turn @ (r / distance)

    def evaluate(self) -> None:
        """Add the forces at the present places to those of both bodies."""
        self.stored = 0.0
        for i, X in enumerate(self.points):
            x = self.slave.at(np.asarray(X))
            g, n = self.gap(x)
            x = x - self.radius * n
            k = self.stiffness * self.areas[i] / self.areas.sum()
            along = self.slave.moved(x) - (0.0 if self.master is None else self.master.moved(x))
            along = along - (along @ n) * n
            before = self.shear.get(i, np.zeros(3))
            t_before = before - (before @ n) * n
            t = np.zeros(3)
            if g < 0.0 and self.friction > 0.0:
                t = t_before - k * along
                limit = -self.friction * k * g
                if np.linalg.norm(t) > limit:
                    t = limit / np.linalg.norm(t) * t
            # What the mean of the force before and now does along the slip, which is what the springs do not store.
            if self.friction > 0.0 and (g < 0.0 or i in self.shear):
                self.dissipated -= float((t + t_before) @ (along + (t - t_before) / k)) / 2.0
            if not g < 0.0:
                self.shear.pop(i, None)
                continue
            self.shear[i] = t
            f = -k * g * n + t
            self.stored += k * g**2 / 2.0 + float(t @ t) / (2.0 * k)
            for body, sign in ((self.slave, 1.0), (self.master, -1.0)):
                if body is not None:
                    body.forces += sign * np.concatenate([f, np.cross(x - body.centre, f)])


@dataclass
class MeetingRun:
    """What came out, at the time levels t_0 ... t_N; energies without the last level."""

    position: FloatArray  # of the centres (num_levels, num_bodies, 3) [L]
    rotation: FloatArray  # (num_levels, num_bodies, 3, 3) [1]
    velocity: FloatArray  # (num_levels, num_bodies, 3) [L/T]
    spin: FloatArray  # (num_levels, num_bodies, 3) [1/T]
    kinetic: FloatArray  # (num_levels - 1) [F L]
    stored: FloatArray  # in the springs, likewise
    dissipated: FloatArray  # by friction, likewise
    external: FloatArray  # work of the loads, likewise


def run(bodies: list[MeetingBody], meetings: list[Meeting], dt: float, num_steps: int) -> MeetingRun:
    """Equal steps of bodies that meet.

    Args:
        bodies: bodies at the start.
        meetings: their contacts.
        dt: step [T].
        num_steps: number of steps.
    """
    states, energies = [], []
    for n in range(num_steps + 1):
        for body in bodies:
            body.forces = np.zeros(6)
        for meeting in meetings:
            meeting.evaluate()
        half = 0.0 if n == 0 else dt / 2.0
        h = dt / 2.0 if n == 0 else dt
        states.append([(b.centre, b.rotation, *b.level(half)) for b in bodies])
        energies.append((
            sum(b.kinetic(h, n == 0) for b in bodies), sum(m.stored for m in meetings),
            sum(m.dissipated for m in meetings), sum(b.work for b in bodies),
        ))  # fmt: skip
        for body in bodies:
            body.advance(dt, h)
    fields = [np.array([[one[k] for one in level] for level in states]) for k in range(4)]
    return MeetingRun(*fields, *np.array(energies[:num_steps]).T)
