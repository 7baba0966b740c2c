# SPDX-License-Identifier: MIT
"""Contact with smooth surfaces: wheels of few facets. See on_ranks.py."""

import functools

import basix.ufl
import numpy as np
import ufl
from dolfinx import fem, mesh
from explicit_contact_checks import momenta
from mpi4py import MPI

import dolfinx_impact as di

COMM = MPI.COMM_WORLD
# Penetration [m]; facets around the wheel of radius 1 m, 7.5 degrees each; its width in 3D [m].
DEPTH, FACETS, WIDTH = 0.01, 48, 0.1
WHEEL, RAIL = 1, 2


class WheelOnRail:
    """A ring of radius 1 with few facets over a rail with many, whose top is at 0. Collective.

    Args:
        dim: 2 or 3.
        depth: of the wheel in the rail [m].
        cells: of the rail, along it.
        facets: around the wheel.
    """

    def __init__(self, dim, depth=DEPTH, cells=70, comm=COMM, facets=FACETS):
        self.dim, axle = dim, 1.0 - depth
        angles, radii = np.linspace(0.0, 2.0 * np.pi, facets + 1), np.array([0.8, 1.0])
        across = np.linspace(0.0, WIDTH, 2) if dim == 3 else np.zeros(1)
        a, y, r = np.meshgrid(angles, across, radii, indexing="ij")
        ring = np.stack([r * np.sin(a), y, axle - r * np.cos(a)], axis=-1)
        x, y, z = np.meshgrid(np.linspace(-0.3, 0.4, cells + 1), across, [-0.05, 0.0], indexing="ij")
        bar = np.stack([x, y, z], axis=-1)
        around = np.arange(ring.size // 3).reshape(ring.shape[:3])
        around[-1] = around[0]
        along = np.arange(bar.size // 3).reshape(bar.shape[:3]) + ring.size // 3
        kept = np.concatenate([np.arange(ring.size // 3 - ring[0].size // 3), along.ravel()])
        number = np.zeros(along.max() + 1, dtype=np.int64)
        number[kept] = np.arange(len(kept))
        axes = [0, 2] if dim == 2 else [0, 1, 2]
        points = np.vstack([ring.reshape(-1, 3), bar.reshape(-1, 3)])[kept][:, axes]
        cells_of = [number[self._cells(n)] for n in (around, along)]
        own = slice(None) if comm.rank == 0 else slice(0, 0)
        element = basix.ufl.element("Lagrange", "quadrilateral" if dim == 2 else "hexahedron", 1, shape=(dim,))
        self.mesh = m = mesh.create_mesh(comm, np.vstack(cells_of)[own], x=points[own], e=ufl.Mesh(element))
        self.V = fem.functionspace(m, ("Lagrange", 1, (dim,)))
        m.topology.create_connectivity(dim - 1, dim)
        m.topology.create_connectivity(dim, dim - 1)
        facets = mesh.exterior_facet_indices(m.topology)
        cell_of = m.topology.connectivity(dim - 1, dim).array[m.topology.connectivity(dim - 1, dim).offsets[facets]]
        is_wheel = m.topology.original_cell_index < len(cells_of[0])
        # DOLFINx divides by the number of facets.
        nodes = mesh.entities_to_geometry(m, dim - 1, facets) if len(facets) else np.zeros((0, dim), dtype=np.int32)
        x = m.geometry.x[nodes]
        tread = np.all(np.hypot(x[:, :, 0], x[:, :, dim - 1] - axle) > 1.0 - 1e-9, axis=1) & is_wheel[cell_of]
        top = np.all(np.abs(x[:, :, dim - 1]) < 1e-12, axis=1) & ~is_wheel[cell_of]
        values = np.where(tread, WHEEL, np.where(top, RAIL, 0)).astype(np.int32)
        self.tags = mesh.meshtags(m, dim - 1, facets[values > 0], values[values > 0])
        self.wheel, self.rail = (np.unique(self.V.dofmap.list[w]).astype(np.int32) for w in (is_wheel, ~is_wheel))
        self.axle = np.zeros(3)
        self.axle[dim - 1] = axle

    def _cells(self, n):
        """Cells of a structured body from the numbers of its nodes, by the three axes."""
        corners = [n[:-1, :, :-1], n[1:, :, :-1], n[:-1, :, 1:], n[1:, :, 1:]]
        if self.dim == 2:
            return np.stack([c.ravel() for c in corners], axis=-1)
        return np.stack([c[:, k].ravel() for k in (0, 1) for c in corners], axis=-1)

    def turning(self, speed, omega):
        """Velocity of a wheel that moves along the rail and turns clockwise."""
        v = fem.Function(self.V)
        x = self.V.tabulate_dof_coordinates()[self.wheel] - self.axle
        rows = v.x.array.reshape(-1, self.dim)
        rows[self.wheel, 0] = speed + omega * x[:, self.dim - 1]
        rows[self.wheel, self.dim - 1] = -omega * x[:, 0]
        return v

    def problem(self, contact, velocity, hold_rail=True, E=1e5):
        """Explicit problem of the wheel's flight over the rail."""
        zero = np.zeros(self.dim)
        bcs = [fem.dirichletbc(zero, self.rail, self.V)] if hold_rail else []
        law = di.StVenantKirchhoff(E, 0.3, 1.0, "3d" if self.dim == 3 else "plane_strain")
        return di.ExplicitProblem(fem.Function(self.V), law, velocity=velocity, bcs=bcs, contact=[contact])


def forces_of_rolling(dim, **options):
    """Normal forces while a wheel, which is hardly pushed, rolls by one of its facets (in space by a third)."""
    body = WheelOnRail(dim)
    penalty = 1.0  # [Pa/m]: too soft to be felt
    pair = di.ContactPair(body.tags, RAIL, WHEEL, **options)
    problem = body.problem(di.Penalty(pair, penalty=penalty), body.turning(1.0, 1.0))
    found, dt = [], 0.7 * problem.stable_step()
    for time in np.linspace(0.0, 0.13 if dim == 2 else 0.05, 14)[1:]:
        problem.advance(time, dt=dt, progress=False)
        found.append(problem.contact[0].force[dim - 1])
    half = np.sqrt(2.0 * DEPTH - DEPTH**2)
    # Where the circle is below the rail: the integral of its depth.
    area = np.arcsin(half) - half * (1.0 - DEPTH)
    return np.abs(found) / (penalty * area * (WIDTH if dim == 3 else 1.0))


def check_a_smooth_wheel_rolls_evenly():
    """A wheel of 48 flat facets is pressed with a fifth too little; the force of a smooth one is that of the circle
    within 1 %, of which the rail, with 28 nodes in contact, makes a half."""
    for dim in (2, 3):
        faceted, smooth = forces_of_rolling(dim), forces_of_rolling(dim, smooth=(False, True))
        assert np.all(faceted < 0.85), faceted
        assert np.abs(smooth - 1.0).max() < 0.01, smooth


def check_free_bodies_keep_their_momentum():
    """A smooth wheel strikes a free bar with friction and spin, by penalty and by kinematic contact."""
    for dim in (2, 3):
        for method in (di.Penalty, di.Kinematic):
            body = WheelOnRail(dim, depth=-0.002)
            velocity = body.turning(0.3, 2.0)
            velocity.x.array.reshape(-1, dim)[body.wheel, dim - 1] -= 1.0
            pair = di.ContactPair(body.tags, RAIL, WHEEL, friction=0.3, smooth=True)
            problem = body.problem(method(pair), velocity, hold_rail=False, E=1e3)
            start, dt = momenta(problem), 0.6 * problem.stable_step()
            pressed = 0.0
            for time in (0.004, 0.008, 0.012):
                problem.advance(time, dt=dt, progress=False)
                pressed = max(pressed, np.abs(problem.contact[0].force).max())
            end = momenta(problem)
            assert pressed > 0.0 and problem.contact[0].dissipated > 0.0
            assert np.abs(end[0] - start[0]).max() <= 1e-12 * start[2], (dim, method)
            # Forces of kinematic contact are in the displacements half a step before they are in the velocities.
            still_pushed = method is di.Kinematic and np.abs(problem.contact[0].force).max() > 0.0
            limit = 1e-8 if still_pushed else 1e-12  # round-off of some hundred steps
            assert np.abs(end[1] - start[1]).max() <= limit * start[3], (dim, method)
            assert abs(problem.energy["drift"]) <= 1e-4, (dim, method)


def check_ranks_agree():
    """Histories of the force on several ranks are those of one."""
    for method in (di.Penalty, di.Kinematic):
        found = []
        for comm in (COMM, MPI.COMM_SELF):
            body = WheelOnRail(3, depth=-0.002, comm=comm)
            velocity = body.turning(0.3, 2.0)
            velocity.x.array.reshape(-1, 3)[body.wheel, 2] -= 1.0
            pair = di.ContactPair(body.tags, RAIL, WHEEL, friction=0.3, smooth=True)
            problem = body.problem(method(pair), velocity, E=1e3)
            dt, forces = 0.6 * problem.stable_step(), []
            for time in (0.002, 0.004, 0.006, 0.008):
                problem.advance(time, dt=dt, progress=False)
                forces.append(np.array(problem.contact[0].force))
            found.append(np.array(forces))
        assert np.abs(found[1]).max() > 0.0
        # Sums in another order: 1e-12 of a force, through some hundred steps.
        assert np.abs(found[0] - found[1]).max() <= 1e-9 * np.abs(found[1]).max(), (method, found)


def force_of_pressing(method, facets, smooth=False):
    """Force on a stiff wheel that is pressed into an elastic rail, the slave, by a given way: static contact."""
    body = WheelOnRail(2, depth=0.0, cells=140, facets=facets)
    u = fem.Function(body.V)
    low = fem.locate_dofs_geometrical(body.V, lambda x: np.abs(x[1] + 0.05) < 1e-9)
    down = np.array([0.0, -0.003])
    bcs = [fem.dirichletbc(np.zeros(2), low, body.V), fem.dirichletbc(down, body.wheel, body.V)]
    pair = di.ContactPair(body.tags, RAIL, WHEEL, smooth=(False, smooth))
    law = di.LinearElastic(1.0, 0.3, hypothesis="plane_strain")
    problem = di.StaticProblem(u, law, bcs=bcs, contact=[method(pair)])
    problem.solve()
    return abs(problem.contact[0].force[1])


def check_a_smooth_master_is_round_in_static_contact():
    """A wheel of 96 smooth facets is pressed as one of 960 flat ones; 96 flat ones are not."""
    for method in (di.Lagrange, functools.partial(di.Penalty, penalty=1e3)):
        fine, coarse = force_of_pressing(method, 960), force_of_pressing(method, 96)
        smooth = force_of_pressing(method, 96, smooth=True)
        assert abs(coarse / fine - 1.0) > 0.02, (coarse, fine)
        assert abs(smooth / fine - 1.0) < 0.005, (smooth, fine)
