# SPDX-License-Identifier: MIT
"""The same body on both sides: a DOLFINx mesh and space, and the hand-written model, matched by nodes."""

from typing import Protocol, TypeAlias, Union

import basix
import impact_reference
import numpy as np
from dolfinx import fem, mesh
from dolfinx.mesh import Mesh, MeshTags
from scipy.sparse import csr_matrix
from scipy.spatial import cKDTree

from dolfinx_impact import compat
from dolfinx_impact.common.types import AnyArray, FloatArray, IntArray
from dolfinx_impact.forms import quadrature
from dolfinx_impact.materials import LinearElastic, NeoHookean, StVenantKirchhoff
from . import nodes

Material: TypeAlias = Union[LinearElastic, NeoHookean, StVenantKirchhoff]


class ElasticMaterial(Protocol):
    """Constants of a material that both sides need: those of dolfinx_impact.materials have them."""

    @property
    def E(self) -> float:
        """Young's modulus [F/L^2]."""

    @property
    def nu(self) -> float:
        """Poisson's ratio [1]."""

    @property
    def density(self) -> float | None:
        """Density; None in statics without body forces [M/L^3]."""

    def hypothesis_on(self, mesh: Mesh) -> str:
        """Hypothesis on a mesh.

        Args:
            mesh: DOLFINx mesh.

        Returns:
            "3d", "plane_strain", "plane_stress" or "axisymmetric".
        """


def match_nodes(ours: FloatArray, theirs: FloatArray, scale: float) -> IntArray:
    """Match the nodes of the two sides by position.

    Args:
        ours: our nodes, shape (num_nodes, gdim) [L].
        theirs: nodes of the hand-written solver, shape (num_nodes, gdim) [L].
        scale: size of the body [L].

    Returns:
        Number of the other side's node at each of our nodes, shape (num_nodes).

    Raises:
        RuntimeError: a node without partner, or with two.
    """
    distance, index = cKDTree(theirs).query(ours)
    if distance.max() > 1e-9 * scale or len(np.unique(index)) != len(index) or len(ours) != len(theirs):
        raise RuntimeError(
            f"the nodes of the two sides do not match: {len(ours)} and {len(theirs)} nodes, largest distance "
            f"{distance.max():.1e}"
        )
    return index


class Body:
    """One body on both sides: `V` is our space, `model` the hand-written one.

    Args:
        domain: DOLFINx mesh on one rank.
        degree: degree of the displacement, 1 or 2.
        material: material of dolfinx_impact.
        law: name of the law for the other side.
        rule: rule of the other side, or rules by purpose; None takes its default.
        averaged_pressure: whether the other side averages the pressure of an elastic law at the nodes.
        averaged_strain: whether it averages the strain, too.
    """

    def __init__(
        self,
        domain: Mesh,
        degree: int,
        material: ElasticMaterial,
        law: str = "linear_elastic",
        rule: nodes.TheirRule | dict[str, nodes.TheirRule] = None,
        averaged_pressure: bool = False,
        averaged_strain: bool = False,
    ) -> None:
        self.mesh, self.degree, self.material = domain, degree, material
        self.gdim: int = domain.geometry.dim
        self.cell: str = domain.topology.cell_name()
        self.geometry_degree: int = compat.coordinate_element(domain).degree
        self.V = fem.functionspace(domain, ("Lagrange", degree, (self.gdim,)))
        self.hypothesis = material.hypothesis_on(domain)
        order = nodes.permutation(self.cell, self.geometry_degree)
        dofmap = compat.geometry_dofmap(domain)
        cells: IntArray = np.empty(dofmap.shape, dtype=np.int64)
        cells[:, order] = dofmap
        self.points: FloatArray = domain.geometry.x[:, : self.gdim].copy()
        self.cells = cells
        self._orient()
        self.their_material = impact_reference.Material(
            material.E, material.nu, material.density or 0.0, self.hypothesis, law
        )
        self.model = impact_reference.Model(
            self.points,
            cells,
            self.cell,
            self.their_material,
            degree=degree,
            geometry_degree=self.geometry_degree,
            rule=rule,
            averaged_pressure=averaged_pressure,
            averaged_strain=averaged_strain,
        )
        size = float(np.ptp(self.points, axis=0).max())
        at = match_nodes(self.V.tabulate_dof_coordinates()[:, : self.gdim], self.model.field_points, size)
        self.order: IntArray = (self.gdim * at[:, None] + np.arange(self.gdim)).ravel()

    def _orient(self) -> None:
        """Reflect cells with a negative Jacobian: DOLFINx keeps them, the hand-written solver refuses them."""
        first = [0, 1, 3, 4] if self.cell in nodes.TENSOR else [0, 1, 2, 3]
        corners = self.points[self.cells[:, first[: self.gdim + 1]]]
        negative = np.linalg.det(corners[:, 1:] - corners[:, :1]) < 0
        self.cells[negative] = self.cells[negative][:, nodes.reflection(self.cell, self.geometry_degree)]

    def to_theirs(self, values: AnyArray) -> AnyArray:
        """Reorder values at degrees of freedom from our order to theirs.

        Args:
            values: values in our order, shape (num_dofs).

        Returns:
            Values in their order, shape (num_dofs).
        """
        return nodes.to_theirs(np.asarray(values), self.order)

    def to_ours(self, values: AnyArray) -> AnyArray:
        """Reorder values at degrees of freedom from their order to ours.

        Args:
            values: values in their order, shape (num_dofs).

        Returns:
            Values in our order, shape (num_dofs).
        """
        return np.asarray(values)[self.order]

    def matrix_to_ours(self, csr: impact_reference.Csr) -> csr_matrix:
        """Reorder a matrix from their order to ours.

        Args:
            csr: matrix in their order, shape (num_dofs, num_dofs).

        Returns:
            SciPy matrix in our order, shape (num_dofs, num_dofs).
        """
        matrix = csr_matrix((csr.data, csr.indices, csr.indptr), shape=csr.shape)
        return matrix[self.order][:, self.order]

    def their_facets(self, tags: MeshTags, tag: int) -> IntArray:
        """Facets with a tag as the hand-written solver takes them.

        The order is that of our side: by the numbers of their cells in the mesh's input, then by their local number.

        Args:
            tags: tags of facets.
            tag: tag.

        Returns:
            Points of every facet, which have the same numbers on both sides, shape (num_facets, nodes per facet).
        """
        facets, topology = tags.find(tag), self.mesh.topology
        topology.create_connectivity(self.gdim - 1, self.gdim)
        topology.create_connectivity(self.gdim, self.gdim - 1)
        to_cell = topology.connectivity(self.gdim - 1, self.gdim)
        to_facet = topology.connectivity(self.gdim, self.gdim - 1)
        cells = [to_cell.links(f)[0] for f in facets]
        local = [list(to_facet.links(c)).index(f) for c, f in zip(cells, facets)]
        facets = facets[np.lexsort((np.array(local), topology.original_cell_index[cells]))] if len(facets) else facets
        return mesh.entities_to_geometry(self.mesh, self.gdim - 1, facets).astype(np.int64)


def foundation_rule(body: Body) -> nodes.TheirRule:
    """Rule of the other side for a foundation: that of our side on facets.

    Args:
        body: both sides.
    """
    used = quadrature.foundation_degree(body.cell, body.degree, body.geometry_degree, body.hypothesis)
    if body.cell == "tetrahedron":
        return basix.make_quadrature(basix.CellType.triangle, used)
    return f"gauss_jacobi:{used}"
