# SPDX-License-Identifier: MIT
"""Facets of surfaces: shape functions against Basix, nodes and positions against DOLFINx, normals out of the body."""

import basix
import numpy as np
import basix.ufl
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

from dolfinx_impact import _cpp

CELLS = {
    "triangle": mesh.CellType.triangle,
    "quadrilateral": mesh.CellType.quadrilateral,
    "tetrahedron": mesh.CellType.tetrahedron,
    "hexahedron": mesh.CellType.hexahedron,
}
ROUND_OFF = 1e-13  # sums of a few products of numbers of order one


@pytest.mark.parametrize("degree", (1, 2))
@pytest.mark.parametrize("shape", ("interval", "triangle", "quadrilateral"))
def test_shape_functions_equal_basix(shape, degree, rng):
    ours = _cpp.surface.FacetElement(shape, degree)
    theirs = basix.create_element(
        basix.ElementFamily.P, getattr(basix.CellType, shape), degree, basix.LagrangeVariant.gll_warped
    )
    dim = 1 if shape == "interval" else 2
    assert np.allclose([ours.node(i)[:dim] for i in range(ours.num_nodes)], theirs.points, atol=ROUND_OFF)
    for point in rng.uniform(-0.2, 1.2, size=(5, dim)):
        table = theirs.tabulate(2, point[None])[:, 0, :, 0]
        order = [0, 1, 2] if dim == 1 else [0, 1, 2, 3, 5, 4]  # Basix: 20, 11, 02; ours: 11, 22, 12
        assert np.allclose(ours.tabulate(*point), table[order], atol=50 * ROUND_OFF)


def body(cell, geometry_degree):
    """Unit square or cube with moved nodes, of geometry degree 1 or 2."""
    dim = 2 if cell in ("triangle", "quadrilateral") else 3
    create = mesh.create_unit_square if dim == 2 else mesh.create_unit_cube
    domain = create(MPI.COMM_SELF, *[2] * dim, CELLS[cell])
    if geometry_degree == 2:

        x = domain.geometry.x[:, :dim]
        element = basix.ufl.element("Lagrange", cell, 2, shape=(dim,))
        V = fem.functionspace(domain, ("Lagrange", 2, (dim,)))
        cells = V.dofmap.list
        domain = mesh.create_mesh(
            MPI.COMM_SELF, cells.astype(np.int64), x=V.tabulate_dof_coordinates()[:, :dim], e=element
        )
        x = domain.geometry.x
    x = domain.geometry.x
    x[:, :dim] += 0.04 * np.sin(5 * x[:, :dim] @ np.ones((dim, dim)) + np.arange(dim))
    return domain


@pytest.mark.parametrize("degree", (1, 2))
@pytest.mark.parametrize("geometry_degree", (1, 2))
@pytest.mark.parametrize("cell", CELLS)
def test_positions_nodes_and_normals(cell, geometry_degree, degree, rng):
    domain = body(cell, geometry_degree)
    dim = domain.geometry.dim
    domain.topology.create_connectivity(dim - 1, dim)
    domain.topology.create_connectivity(dim, dim - 1)
    V = fem.functionspace(domain, ("Lagrange", degree, (dim,)))
    facets = mesh.exterior_facet_indices(domain.topology)
    surface = _cpp.surface.make_surface(V._cpp_object, facets)
    assert surface.size == len(facets) and len(set(surface.id.tolist())) == len(facets)
    assert surface.geometry.degree == max(degree, geometry_degree)
    # Nodes: a field that is linear in the coordinates, interpolated, has its values at the facets' nodes.
    position = V.tabulate_dof_coordinates()[:, :dim]
    nodes, X = surface.nodes, surface.X
    if degree == surface.geometry.degree:
        assert np.allclose(position[nodes], X, atol=ROUND_OFF)
    else:
        corners = dim if cell in ("triangle", "quadrilateral", "tetrahedron") else 4
        assert np.allclose(position[nodes[:, :corners]], X[:, :corners], atol=ROUND_OFF)
    # Moved by an affine map, positions are mapped; areas and normals obey the divergence theorem: the integral of the
    # normal over a closed surface vanishes, that of x . n is dim times the volume (to the error of the rule, exact
    # here).
    A, b = np.eye(dim) + 0.2 * rng.normal(size=(dim, dim)), rng.normal(size=dim)
    surface.move((position @ (A - np.eye(dim)).T + b).ravel())
    if degree >= geometry_degree:
        assert np.allclose(surface.x, X @ A.T + b, atol=10 * ROUND_OFF)
    shape = surface.displacement.shape
    points, weights = basix.make_quadrature(getattr(basix.CellType, shape), 8)
    total, volume = np.zeros(3), 0.0
    for f in range(surface.size):
        for point, weight in zip(points, weights):
            values = surface.evaluate(f, *point)
            total += weight * values[6] * values[3:6]
            volume += weight * values[6] * values[:3] @ values[3:6] / dim
    assert np.allclose(total, 0.0, atol=100 * ROUND_OFF)
    one = fem.Constant(domain, 1.0) * ufl.dx(metadata={"quadrature_degree": 8})
    dx = fem.assemble_scalar(fem.form(one))
    if degree >= geometry_degree:
        assert np.isclose(volume, abs(np.linalg.det(A)) * dx, rtol=1e-12)
        assert volume > 0 or np.linalg.det(A) < 0


def test_refusals():
    domain = mesh.create_unit_square(MPI.COMM_SELF, 2, 2)
    domain.topology.create_connectivity(1, 2)
    domain.topology.create_connectivity(2, 1)
    facets = mesh.exterior_facet_indices(domain.topology)
    inner = np.setdiff1d(np.arange(domain.topology.index_map(1).size_local), facets).astype(np.int32)
    make = _cpp.surface.make_surface
    with pytest.raises(ValueError, match="inside the body"):
        make(fem.functionspace(domain, ("Lagrange", 1, (2,)))._cpp_object, inner[:1])
    with pytest.raises(ValueError, match="degree 3"):
        make(fem.functionspace(domain, ("Lagrange", 3, (2,)))._cpp_object, facets)
    with pytest.raises(ValueError, match="one component per dimension"):
        make(fem.functionspace(domain, ("Lagrange", 1))._cpp_object, facets)
    with pytest.raises(ValueError, match="Lagrange"):
        make(fem.functionspace(domain, ("DG", 1, (2,)))._cpp_object, facets)
