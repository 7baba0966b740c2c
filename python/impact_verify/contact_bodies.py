# SPDX-License-Identifier: MIT
"""Two bodies in one mesh, one above the other, on both sides; integration rules handed over."""

from collections.abc import Sequence
from typing import Any, TypeAlias, Union

import basix
import basix.ufl
from dolfinx_impact.own_forms import distorted_block
import impact_reference
import numpy as np
import ufl
from dolfinx import fem, mesh
from dolfinx.mesh import Mesh, MeshTags
from impact_reference.contact import Obstacle as TheirObstacle
from mpi4py import MPI
from scipy.sparse import csr_matrix

from dolfinx_impact import compat, contact, materials
from dolfinx_impact.common.types import AnyArray, FloatArray, IntArray
from dolfinx_impact.contact.pair import Smooth
from . import matched_body, nodes

SLAVE, MASTER, TOP, BOTTOM = 1, 2, 3, 4
#: Cells and hypotheses of bodies in contact.
CASES = (
    ("triangle", "plane_strain"),
    ("quadrilateral", "plane_strain"),
    ("quadrilateral", "axisymmetric"),
    ("tetrahedron", "3d"),
    ("hexahedron", "3d"),
)
BETWEEN = 0.5  # distance of the bodies while the mesh is made and tagged [L]
# Rigid obstacles on our side, and the same obstacle on both sides.
OurObstacle: TypeAlias = Union[contact.RigidPlane, contact.RigidSphere, contact.RigidCylinder]
ObstaclePair: TypeAlias = tuple[OurObstacle, TheirObstacle]


def facet_of(cell: str) -> str:
    """Cell type of a cell's facets.

    Args:
        cell: cell.

    Returns:
        "interval", "triangle" or "quadrilateral".
    """
    return {"triangle": "interval", "quadrilateral": "interval", "tetrahedron": "triangle"}.get(cell, "quadrilateral")


def rule(shape: str, degree: int) -> tuple[FloatArray, FloatArray]:
    """Rule of our side (Basix's) on the other side's reference facet.

    The points are symmetric under all reflections and rotations of the facet, so the rule does not depend on which
    vertex a side counts first.

    Args:
        shape: cell type of the facet.
        degree: degree that the rule integrates exactly.

    Returns:
        Points, shape (num_points, tdim) [1], and weights, shape (num_points) [1].
    """
    found = basix.make_quadrature(getattr(basix.CellType, shape), degree)
    points, weights = np.asarray(found[0]), np.asarray(found[1])
    if shape == "triangle":
        return points, weights
    return 2 * points - 1, 2 ** points.shape[1] * weights


def grid_of_box(
    cell: str, low: FloatArray, high: FloatArray, n: Sequence[int], geometry_degree: int = 1
) -> tuple[FloatArray, IntArray]:
    """Points and cells of a box with straight edges.

    Args:
        cell: cell of the grid.
        low: least coordinates, shape (gdim) [L].
        high: largest coordinates, shape (gdim) [L].
        n: number of cells along each axis.
        geometry_degree: degree of the geometry, 1 or 2.

    Returns:
        Points, shape (num_points, gdim) [L], and their numbers in each cell.
    """
    kind = getattr(mesh.CellType, cell)
    create = mesh.create_rectangle if len(n) == 2 else mesh.create_box
    domain = create(MPI.COMM_SELF, [low, high], list(n), kind)
    if geometry_degree == 2:
        domain = distorted_block.with_quadratic_geometry(domain)
    return domain.geometry.x[:, : len(n)], compat.geometry_dofmap(domain).astype(np.int64)


def two_bodies(
    cell: str,
    lower: Sequence[int],
    upper: Sequence[int],
    geometry_degree: int = 1,
    start: Sequence[float] = (0.15, 0.1),
    length: Sequence[float] = (0.7, 0.75),
) -> tuple[Mesh, MeshTags]:
    """Mesh of an upper body (lower face tagged SLAVE) on a unit square or cube (upper face tagged MASTER).

    Args:
        cell: cell of the mesh.
        lower: number of cells of the lower body along each axis.
        upper: number of cells of the upper body along each axis.
        geometry_degree: degree of the geometry, 1 or 2.
        start: least coordinates of the upper body along the horizontal axes, shape (gdim - 1) at least [L].
        length: sides of the upper body along the horizontal axes, shape (gdim - 1) at least; its height is 0.5 [L].

    Returns:
        Mesh on this rank, and tags of the facets.
    """
    dim = len(lower)
    corner, sides = np.array(start[: dim - 1]), np.array(length[: dim - 1])
    low = np.append(corner, 1.0 + BETWEEN)
    parts = [
        grid_of_box(cell, np.zeros(dim), np.ones(dim), lower, geometry_degree),
        grid_of_box(cell, low, low + np.append(sides, 0.5), upper, geometry_degree),
    ]
    split = len(parts[0][0])
    points = np.vstack([p for p, _ in parts])
    cells = np.vstack([parts[0][1], parts[1][1] + split])
    element = basix.ufl.element("Lagrange", cell, geometry_degree, shape=(dim,))
    domain = mesh.create_mesh(MPI.COMM_SELF, cells, x=points, e=ufl.Mesh(element))
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


def roughen(domain: Mesh, rng: np.random.Generator, amount: float) -> None:
    """Move every node at random.

    Args:
        domain: mesh, which is changed.
        rng: random numbers.
        amount: largest motion along an axis [L].
    """
    dim = domain.geometry.dim
    domain.geometry.x[:, :dim] += amount * rng.uniform(-1, 1, (len(domain.geometry.x), dim))


class TwoBodies(matched_body.Body):
    """Two bodies in contact on both sides, or one body and a rigid obstacle.

    Args:
        domain: DOLFINx mesh on one rank.
        tags: tags of the facets.
        degree: degree of the displacement, 1 or 2.
        material: material of dolfinx_impact.
        friction: Coulomb's friction coefficient [1].
        rigid: our obstacle and the other side's; None: the lower body is the master.
        prescribed: our degrees of freedom with prescribed values.
        options: further arguments of `Body`.

    Attributes:
        adjustment: offset, clearance and adjust of the pair, on both sides [L].
        moving: the other side's rigid body whose surface its obstacle is, in implicit and static problems; else None.
    """

    def __init__(
        self,
        domain: Mesh,
        tags: MeshTags,
        degree: int,
        material: matched_body.ElasticMaterial,
        friction: float = 0.0,
        rigid: ObstaclePair | None = None,
        prescribed: IntArray | tuple[int, ...] = (),
        **options: Any,
    ) -> None:
        super().__init__(domain, degree, material, **options)
        self.tags, self.friction, self.rigid, self.prescribed = tags, friction, rigid, prescribed
        self.adjustment: dict[str, Any] = {}
        self.moving: impact_reference.RigidBody | None = None
        self.u = fem.Function(self.V, name="u")
        self.facet = facet_of(self.cell)
        self.segment = "triangle" if self.gdim == 3 else "interval"
        self.nodes = self.order[:: self.gdim] // self.gdim  # their number of each of our nodes
        self.size = float(np.linalg.norm(np.ptp(self.points, axis=0)))

    def pair(self, everywhere: bool = True, smooth: Smooth = False) -> contact.ContactPair:
        """Our pair of surfaces.

        Args:
            everywhere: search masters at any distance, as the other side's static contact does; False takes the default
                of explicit runs, which is the same on both sides.
            smooth: normals of a smooth master, as ContactPair takes them.

        Returns:
            Pair of surfaces.
        """
        master: int | OurObstacle = self.rigid[0] if self.rigid else MASTER
        distance = None if self.rigid or not everywhere else self.size
        return contact.ContactPair(
            self.tags, SLAVE, master, self.friction, search_distance=distance, smooth=(False, smooth),
            **self.adjustment,
        )  # fmt: skip

    def theirs(self, points_and_weights: tuple[FloatArray, FloatArray]) -> impact_reference.Contact:
        """The other side's contact.

        Args:
            points_and_weights: integration rule on its reference facet.

        Returns:
            Contact with the same surfaces and friction.
        """
        master = self.rigid[1] if self.rigid else self.their_facets(self.tags, MASTER)
        return impact_reference.Contact(
            self.model,
            self.their_facets(self.tags, SLAVE),
            master,
            self.friction,
            points_and_weights,
            self.order[np.asarray(self.prescribed, dtype=np.int64)],
            **self.adjustment,
        )

    def nodal_to_ours(self, values: AnyArray) -> AnyArray:
        """Reorder values at nodes from their order to ours.

        Args:
            values: values in their order, shape (num_nodes, ...).

        Returns:
            Values in our order, shape (num_nodes, ...).
        """
        return np.asarray(values)[self.nodes]

    def nodal_to_theirs(self, values: AnyArray) -> AnyArray:
        """Reorder values at nodes from our order to theirs.

        Args:
            values: values in our order, shape (num_nodes, ...).

        Returns:
            Values in their order, shape (num_nodes, ...).
        """
        return nodes.to_theirs(np.asarray(values), self.nodes)

    def nodal_matrix_to_ours(self, csr: impact_reference.Csr) -> csr_matrix:
        """Reorder a matrix over nodes from their order to ours.

        Args:
            csr: matrix in their order, shape (num_nodes, num_nodes).

        Returns:
            SciPy matrix in our order, shape (num_nodes, num_nodes).
        """
        return csr_matrix((csr.data, csr.indices, csr.indptr), shape=csr.shape)[self.nodes][:, self.nodes]


def steel(hypothesis: str, kind: type[matched_body.Material] = materials.LinearElastic) -> matched_body.Material:
    """Material with modulus 1, Poisson's ratio 0.3 and density 1.

    Args:
        hypothesis: hypothesis of the material.
        kind: class of the material.

    Returns:
        Material.
    """
    return kind(1.0, 0.3, 1.0, hypothesis)


def obstacles(dim: int, offset: float = 0.0) -> list[tuple[str, OurObstacle, TheirObstacle]]:
    """Rigid masters below the upper body, tilted and off centre.

    Args:
        dim: dimension of space.
        offset: shift along x [L].

    Returns:
        Name, our obstacle and the other side's, of a plane, a sphere and a cylinder.
    """
    middle = np.array([0.8 + offset, 0.45])[: dim - 1]
    normal, axis = np.array([0.1, 0.05][: dim - 1] + [1.0]), np.array([0.1, 1.0, 0.05])
    made: list[tuple[str, OurObstacle, TheirObstacle]] = [
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
