# SPDX-License-Identifier: MIT
"""Hertz's contacts as finite elements: bodies, loads, and how far pressure, width and force are from the theory.

The theory is taken at the force that was measured: the finite size of the bodies then enters only through the shape of
the pressure, which differs by (a/size)^2.
"""

from dataclasses import dataclass

import numpy as np
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import meshes

E, NU = 1.0e5, 0.3
RADIUS = 100.0  # of the round body; the contact has half-width 1 under the full load
SIZE = 20.0  # of the flat body


@dataclass
class Errors:
    """Relative errors of a converged state against Hertz at the force it has."""

    peak: float
    width: float
    pressure: float  # L2 norm over the contact, from the values at the nodes (points) and their areas
    force: float
    half_width: float


def compare(contact, hertz, parts, area):
    """Errors of a model that is one of `parts` equal parts; `area` of the theory's contact."""
    p, w = contact.pressure, contact.weight
    exact = hertz.pressure(contact.points[:, 0], *contact.points[:, 1:-1].T)
    return Errors(
        p.max() / hertz.peak_pressure - 1.0,
        parts * contact.area / area - 1.0,
        np.sqrt(np.sum(w * (p - exact) ** 2) / np.sum(w * exact**2)),
        parts * contact.force[-1],
        contact.area,
    )


def held(V, tags, tag, axis, value=0.0):
    """One component prescribed on tagged facets; `value` may be a fem.Constant."""
    dofs = fem.locate_dofs_topological(V.sub(axis), V.mesh.topology.dim - 1, tags.find(tag))
    return fem.dirichletbc(value, dofs, V.sub(axis))


class Round:
    """Half a cylinder, or (hypothesis axisymmetric) half a ball, on a block of the same material.

    Args:
        cell, degree: of displacement and geometry. h: facets in the contact, of half-width 1.
        coarse: largest cells. method: function of a ContactPair. control: "force" or "displacement".
    """

    def __init__(self, cell, degree, h, coarse=6.0, method=di.Lagrange, control="force", hypothesis="plane_strain"):
        self.m = m = meshes.make(
            "cylinder_on_half_plane", MPI.COMM_SELF, cell=cell, degree=degree, radius=RADIUS, a=1.0, h=h,
            width=SIZE, height=SIZE, coarse=coarse,
        )  # fmt: skip
        self.point = hypothesis == "axisymmetric"
        self.V = V = fem.functionspace(m.mesh, ("Lagrange", degree, (2,)))
        self.num_unknowns = 2 * V.dofmap.index_map.size_global
        self.u, self.full = fem.Function(V, name="u"), fem.Constant(m.mesh, 0.0)
        material = di.LinearElastic(E, NU, hypothesis=hypothesis)
        sides = (("bottom", 0), ("bottom", 1), ("symmetry_x", 0))
        bcs, self.loads = [held(V, m.facet_tags, m.tags[name], axis) for name, axis in sides], []
        self.force = control == "force"
        modulus = E / (1 - NU**2) / 2
        if self.force:  # half-width 1 by Johnson (4.43), (4.22)
            whole = 4 / 3 * modulus / RADIUS if self.point else np.pi * modulus / (4 * RADIUS)
            top = np.pi * RADIUS**2 if self.point else 2 * RADIUS
            self.unit = np.array([0.0, -whole / top])
            self.loads = [di.Traction(m.facet_tags, m.tags["top"], self.unit)]
        else:
            self.unit = -(1.0 if self.point else 3.0) / RADIUS
            bcs.append(held(V, m.facet_tags, m.tags["top"], 1, self.full))
        pair = di.ContactPair(m.facet_tags, slave=m.tags["slave_surface"], master=m.tags["master_surface"])
        contact = [method(pair)]
        self.problem = di.StaticProblem(self.u, material, bcs=bcs, loads=self.loads, contact=contact)
        self.contact = self.problem.contact[0]

    def solve(self, load=1.0, steps=4):
        """Go to a part of the full load; returns Report."""
        value = self.loads[0].constant if self.force else self.full
        value.value = load * self.unit
        return self.problem.solve(steps=steps)

    def errors(self):
        parts = 1 if self.point else 2
        theory = di.theory.hertz_point if self.point else di.theory.hertz_line
        hertz = theory(parts * self.contact.force[1], RADIUS, np.inf, E, NU, E, NU)
        return compare(self.contact, hertz, parts, np.pi * hertz.a**2 if self.point else 2 * hertz.half_width)


def graded_block(cell, n, depth=SIZE):
    """Half of a block with the contact at the origin: n by n cells that grow outwards as sinh does."""
    m = mesh.create_rectangle(MPI.COMM_SELF, [[0, 0], [1, 1]], [n, n], getattr(mesh.CellType, cell))
    x = m.geometry.x
    x[:, :2] = depth * np.sinh(4.0 * x[:, :2]) / np.sinh(4.0) * [1, -1]
    return m


class RigidOnBlock:
    """A rigid cylinder of radius RADIUS pressed into a block by its displacement; half model.

    Args:
        cell, degree: of the block. n: cells along each side. method: function of a ContactPair. obstacle: another one
            than the cylinder, which touches the origin from above.
    """

    def __init__(self, cell, degree, n, method=di.Lagrange, obstacle=None):
        domain = graded_block(cell, n)
        self.V = V = fem.functionspace(domain, ("Lagrange", degree, (2,)))
        self.num_unknowns = 2 * V.dofmap.index_map.size_global
        places = (lambda x: np.isclose(x[1], 0), lambda x: np.isclose(x[1], -SIZE), lambda x: np.isclose(x[0], 0))
        facets = [mesh.locate_entities_boundary(domain, 1, place) for place in places]
        tags = np.repeat(np.arange(1, 4, dtype=np.int32), [len(f) for f in facets])
        order = np.argsort(np.concatenate(facets))
        tags = mesh.meshtags(domain, 1, np.concatenate(facets)[order], tags[order])
        self.obstacle = obstacle or di.RigidCylinder((0.0, RADIUS), RADIUS)
        contact = [method(di.ContactPair(tags, slave=1, master=self.obstacle))]
        bcs = [held(V, tags, tag, axis) for tag, axis in ((2, 0), (2, 1), (3, 0))]
        material = di.LinearElastic(E, NU, hypothesis="plane_strain")
        self.problem = di.StaticProblem(fem.Function(V), material, bcs=bcs, contact=contact)
        self.contact = self.problem.contact[0]

    def solve(self, steps=4):
        self.obstacle.displacement = (0.0, -1.7 / RADIUS)
        return self.problem.solve(steps=steps)

    def errors(self):
        hertz = di.theory.hertz_line(-2 * self.contact.force[1], RADIUS, np.inf, np.inf, 0.0, E, NU)
        errors = compare(self.contact, hertz, 2, 2 * hertz.half_width)
        errors.force = hertz.load_per_length
        return errors
