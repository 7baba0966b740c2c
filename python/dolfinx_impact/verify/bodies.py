# SPDX-License-Identifier: MIT
"""The same body on both sides: a DOLFINx mesh and space, and the hand-written model, matched by nodes."""

import impact_reference
import numpy as np
from dolfinx import fem, mesh
from mpi4py import MPI
from scipy.sparse import csr_matrix, issparse
from scipy.spatial import cKDTree

from . import nodes


def matched(ours, theirs, scale):
    """theirs[i]: number of the other side's node at our node i, found by position.

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
    """One body, both sides.

    Args:
        domain: DOLFINx mesh on one rank.
        degree: of the displacement.
        material: dolfinx_impact material.
        law: name of the law for the other side.
        rule: name of the rule for the other side, None: its default.
    """

    def __init__(self, domain, degree, material, law="linear_elastic", rule=None):
        self.mesh, self.degree, self.material = domain, degree, material
        self.gdim = domain.geometry.dim
        self.cell = domain.topology.cell_name()
        self.geometry_degree = domain.geometry.cmap.degree
        self.V = fem.functionspace(domain, ("Lagrange", degree, (self.gdim,)))
        self.hypothesis = material.hypothesis_on(domain)
        order = nodes.permutation(self.cell, self.geometry_degree)
        cells = np.empty(domain.geometry.dofmap.shape, dtype=np.int64)
        cells[:, order] = domain.geometry.dofmap
        self.points = domain.geometry.x[:, : self.gdim].copy()
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
        )
        size = np.ptp(self.points, axis=0).max()
        at = matched(self.V.tabulate_dof_coordinates()[:, : self.gdim], self.model.field_points, size)
        self.order = (self.gdim * at[:, None] + np.arange(self.gdim)).ravel()

    def _orient(self):
        """DOLFINx keeps cells of either orientation; the other side takes positive ones only: reflect the rest."""
        first = [0, 1, 3, 4] if self.cell in nodes.TENSOR else [0, 1, 2, 3]
        corners = self.points[self.cells[:, first[: self.gdim + 1]]]
        negative = np.linalg.det(corners[:, 1:] - corners[:, :1]) < 0
        self.cells[negative] = self.cells[negative][:, nodes.reflection(self.cell, self.geometry_degree)]

    def to_theirs(self, values):
        """Values at our degrees of freedom in their order."""
        return nodes.to_theirs(np.asarray(values), self.order)

    def to_ours(self, values):
        """Values at their degrees of freedom in our order."""
        return np.asarray(values)[self.order]

    def matrix_to_ours(self, csr):
        """Their Csr matrix as a SciPy matrix in our order."""
        matrix = csr_matrix((csr.data, csr.indices, csr.indptr), shape=csr.shape)
        return matrix[self.order][:, self.order]

    def their_facets(self, tags, tag):
        """Vertices, by their point numbers (equal to ours), of the facets that carry a tag, in the order of ours:
        by the numbers of their cells in the mesh's input, then by their place in the cell."""
        facets, topology = tags.find(tag), self.mesh.topology
        topology.create_connectivity(self.gdim - 1, self.gdim)
        topology.create_connectivity(self.gdim, self.gdim - 1)
        to_cell = topology.connectivity(self.gdim - 1, self.gdim)
        to_facet = topology.connectivity(self.gdim, self.gdim - 1)
        cells = [to_cell.links(f)[0] for f in facets]
        places = [list(to_facet.links(c)).index(f) for c, f in zip(cells, facets)]
        facets = facets[np.lexsort((places, topology.original_cell_index[cells]))] if len(facets) else facets
        return mesh.entities_to_geometry(self.mesh, self.gdim - 1, facets).astype(np.int64)


def relative(a, b):
    """Largest difference over the largest entry of b."""
    return np.max(np.abs(a - b)) / np.max(np.abs(b))


def relative_matrices(A, B):
    return np.max(np.abs((A - B).data), initial=0.0) / np.max(np.abs(B.data))


def parted(body, ours, theirs):
    """(largest relative difference, text that says at which nodes) of vectors or sparse matrices in our order."""
    if issparse(ours):
        difference = relative_matrices(ours, theirs)
        parts = (ours - theirs).tocoo()
        if parts.nnz == 0:
            return difference, ""
        k = _worst(parts.data)
        at = (int(parts.row[k]), int(parts.col[k]))
    else:
        difference = relative(ours, theirs)
        at = (_worst(ours - theirs),)
    x = body.V.tabulate_dof_coordinates()[:, : body.gdim]
    places = [f"node at {np.round(x[i // body.gdim], 4).tolist()} component {i % body.gdim}" for i in at]
    return difference, f"{' against '.join(places)}: UFL {ours[at]:.15g}, hand-written {theirs[at]:.15g}"


def _worst(error):
    """Number of the largest entry; a NaN is the largest of all."""
    return int(np.argmax(np.where(np.isnan(error), np.inf, np.abs(error))))


def petsc_to_scipy(matrix):
    indptr, indices, data = matrix.getValuesCSR()
    return csr_matrix((data, indices, indptr), shape=matrix.getSize())


def block(cell, n, geometry_degree=1, distortion=0.08, gdim=None):
    """Distorted unit square or cube on this rank alone; geometry of degree 2 is curved."""
    kind = getattr(mesh.CellType, cell)
    dim = gdim or (2 if cell in ("triangle", "quadrilateral") else 3)
    if dim == 2:
        domain = mesh.create_unit_square(MPI.COMM_SELF, n, n, kind)
    else:
        domain = mesh.create_unit_cube(MPI.COMM_SELF, n, n, n, kind)
    if geometry_degree == 2:
        domain = curved(domain)
    bend(domain, distortion)
    return domain


def bend(domain, amount):
    """Move the inner nodes by a smooth map that keeps the faces of the unit block plane."""
    x = domain.geometry.x
    dim = domain.geometry.dim
    bubble = np.prod(np.sin(np.pi * x[:, :dim]), axis=1)
    for i in range(dim):
        x[:, i] += amount * bubble * np.cos(2.0 * x[:, (i + 1) % dim] + i)


def curved(domain):
    """The same mesh with geometry of degree 2 (mid nodes on the straight edges)."""
    import basix.ufl
    import ufl

    cell, dim = domain.topology.cell_name(), domain.geometry.dim
    V = fem.functionspace(domain, ("Lagrange", 2))
    x = V.tabulate_dof_coordinates()[:, :dim]
    element = basix.ufl.element("Lagrange", cell, 2, shape=(dim,))
    return mesh.create_mesh(MPI.COMM_SELF, V.dofmap.list.astype(np.int64), x, ufl.Mesh(element))
