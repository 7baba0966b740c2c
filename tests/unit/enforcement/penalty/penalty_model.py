# SPDX-License-Identifier: MIT
"""Penalty contact of a pair as functions of the displacements, for tests; on the ranks of a communicator."""

import basix
import numpy as np
from mpi4py import MPI
import partitioned_bodies

from dolfinx_impact import _cpp


FACETS = {
    "triangle": basix.CellType.interval,
    "quadrilateral": basix.CellType.interval,
    "tetrahedron": basix.CellType.triangle,
    "hexahedron": basix.CellType.quadrilateral,
}
CHI = 50.0  # penalty; pressures of order one at penetrations of a few percent


def rule(cell, degree=4):
    return basix.make_quadrature(FACETS[cell], degree)


def smooth(V, amplitude, phase=0.0, comm=None):
    """Nodal values of a smooth displacement in V."""
    from dolfinx import fem

    u, dim = fem.Function(V), V.mesh.geometry.dim
    wave = lambda x: [np.sin(4 * x[0] + 3 * x[1] + 2 * x[2] + phase + 2 * c) for c in range(dim)]  # noqa: E731
    u.interpolate(lambda x: amplitude * np.array(wave(x)))
    return u.x.array.copy()


class Deformable:
    """A pair of deformable bodies: PenaltyForces as functions of the displacements (owned and ghost dofs)."""

    rigid_increment = (0.0, 0.0, 0.0)

    def __init__(
        self,
        cell,
        geometry_degree,
        degree,
        comm=MPI.COMM_SELF,
        friction=0.0,
        seed=None,
        quadrature=4,
        reach=0.5,
        **parameters,
    ):
        dim = 2 if cell in ("triangle", "quadrilateral") else 3
        self.V, slave, master = partitioned_bodies.two_bodies(
            comm, dim, cell, geometry_degree, degree, seed, **parameters
        )
        self._set(dim, friction, self.V, slave, master, *rule(cell, quadrature), False, reach)

    def _set(self, dim, friction, V, *arguments):
        self.dim, self.friction = dim, friction
        self.penalty = _cpp.penalty.PenaltyForces(V._cpp_object, *arguments)
        given = self.penalty.parameters
        given.normal, given.tangential, given.friction = CHI, 0.7 * CHI, friction
        self.points, self.history = self.penalty.points, self.penalty.history
        index_map = V.dofmap.index_map
        self.num = index_map.size_local * dim
        self.u_n = np.zeros((index_map.size_local + index_map.num_ghosts) * dim)

    @property
    def slave(self):
        return self.penalty.search.slave

    @property
    def master(self):
        return self.penalty.search.master

    def state(self, u):
        self.penalty.update_gap(u, u, False)
        self.penalty.evaluate(u - self.u_n, self.rigid_increment)
        return self.penalty.state

    def energy(self, u):
        self.state(u)
        return self.penalty.energy()

    def force(self, u):
        """Entries of the owned nodes."""
        self.state(u)
        return self.penalty.contact_forces()

    def tangent(self, u, convex=False):
        """Rows of the owned nodes: rows, columns (global numbers) and values."""
        self.state(u)
        K = self.penalty.tangent(convex)
        pointers, columns, values = K.getValuesCSR()
        return K.getOwnershipRange()[0] + np.repeat(np.arange(self.num), np.diff(pointers)), columns, values

    def kinks(self, u):
        """What must not change between two states for the force to be smooth."""
        state, p = self.state(u), self.points
        return np.concatenate([state.status, p.status, p.master])


class Rigid(Deformable):
    """The slave against a rigid obstacle."""

    rigid_increment = (0.01, -0.02, 0.03)

    def __init__(self, cell, degree, kind, friction=0.0):
        dim = 2 if cell in ("triangle", "quadrilateral") else 3
        self.V, slave, _ = partitioned_bodies.two_bodies(MPI.COMM_SELF, dim, cell, degree, degree)
        up, middle = np.eye(3)[dim - 1], np.append(np.full(dim, 0.5), np.zeros(3 - dim))
        axis = np.array([0.6, 0.8, 0.0]) if dim == 3 else np.eye(3)[2]
        point, direction, radius = {
            "plane": (middle + 0.53 * up, up, 0.0),
            "sphere": (middle - 0.2 * up, up, 0.8),
            "cylinder": (middle - 0.3 * up, axis, 0.9),
            "bore": (middle + 1.0 * up, axis, -0.55),
        }[kind]
        name = {"bore": "cylinder"}.get(kind, kind)
        self.obstacle = _cpp.gap.Rigid(name, dim, point.tolist(), direction.tolist(), radius)
        self._set(dim, friction, self.V, slave, self.obstacle, *rule(cell))


def remember(model, rng, pressure=0.0):
    """A history: tractions, multipliers (so that open points are in contact, too), gaps (two thirds of the points
    were open, some of them without master) and an old displacement."""
    num, dim = model.points.size, model.dim
    model.history.traction = rng.uniform(-0.3, 0.3, size=num * dim)
    model.history.multiplier = np.full(num, pressure)
    model.history.gap = rng.permutation(np.resize([-0.01, 0.02, 0.05, 0.01, np.inf, 0.0], num))
    model.u_n = smooth(model.V, 0.02, 1.0)


def dense(model, u, convex=False):
    rows, cols, values = model.tangent(u, convex)
    K = np.zeros((model.num, model.num))
    np.add.at(K, (rows, cols), values)
    return K
