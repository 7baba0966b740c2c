# SPDX-License-Identifier: MIT
"""Penalty contact of a pair as functions of the displacements, for tests; on the ranks of a communicator."""

import pathlib
import sys

import basix
import numpy as np
from mpi4py import MPI

from dolfinx_impact import _cpp

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "search"))
import partitioned_bodies  # noqa: E402

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
    """A pair of deformable bodies; `master` facets come through Exchange."""

    def __init__(
        self, cell, geometry_degree, degree, comm=MPI.COMM_SELF, friction=0.0, seed=None, quadrature=4, **parameters
    ):
        dim = 2 if cell in ("triangle", "quadrilateral") else 3
        self.V, slave, master = partitioned_bodies.two_bodies(
            comm, dim, cell, geometry_degree, degree, seed, **parameters
        )
        self.dim, self.friction, self.reach = dim, friction, 0.5
        self.num = self.V.dofmap.index_map.size_local * dim
        self.exchange = _cpp.search.Exchange(self.V._cpp_object, slave, master, self.reach)
        self.slave, self.master = self.exchange.slave, self.exchange.master
        self.search = _cpp.search.SurfaceSearch(self.master)
        self.points = _cpp.penalty.Points(self.slave, *rule(cell, quadrature))
        self.history = _cpp.penalty.PenaltyHistory(self.points)
        self.u_n = np.zeros(self.V.dofmap.index_map.size_local * dim)
        self.penalty = _cpp.penalty.Penalty(
            self.points, self.slave, self.master, self.history, CHI, 0.7 * CHI, self.friction
        )
        self.nodes = self.exchange.map.local_to_global(np.arange(self.exchange.size // dim, dtype=np.int32))

    def state(self, u):
        self.exchange.move(u)
        self.search.update()
        self.points.update(self.slave, self.search, self.reach)
        self.penalty.set_increment(self.exchange.forward(u[: self.num] - self.u_n))
        return self.penalty.evaluate()

    def energy(self, u):
        return self.penalty.energy(self.state(u))

    def force(self, u):
        """Entries of the owned nodes."""
        values, out = np.zeros(self.exchange.size), np.zeros(self.num)
        self.penalty.add_force(self.state(u), values)
        self.exchange.reverse(values, out)
        return out

    def tangent(self, u):
        return self.penalty.tangent(self.state(u), self.nodes)

    def kinks(self, u):
        """What must not change between two states for the force to be smooth."""
        state, p = self.state(u), self.points
        return np.concatenate([state.status, p.status, p.master])


class Rigid(Deformable):
    """The slave against a rigid obstacle; nodes are those of V itself."""

    def __init__(self, cell, degree, kind, friction=0.0):
        dim = 2 if cell in ("triangle", "quadrilateral") else 3
        self.V, self.slave, _ = partitioned_bodies.two_bodies(MPI.COMM_SELF, dim, cell, degree, degree)
        self.dim, self.friction = dim, friction
        self.num = self.V.dofmap.index_map.size_local * dim
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
        self.points = _cpp.penalty.Points(self.slave, *rule(cell))
        self.history = _cpp.penalty.PenaltyHistory(self.points)
        self.u_n = np.zeros(self.num)
        self.penalty = _cpp.penalty.Penalty(self.points, self.slave, None, self.history, CHI, 0.7 * CHI, friction)
        self.nodes = np.arange(self.num // dim)

    def state(self, u):
        self.slave.move(u)
        self.points.update_rigid(self.slave, self.obstacle)
        self.penalty.set_increment(u - self.u_n, [0.01, -0.02, 0.03])
        return self.penalty.evaluate()

    def force(self, u):
        out = np.zeros(self.num)
        self.penalty.add_force(self.state(u), out)
        return out


def remember(model, rng, pressure=0.0):
    """A history: tractions, multipliers (so that open points are in contact, too), gaps (two thirds of the points
    were open, some of them without master) and an old displacement."""
    num, dim = model.points.size, model.dim
    model.history.traction = rng.uniform(-0.3, 0.3, size=num * dim)
    model.history.multiplier = np.full(num, pressure)
    model.history.gap = rng.permutation(np.resize([-0.01, 0.02, 0.05, 0.01, np.inf, 0.0], num))
    model.u_n = smooth(model.V, 0.02, 1.0)[: model.num]


def dense(model, u):
    rows, cols, values = model.tangent(u)
    K = np.zeros((model.num, model.num))
    np.add.at(K, (rows, cols), values)
    return K
