# SPDX-License-Identifier: MIT
"""Boxes in one mesh, on any number of ranks, with tags of their sides."""

import basix.ufl
import numpy as np
import ufl
from box_bodies import grid
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di


class Boxes:
    """Boxes that do not touch; side number 2 d of a box is its lower one along axis d, 2 d + 1 the upper one.

    Args:
        boxes: list of (low corner, high corner, cells along the axes, velocity).
        E: Young's modulus; density 1, Poisson's ratio 0.3.
        cell: kind of the cells; None: quadrilaterals or hexahedra.
        degree: of the displacements.
        hypothesis: of the material in the plane.
    """

    def __init__(
        self, *boxes, E=1e4, comm=MPI.COMM_SELF, partitioner=None, cell=None, degree=1, hypothesis="plane_strain"
    ):
        self.boxes, self.dim, self.comm = boxes, len(boxes[0][0]), comm
        kind = cell or ("quadrilateral" if self.dim == 2 else "hexahedron")
        parts = [grid(low, high, counts, kind) for low, high, counts, _ in boxes]
        first = np.cumsum([0, *(len(p) for p, _ in parts)])
        points = np.vstack([p for p, _ in parts])
        cells = np.vstack([c + start for (_, c), start in zip(parts, first)])
        element = basix.ufl.element("Lagrange", kind, 1, shape=(self.dim,))
        mine = slice(None) if comm.rank == 0 else slice(0)
        more = {} if partitioner is None else {"partitioner": partitioner}
        self.mesh = mesh.create_mesh(comm, cells[mine], x=points[mine], e=ufl.Mesh(element), **more)
        self.V = fem.functionspace(self.mesh, ("Lagrange", degree, (self.dim,)))
        self.law = di.LinearElastic(E, 0.3, 1.0, hypothesis if self.dim == 2 else None)
        self.mesh.topology.create_connectivity(self.dim - 1, self.dim)
        self.facets = mesh.exterior_facet_indices(self.mesh.topology)

    def inside(self, x, box):
        low, high = self.boxes[box][:2]
        return np.all((x[:, : self.dim] > np.array(low) - 1e-9) & (x[:, : self.dim] < np.array(high) + 1e-9), axis=1)

    def tags(self, surfaces):
        """MeshTags of surfaces: tag -> (box, side, condition on the middle of a facet or None) or a list of them."""
        middle = mesh.compute_midpoints(self.mesh, self.dim - 1, self.facets)
        values = np.zeros(len(self.facets), dtype=np.int32)
        for tag, parts in surfaces.items():
            for box, side, *where in parts if isinstance(parts, list) else [parts]:
                axis, upper = divmod(side, 2)
                on = self.inside(middle, box) & np.isclose(middle[:, axis], self.boxes[box][upper][axis])
                values[on & (where[0](middle) if where else True)] = tag
        return mesh.meshtags(self.mesh, self.dim - 1, self.facets, values)

    def problem(self, contact, loads=(), held=(), **options):
        """ExplicitProblem at the velocities of the boxes; those of `held` do not move."""
        velocity, x = fem.Function(self.V), self.V.tabulate_dof_coordinates()
        for box, (*_, speed) in enumerate(self.boxes):
            velocity.x.array.reshape(-1, self.dim)[self.inside(x, box)] = speed
        fixed = [np.flatnonzero(self.inside(x, box)).astype(np.int32) for box in held]
        bcs = [fem.dirichletbc(np.zeros(self.dim), nodes, self.V) for nodes in fixed]
        return di.ExplicitProblem(
            fem.Function(self.V), self.law, velocity=velocity, bcs=bcs, loads=list(loads), contact=contact, **options
        )


def momentum(problem):
    """Of all ranks."""
    n = problem.num_owned
    p = problem.mass.array[:n] * problem.velocity.x.array[:n]
    return problem.comm.allreduce(p.reshape(-1, problem.space.mesh.geometry.dim).sum(axis=0))


def own_energy(problem):
    """Kinetic and internal energy less external work, before every step."""
    return problem.energy_history[:, [1, 2]].sum(axis=1) - problem.energy_history[:, 9]
