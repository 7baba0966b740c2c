# SPDX-License-Identifier: MIT
"""Bodies that roll, for the tests of the hand-written solver."""

import impact_reference as ir
import numpy as np
from reference_meshes import box, dofs, facets_where

RADIUS = 1.0


def disc(cell, n, layers=0, width=1.0):
    """Points and cells of a disc of radius 1 about the origin, or of a cylinder about the y axis of some layers."""
    counts = (n, n) if layers == 0 else (n, layers, n)
    points, cells = box(cell, counts)
    plane = [0, 1] if layers == 0 else [0, 2]
    x = 2.0 * points[:, plane] - 1.0
    longest, length = np.abs(x).max(axis=1), np.linalg.norm(x, axis=1)
    points = points.copy()
    points[:, plane] = RADIUS * x * np.divide(longest, length, out=np.ones_like(length), where=length > 0)[:, None]
    if layers:
        points[:, 1] *= width
    return points, cells


class Wheel:
    """A wheel with a rigid hub on a rigid plane.

    Its hub does not move and the plane is displaced into the tread at the bottom. Spin by the right-hand rule about z
    (plane) or -y (space), so that the flow at the bottom is along x.
    """

    def __init__(self, cell, n=24, friction=0.3, depth=0.01, omega=0.1, layers=0, width=1.0, law="linear_elastic",
                 held=False):  # fmt: skip
        self.points, cells = disc(cell, n, layers, width)
        self.gdim = self.points.shape[1]
        up = np.eye(self.gdim)[-1]
        hypothesis = "plane_strain" if self.gdim == 2 else "3d"
        material = ir.Material(1.0, 0.3, 1.0, hypothesis, law)
        # In the plane and in space the same rule, which is not exact on cells that are not affine.
        self.model = ir.Model(self.points, cells, cell, material, rule="gauss_jacobi:5")
        radius = np.hypot(self.points[:, 0], self.points[:, -1])
        hub = np.flatnonzero(radius < 0.2)
        self.fixed = dofs(hub, range(self.gdim), self.gdim)
        if held:  # plane strain in space
            self.fixed = np.union1d(self.fixed, 3 * np.arange(len(self.points)) + 1)
        tread = facets_where(self.points, cells, cell, lambda x: x[-1] < -0.8 and np.hypot(x[0], x[-1]) > 0.999)
        self.tread = np.unique(tread)
        self.plane = ir.RigidPlane(-RADIUS * up, up, depth * up)
        self.contact = ir.Contact(self.model, tread, self.plane, friction, prescribed=self.fixed if held else ())
        axis = (0.0, 0.0, 1.0) if self.gdim == 2 else (0.0, -1.0, 0.0)
        self.spin = ir.Spinning(np.zeros(self.gdim), omega, axis)
        self.rolling = ir.RollingModel(self.model, {1: self.spin})

    def solve(self, creep, lateral=0.0, **options):
        """Steady state; the plane moves by (1 - creep) times the speed of the undeformed tread."""
        speed = self.spin.omega * RADIUS
        velocity = np.zeros(self.gdim)
        velocity[0] = speed * (1.0 - creep)
        if self.gdim == 3:
            velocity[1] = -speed * lateral
        return self.rolling.solve(self.fixed, contact=self.contact, master_velocity=velocity, **options)


def _graded(n, a, half):
    """Coordinates: n cells over three half-widths a, growing cells out to `half`."""
    inner = np.linspace(-1.5 * a, 1.5 * a, n + 1)
    outer, step = [inner[-1]], 3 * a / n
    while outer[-1] < half:
        step *= 1.25
        outer.append(outer[-1] + step)
    outer = np.array(outer[1:])
    outer[-1] = half
    return np.concatenate([-outer[::-1], inner, outer])


class Carter:
    """Two blocks of one material, the upper one with a round lower face, through which the material flows straight.

    It is the line contact of cylinders of which only the part about the contact is meshed. The half-width is about 1.
    """

    def __init__(self, n, creep, friction=0.3, forward=True, radius=100.0, half=12.0):
        x, nu, E = _graded(n, 1.0, half), 0.3, 1.0
        y = np.concatenate([[0.0], np.cumsum(3.0 / n * 1.25 ** np.arange(40))])
        y = y[: np.searchsorted(y, half) + 1]
        parts = []
        for up in (True, False):
            X, Y = np.meshgrid(x, y if up else -y[::-1], indexing="ij")
            number = np.arange(X.size).reshape(X.shape)
            corners = (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
            parts.append((np.column_stack([X.ravel(), Y.ravel()]), np.stack(corners, axis=-1).reshape(-1, 4)))
        (upper, cells), (lower, below) = parts
        upper[:, 0] += 0.37 * 3.0 / n  # no nodes opposite each other
        upper[:, 1] += upper[:, 0] ** 2 / (2 * radius) * (1 - upper[:, 1] / y[-1])
        points = np.vstack([upper, lower])
        tags = np.repeat([1, 2], [len(cells), len(below)])
        all_cells = np.vstack([cells, below + len(upper)])
        self.model = ir.Model(points, all_cells, "quadrilateral", ir.Material(E, nu, 1e-9, "plane_strain"))
        bottom = np.arange(0, len(upper), len(y))
        top = len(upper) + np.arange(len(y) - 1, len(lower), len(y))
        faces = [np.column_stack([row[:-1], row[1:]]) for row in (bottom, top)]
        slave, master = (f[np.abs(points[f, 0]).max(axis=1) < w] for f, w in zip(faces, (3.0, 3.5)))
        self.points, self.slave = points, np.unique(slave)
        self.contact = ir.Contact(self.model, slave, master, friction)
        self.moved, clamped = bottom + len(y) - 1, top - len(y) + 1
        self.fixed = dofs(np.concatenate([self.moved, clamped]), (0, 1), 2)
        self.friction, self.radius, self.stiffness = friction, radius, E / (2 * (1 - nu**2))
        self.rigid_creep = creep * friction / radius  # of mu a / R at a = 1
        direction = 1.0 if forward else -1.0
        motions = {1: ir.Translating((direction * (1 + self.rigid_creep), 0.0)), 2: ir.Translating((direction, 0.0))}
        self.rolling = ir.RollingModel(self.model, motions, tags)

    def solve(self, depth=0.0262):
        """Solution with the upper block pressed down; (solution, normal force, tangential force, half-width)."""
        values = np.zeros(len(self.fixed))
        values[1 : 2 * len(self.moved) : 2] = -depth
        solution = self.rolling.solve(self.fixed, values, contact=self.contact)
        force = solution.contact_force.reshape(-1, 2)[self.slave].sum(axis=0)
        half_width = np.sqrt(4 * force[1] * self.radius / (np.pi * self.stiffness))
        return solution, force[1], force[0], half_width
