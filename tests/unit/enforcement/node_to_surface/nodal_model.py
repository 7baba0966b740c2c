# SPDX-License-Identifier: MIT
"""Explicit contact of two bodies, or of one with an obstacle, step by step; on the ranks of a communicator."""

import numpy as np
from mpi4py import MPI
import partitioned_bodies

from dolfinx_impact import _cpp, compat


class Nodal:
    """A contact with nodal masses; arrays over the nodes of its Halo. `sides`: its directions, `contact`: the first."""

    def __init__(self, V, slave, master, dt=1e-3, mass=None, kinematic=False, balanced=False, **options):
        self.V, self.dim, self.dt, self.comm = V, V.mesh.geometry.dim, dt, V.mesh.comm
        self.map = V.dofmap.index_map
        self.num = self.map.size_local
        self.kinematic = kinematic
        if balanced:
            self.pair = _cpp.nodal.balanced_penalty(V._cpp_object, slave, master, **options)
        else:
            law = _cpp.nodal.KinematicContact if kinematic else _cpp.nodal.NodePenalty
            self.pair = _cpp.nodal.NodalPair([law(V._cpp_object, slave, master, **options)])
        self.sides = self.pair.directions
        self.contact = self.sides[0]
        x = V.tabulate_dof_coordinates()[: self.num]
        self.x = x[:, : self.dim].copy()
        # Masses that do not depend on numbering or ranks.
        self.mass_owned = 1.0 + 0.5 * np.sin(7 * x @ [1.0, 2.0, 3.0]) if mass is None else mass(x)
        self.halo = None

    def renumber(self, u):
        """Search, and a Halo with what the contact asks for; u: rows of owned nodes."""
        for side in self.sides:
            side.search(np.ascontiguousarray(u[: self.num]).reshape(-1), np.zeros(0))
        remote, first = np.unique(np.concatenate([side.remote_nodes for side in self.sides]), return_index=True)
        remote_owners = np.concatenate([side.remote_owners for side in self.sides])[first]
        ghosts = np.concatenate([self.map.ghosts, remote])
        owners = np.concatenate([self.map.owners, remote_owners]).astype(np.int32)
        self.index_map = compat.create_index_map(self.comm, self.num, ghosts, owners)
        self.halo = _cpp.operators.Halo(self.index_map)
        self.mass = self.spread(self.mass_owned[:, None]).reshape(-1)
        for side in self.sides:
            side.assign_numbers(self.halo, self.mass)
        self.inverse = np.repeat(1 / self.mass, self.dim)

    def spread(self, rows):
        """Rows of owned nodes to all nodes of the Halo."""
        out = np.zeros((self.halo.num_nodes, rows.shape[1]))
        out[: self.num] = rows[: self.num]
        self.halo.forward(out.reshape(-1), rows.shape[1])
        return out

    @property
    def slave_body(self):
        """Which owned nodes belong to the body that carries the slave surface."""
        if not hasattr(self, "_slave_body"):
            halo, cells = _cpp.operators.Halo(self.map), self.V.dofmap.list
            marked = np.zeros(halo.num_nodes)
            marked[self.contact.nodes] = 1.0
            while True:
                count = self.comm.allreduce(int(marked[: self.num].sum()))
                halo.forward(marked, 1)
                marked[cells[marked[cells].any(axis=1)].reshape(-1)] = 1.0
                halo.reverse(marked, 1)
                marked = np.minimum(marked, 1.0)
                if self.comm.allreduce(int(marked[: self.num].sum())) == count:
                    break
            self._slave_body = marked[: self.num] > 0
        return self._slave_body

    def again(self):
        """Is it time to search? Collective."""
        return self.comm.allreduce(self.used, MPI.MAX) >= 1.0

    def forces(self, u, du=None, search=True):
        """Complete forces on owned nodes."""
        if search or self.halo is None:
            self.renumber(u)
        u = self.spread(u)
        du = self.spread(np.zeros_like(u) if du is None else du)
        f = np.zeros(u.size)
        state = self.halo, u.reshape(-1), du.reshape(-1), self.inverse, self.dt
        for side in self.sides:
            side.add_forces(*state, f)
        self.halo.reverse(f, self.dim)
        self.used = max(side.increment_used(*state) for side in self.sides)
        return f.reshape(-1, self.dim)[: self.num]

    def correct(self, u, du, h=None, search=True):
        """Corrected displacements and forces of owned nodes."""
        if search or self.halo is None:
            self.renumber(u)
        u, du, f = self.spread(u), self.spread(du), np.zeros((self.halo.num_nodes, self.dim))
        self.used = self.contact.increment_used(self.halo, u.reshape(-1), du.reshape(-1), self.inverse, self.dt)
        h = self.dt**2 if h is None else h
        self.contact.correct(self.halo, u.reshape(-1), du.reshape(-1), self.inverse, h, self.dt, f.reshape(-1))
        return u[: self.num], f[: self.num]


def two_bodies(cell="hexahedron", degree=1, comm=MPI.COMM_SELF, seed=None, geometry_degree=1, dt=1e-3, **more):
    """Slave above the master, surfaces bent by a smooth map, with a small overlap."""
    dim = 2 if cell in ("triangle", "quadrilateral") else 3
    names = ("lower_cells", "upper_cells", "lower", "upper", "offset", "gap")
    parameters = {k: more.pop(k) for k in names if k in more}
    V, slave, master = partitioned_bodies.two_bodies(comm, dim, cell, geometry_degree, degree, seed, **parameters)
    return Nodal(V, slave, master, dt, **more)


def smooth(x, amplitude, phase=0.0):
    """Smooth displacements at the rows of x."""
    wave = [np.sin(4 * x[:, 0] + 3 * x[:, 1] + 2 * x[:, -1] + phase + 2 * c) for c in range(x.shape[1])]
    return amplitude * np.stack(wave, axis=1)


def moved_obstacle(cell="hexahedron", degree=1, kind="plane", comm=MPI.COMM_SELF, seed=None, dt=1e-3, **options):
    """The slave above a rigid plane at `height`, or a round obstacle whose top is a little higher."""
    dim = 2 if cell in ("triangle", "quadrilateral") else 3
    V, slave, _ = partitioned_bodies.two_bodies(comm, dim, cell, 1, degree, seed)
    up, point = np.eye(3)[dim - 1], np.append(np.full(dim, 0.5), np.zeros(3 - dim))
    height = 0.955
    point[dim - 1] = {"plane": height, "sphere": height - 0.77, "cylinder": height - 0.77}[kind]
    direction = up if kind == "plane" else np.array([0.6, 0.8, 0.0])
    obstacle = _cpp.gap.Rigid(kind, dim, point.tolist(), direction.tolist(), 0.0 if kind == "plane" else 0.8)
    model = Nodal(V, slave, obstacle, dt, **options)
    model.height, model.obstacle = height, (kind, point, direction)
    return model


class Driver:
    """Every node on a spring with a damper; the slave's body is pressed down, bounces and slides to and fro. Without
    the dampers, rounding errors grow by a factor of ten in 60 steps: every node bounces by itself."""

    def __init__(self, model, speed=0.3, stiffness=2000.0, load=60.0):
        self.model, self.dt, self.stiffness = model, model.dt, stiffness
        self.load = np.zeros_like(model.x)
        self.load[model.slave_body, -1] = -load
        self.u, self.v = np.zeros_like(model.x), smooth(model.x, 0.3 * speed)
        self.v[model.slave_body, -1] -= speed
        self.v[model.slave_body, 0] += 0.5 * speed
        self.contacts, self.first = 0, True

    def run(self, steps):
        m, dt, mass = self.model, self.dt, self.model.mass_owned[:, None]
        for _ in range(steps):
            f = self.load - self.stiffness * self.u - 10.0 * mass * self.v
            search = self.first or m.again()
            self.first = False
            if m.kinematic:
                v = self.v + dt * f / mass
                new, contact = m.correct(self.u + dt * v, dt * v, search=search)
                self.v = (new - self.u) / dt
                self.u = new
            else:
                f += m.forces(self.u, dt * self.v, search=search)
                self.v = self.v + dt * f / mass
                self.u = self.u + dt * self.v
            self.contacts += np.count_nonzero(m.contact.results()["status"])
