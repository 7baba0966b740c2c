# SPDX-License-Identifier: MIT
"""A block pressed on another one by the displacement of a uniform stress: supports, exact values, errors."""

import numpy as np
from dolfinx import fem
from mpi4py import MPI
from over_ranks import largest

import dolfinx_impact as di
from dolfinx_impact import meshes
from dolfinx_impact.assembly.operators import PointValues

E = 1.0e6


def hooke(strains, nu):
    """Diagonal of the stress, plane strain or 3D; written out independently of the package."""
    strains = np.asarray(strains)
    return E / ((1 + nu) * (1 - 2 * nu)) * ((1 - 2 * nu) * strains + nu * strains.sum())


def free_sides(dim, nu, strain):
    """Diagonal of the strain for a vertical strain, sides free."""
    lateral = -nu / (1 - nu) * strain if dim == 2 else -nu * strain
    return np.array([lateral] * (dim - 1) + [strain])


class PressedBlocks:
    """Two blocks with separate nodes and displacements u = strains * x, component by component, as the solution.

    Below and above they are held by rollers, and at x = 0 (y = 0); other sides are free. Or, with `pressed`, the sides
    carry the tractions of that uniform stress, and the lowest and uppermost faces have all components prescribed: then
    no node of the contact is held by anything else. With `rollers` they are held as before instead.

    Args:
        cell, degree: of the displacement. strains, nu: diagonal of the strain, Poisson's ratio.
        method: function of a ContactPair. pressed: diagonal of the stress, or None. rollers: in place of held faces.
        swap: slave and master.
        rigid: the whole lower block has its displacement prescribed. sink: how much lower the upper block comes to lie.
        more_loads: function of the mesh, returns a list.
        comm: communicator. mesh: parameters of two_blocks.
    """

    def __init__(
        self, cell, degree, strains, nu, method, pressed=None, rollers=False, swap=False, rigid=False, sink=0.0,
        more_loads=None, comm=MPI.COMM_SELF, **mesh,
    ):  # fmt: skip
        self.strains, dim = strains, len(strains)
        if dim == 3:
            mesh = {
                "lower": (1, 1, 0.5),
                "upper": (1, 1, 0.5),
                "lower_cells": (3, 2, 2),
                "upper_cells": (4, 3, 2),
            } | mesh
        self.m = meshes.make("two_blocks", comm, cell=cell, **mesh)
        tags, facets = self.m.tags, self.m.facet_tags
        self.m.mesh.topology.create_connectivity(dim, dim)
        self.V = V = fem.functionspace(self.m.mesh, ("Lagrange", degree, (dim,)))
        self.u, self.exact = fem.Function(V, name="u"), fem.Function(V)
        self.exact.interpolate(lambda x: np.asarray(strains)[:, None] * x[:dim])
        upper = fem.locate_dofs_topological(V, dim, self.m.cell_tags.find(tags["slave_body"]))
        self.exact.x.array[dim * upper + dim - 1] -= sink
        self.material = di.LinearElastic(E, nu, hypothesis="3d" if dim == 3 else "plane_strain")
        ends, loads = ("bottom", "top"), list(more_loads(self.m)) if more_loads else []
        if pressed is None or rollers:
            sides = [(name, dim - 1) for name in ends]
            sides += [
                (p + name, axis) for axis, name in enumerate(("left", "front")[: dim - 1]) for p in ("", "slave_")
            ]
            self.bcs = [self.roller(facets.find(tags[name]), axis, (name == "top") * sink) for name, axis in sides]
        else:
            self.bcs = [self.prescribed(dim - 1, facets.find(tags[name])) for name in ends]
        if pressed is not None:
            for k, name in enumerate(("left", "right", "front", "back")[: 2 * dim - 2]):
                traction = (2 * (k % 2) - 1) * pressed[k // 2] * np.eye(dim)[k // 2]
                loads += [di.Traction(facets, tags[p + name], traction) for p in ("", "slave_")]
        if rigid:
            self.bcs.append(self.prescribed(dim, self.m.cell_tags.find(tags["master_body"])))
        surfaces = [tags["slave_surface"], tags["master_surface"]][:: -1 if swap else 1]
        contact = [method(di.ContactPair(facets, *surfaces))]
        self.problem = di.StaticProblem(self.u, self.material, bcs=self.bcs, loads=loads, contact=contact)
        # Far below what is asserted; round-off of these small problems is about 1e-15 of the forces.
        self.report = self.problem.solve(rtol=1e-13)
        self.contact = self.problem.contact[0]

    def prescribed(self, dim, entities):
        """All components of the exact displacement."""
        return fem.dirichletbc(self.exact, fem.locate_dofs_topological(self.V, dim, entities))

    def roller(self, facets, axis, sink):
        """One component of the exact displacement on facets."""
        V = self.V
        part, _ = V.sub(axis).collapse()
        value = fem.Function(part)
        value.interpolate(lambda x: self.strains[axis] * x[axis] - sink)
        dofs = fem.locate_dofs_topological((V.sub(axis), part), V.mesh.topology.dim - 1, facets)
        return fem.dirichletbc(value, dofs, V.sub(axis))

    def displacement_error(self):
        """Largest over the nodes, against the largest displacement; on all ranks."""
        comm, exact = self.m.mesh.comm, self.exact.x.array
        return largest(np.abs(self.u.x.array - exact), comm) / largest(np.abs(exact), comm)

    def stress_error(self, stress):
        """Largest over points in all cells, against the largest stress; on all ranks."""
        tdim, comm = self.m.mesh.topology.dim, self.m.mesh.comm
        points = np.vstack([np.full(tdim, 0.25), np.eye(tdim) * 0.5 + 0.1])
        values = PointValues(self.material.stress(self.u), points).values()
        expected = np.zeros((3, 3)) if values.shape[2] == 9 else np.zeros((tdim, tdim))
        expected[np.arange(tdim), np.arange(tdim)] = stress
        values = values.reshape(*values.shape[:2], *expected.shape)[..., :tdim, :tdim]
        error = float(np.max(np.abs(values - expected[:tdim, :tdim]), initial=0.0))
        return comm.allreduce(error, MPI.MAX) / np.abs(stress).max()

    def pressure_error(self, pressure):
        """Largest over the contact points, against the pressure expected; on all ranks."""
        error = float(np.max(np.abs(self.contact.pressure - pressure), initial=0.0))
        return self.m.mesh.comm.allreduce(error, MPI.MAX) / pressure
