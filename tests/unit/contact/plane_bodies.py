# SPDX-License-Identifier: MIT
"""Rectangles that fly at each other, in one mesh: for edge cases of explicit contact."""

import basix.ufl
import numpy as np
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import compat

SIDES = ("bottom", "right", "top", "left")


class Bodies:
    """Rectangles meshed by quadrilaterals; the tag of a side of body b is 4 b + 1 + its place in SIDES.

    Args:
        rectangles: list of (low corner, high corner, cells along x and y, velocity), or with a turn about the lower
            left corner as a fifth entry [rad]. E: one number, density 1.
    """

    def __init__(self, *rectangles, E=1e3, nu=0.0, law=di.NeoHookean):
        points, cells, sides, self.bodies = [], [], [], []
        first = 0
        for low, high, (nx, ny), velocity, *turn in rectangles:
            x, y = np.meshgrid(np.linspace(low[0], high[0], nx + 1), np.linspace(low[1], high[1], ny + 1))
            p = np.column_stack([x.ravel(), y.ravel()]) - low
            c, s = (np.cos(turn[0]), np.sin(turn[0])) if turn else (1.0, 0.0)
            points.append(p @ np.array([[c, s], [-s, c]]) + low)
            n = np.arange(len(p)).reshape(ny + 1, nx + 1) + first
            cells.append(np.stack([n[:-1, :-1], n[:-1, 1:], n[1:, :-1], n[1:, 1:]], axis=-1).reshape(-1, 4))
            sides += [n[0], n[:, -1], n[-1], n[:, 0]]
            self.bodies.append((n.ravel(), velocity))
            first += len(p)
        element = basix.ufl.element("Lagrange", "quadrilateral", 1, shape=(2,))
        points = np.vstack(points)
        m = mesh.create_mesh(MPI.COMM_SELF, np.vstack(cells).astype(np.int64), x=points, e=ufl.Mesh(element))
        self.mesh, self.V = m, fem.functionspace(m, ("Lagrange", 1, (2,)))
        m.topology.create_connectivity(1, 2)
        facets = mesh.exterior_facet_indices(m.topology)
        ends = m.geometry.input_global_indices[mesh.entities_to_geometry(m, 1, facets)]
        values = np.zeros(len(facets), dtype=np.int32)
        for tag, nodes in enumerate(sides, 1):
            values[np.all(np.isin(ends, nodes), axis=1)] = tag
        assert np.all(values > 0)
        self.tags = mesh.meshtags(m, 1, facets, values)
        self.X = self.V.tabulate_dof_coordinates()[:, :2]
        number = np.empty(len(points), dtype=int)
        cell_nodes = m.geometry.input_global_indices[compat.geometry_dofmap(m)]
        number[cell_nodes.ravel()] = self.V.dofmap.list.ravel()
        self.bodies = [(number[nodes], v) for nodes, v in self.bodies]
        self.velocity = fem.Function(self.V)
        for nodes, v in self.bodies:
            self.velocity.x.array.reshape(-1, 2)[nodes] = v
        self.law = law(E, nu, 1.0, "plane_strain")

    def pair(self, slave, master, **options):
        """Surfaces as (body, name of a side, ...); the master may be an obstacle."""
        values, made = self.tags.values.copy(), []
        for surface in (slave, master):
            if isinstance(surface, tuple):
                body, *names = surface
                own = [4 * body + 1 + SIDES.index(name) for name in names]
                values[np.isin(values, own)] = own[0]
                surface = own[0]
            made.append(surface)
        return di.ContactPair(mesh.meshtags(self.mesh, 1, self.tags.indices, values), *made, **options)

    def problem(self, *contacts, held=(), **options):
        """ExplicitProblem; `held` bodies do not move at all."""
        bcs = [fem.dirichletbc(np.zeros(2), self.bodies[b][0].astype(np.int32), self.V) for b in held]
        return di.ExplicitProblem(
            fem.Function(self.V), self.law, velocity=self.velocity, bcs=bcs, contact=list(contacts), **options
        )

    def mean_velocity(self, problem, body):
        nodes = self.bodies[body][0]
        m = problem.mass.array.reshape(-1, 2)[nodes]
        return (m * problem.velocity.x.array.reshape(-1, 2)[nodes]).sum(axis=0) / m.sum(axis=0)

    def places(self, problem, body):
        return (self.X + problem.u.x.array.reshape(-1, 2))[self.bodies[body][0]]


def total_energy(problem):
    """Total energy before every step less that at the start, over the largest kinetic energy."""
    rows = problem.energy_history[:, 1:]
    total = rows[:, :-1].sum(axis=1) - rows[:, -1]
    return (total - total[0]) / rows[:, 0].max()
