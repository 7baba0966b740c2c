# SPDX-License-Identifier: MIT
"""Two bodies in one mesh, one above the other, on both sides; integration rules handed over."""

import basix
import basix.ufl
import impact_reference
import numpy as np
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

from .. import contact, materials
from . import bodies, nodes

SLAVE, MASTER, TOP, BOTTOM = 1, 2, 3, 4
BETWEEN = 0.5  # the bodies are that far apart while they are made and tagged


def facet_of(cell):
    return {"triangle": "interval", "quadrilateral": "interval", "tetrahedron": "triangle"}.get(cell, "quadrilateral")


def rule(shape, degree):
    """Basix's rule, the one our side uses, on the other side's reference facet.

    Its points are symmetric under all reflections and rotations of the facet: which vertex a side counts first does not
    matter.
    """
    points, weights = basix.make_quadrature(getattr(basix.CellType, shape), degree)
    if shape == "triangle":
        return points, weights
    return 2 * points - 1, 2 ** points.shape[1] * weights


def _box(cell, low, high, n, geometry_degree):
    """Points and cells of a box; geometry of degree 2 still straight."""
    kind = getattr(mesh.CellType, cell)
    create = mesh.create_rectangle if len(n) == 2 else mesh.create_box
    domain = create(MPI.COMM_SELF, [low, high], list(n), kind)
    if geometry_degree == 2:
        domain = bodies.curved(domain)
    return domain.geometry.x[:, : len(n)], domain.geometry.dofmap.astype(np.int64)


def two_bodies(cell, lower, upper, geometry_degree=1, start=(0.15, 0.1), length=(0.7, 0.75)):
    """Mesh and facet tags: an upper body (slave below, tag SLAVE) on a unit square or cube (MASTER above).

    Args:
        lower, upper: cells along the axes. start, length: of the upper body along the horizontal axes; it is 0.5 high.
    """
    dim = len(lower)
    start, length = np.array(start[: dim - 1]), np.array(length[: dim - 1])
    low = np.append(start, 1.0 + BETWEEN)
    parts = [
        _box(cell, np.zeros(dim), np.ones(dim), lower, geometry_degree),
        _box(cell, low, low + np.append(length, 0.5), upper, geometry_degree),
    ]
    split = len(parts[0][0])
    points = np.vstack([p for p, _ in parts])
    cells = np.vstack([parts[0][1], parts[1][1] + split])
    element = basix.ufl.element("Lagrange", cell, geometry_degree, shape=(dim,))
    domain = mesh.create_mesh(MPI.COMM_SELF, cells, points, ufl.Mesh(element))
    heights = {SLAVE: 1.0 + BETWEEN, MASTER: 1.0, TOP: 1.5 + BETWEEN, BOTTOM: 0.0}
    found = {
        tag: mesh.locate_entities_boundary(domain, dim - 1, lambda x, z=z: np.isclose(x[dim - 1], z))
        for tag, z in heights.items()
    }
    facets = np.concatenate(list(found.values()))
    values = np.repeat(list(found), [len(f) for f in found.values()]).astype(np.int32)
    order = np.argsort(facets)
    x = domain.geometry.x
    x[x[:, dim - 1] > 1.0 + BETWEEN / 2, dim - 1] -= BETWEEN
    return domain, mesh.meshtags(domain, dim - 1, facets[order], values[order])


def roughen(domain, rng, amount):
    """Move every node by up to `amount` [L]."""
    dim = domain.geometry.dim
    domain.geometry.x[:, :dim] += amount * rng.uniform(-1, 1, (len(domain.geometry.x), dim))


class TwoBodies(bodies.Body):
    """Both sides of a pair of bodies. Other arguments as for Body.

    Args:
        tags: of the facets.
        friction: coefficient [1].
        rigid: (our obstacle, theirs), or None: the lower body is the
        master.
        prescribed: our dofs with prescribed values.
    """

    def __init__(self, domain, tags, degree, material, friction=0.0, rigid=None, prescribed=(), **options):
        super().__init__(domain, degree, material, **options)
        self.tags, self.friction, self.rigid, self.prescribed = tags, friction, rigid, prescribed
        self.u = fem.Function(self.V, name="u")
        self.facet = facet_of(self.cell)
        self.segment = "triangle" if self.gdim == 3 else "interval"
        self.nodes = self.order[:: self.gdim] // self.gdim  # theirs at ours
        self.size = float(np.linalg.norm(np.ptp(self.points, axis=0)))

    def pair(self, everywhere=True):
        """Our ContactPair. In statics every point finds its master, as on the other side without search distance; in
        explicit runs both sides have the same default."""
        master, reach = (self.rigid[0], None) if self.rigid else (MASTER, self.size if everywhere else None)
        return contact.ContactPair(self.tags, SLAVE, master, self.friction, search_distance=reach)

    def theirs(self, points_and_weights):
        """The other side's Contact with this rule."""
        master = self.rigid[1] if self.rigid else self.their_facets(self.tags, MASTER)
        return impact_reference.Contact(
            self.model,
            self.their_facets(self.tags, SLAVE),
            master,
            self.friction,
            points_and_weights,
            self.order[np.asarray(self.prescribed, dtype=np.int64)],
        )

    def nodal_to_ours(self, values):
        """Values at their nodes, a row each, in our order."""
        return np.asarray(values)[self.nodes]

    def nodal_to_theirs(self, values):
        return nodes.to_theirs(np.asarray(values), self.nodes)

    def nodal_matrix_to_ours(self, csr):
        from scipy.sparse import csr_matrix

        return csr_matrix((csr.data, csr.indices, csr.indptr), shape=csr.shape)[self.nodes][:, self.nodes]


def steel(hypothesis, kind=materials.LinearElastic):
    return kind(1.0, 0.3, 1.0, hypothesis)


def obstacles(dim, offset=0.0):
    """(name, ours, theirs) of rigid masters below the upper body, tilted and off centre; `offset` along x [L]."""
    middle = np.array([0.8 + offset, 0.45])[: dim - 1]
    normal, axis = np.array([0.1, 0.05][: dim - 1] + [1.0]), np.array([0.1, 1.0, 0.05])
    made = [
        (
            "rigid plane",
            contact.RigidPlane(np.append(middle, 1.0), normal),
            impact_reference.RigidPlane(np.append(middle, 1.0), normal / np.linalg.norm(normal)),
        )
    ]
    for name in ("Sphere", "Cylinder"):
        center, radius = np.append(middle, 0.0), 1.04
        ours, theirs = getattr(contact, f"Rigid{name}"), getattr(impact_reference, f"Rigid{name}")
        if name == "Cylinder" and dim == 3:
            pair = ours(center, radius, axis), theirs(center, radius, axis)
        else:
            pair = ours(center, radius), theirs(center, radius)
        made.append((f"rigid {name.lower()}", *pair))
    return made
