# SPDX-License-Identifier: MIT
"""Cells, shape functions and integration rules.

Every integral of this package gets its points and weights from `quadrature` and the name of its default rule from
`default_rule`, both looked up in this module when called: replace them here to see what a wrong rule does.
"""

import numpy as np

from . import _reference


def reference_nodes(cell_type, degree):
    """Nodes of the own reference cell in the own order, shape (num_nodes, tdim) [1].

    Simplices have vertices at the origin and at 1 on each axis, tensor cells fill [-1, 1]^d. Order: vertices
    (counter-clockwise, bottom face before top face), mid-edges, mid-faces, centre:
    triangle 0 1 2 | 01 12 20; quadrilateral 0 1 2 3 | 01 12 23 30 | centre;
    tetrahedron 0 1 2 3 | 01 12 20 03 13 23;
    hexahedron 0-3 bottom, 4-7 top | 01 12 23 30 45 56 67 74 04 15 26 37 | faces x- x+ y- y+ z- z+ | centre.
    ValueError for an unknown cell or a degree other than 1 and 2.
    """
    return _reference.reference_nodes(cell_type, degree)


def shape_functions(cell_type, degree, points):
    """Lagrange shape functions at points (num_points, tdim) of the reference cell.

    Returns N (num_points, num_nodes) and dN (num_points, num_nodes, tdim). Zienkiewicz & Taylor vol. 1 ch. 4.
    """
    N, dN = _reference.shape_functions(cell_type, degree, np.ascontiguousarray(points, dtype=float))
    return N, np.array(dN).reshape(N.shape + (-1,))


def quadrature(cell_type, rule):
    """Points (num_points, tdim) and weights (num_points) of a named rule on the reference cell.

    "table:D": typed tables exact to degree D on simplices (weights positive, points inside; D <= 8 on triangles, 6 on
    tetrahedra), Gauss-Legendre on tensor cells and the interval. "gauss_jacobi:D": collapsed Gauss-Jacobi product
    with (D + 2) // 2 points per direction on simplices, Gauss-Legendre with as many on tensor cells.
    ValueError for an unknown name or a degree beyond the tables.
    """
    return _reference.quadrature(cell_type, rule)


def default_rule(purpose, cell_type, degree, geometry_degree=1, axisymmetric=False):
    """Name of the rule used when none is given; purpose is "stiffness", "finite_strain", "mass", "load" or "facet".

    Affine cells: every integral of a linear problem is exact but the hoop terms N N / r of an axisymmetric stiffness.
    Masses and loads are exact on distorted and curved cells too. For "facet" the cell is the facet's.
    """
    return _reference.default_rule(purpose, cell_type, degree, geometry_degree, axisymmetric)


def facet_type(cell_type):
    """Cell type of the facets: interval, triangle or quadrilateral."""
    return _reference.facet_type(cell_type)


def facets(cell_type):
    """Local vertices of every facet, in an order that makes the facet's normal point outwards."""
    return _reference.facets(cell_type)


def facet_nodes(cell_type, degree, facet):
    """Local nodes of facet number `facet`, in the order of the facet's own element."""
    return _reference.facet_nodes(cell_type, degree, facet)


def points_and_weights(cell_type, rule, purpose, degree, geometry_degree, axisymmetric):
    """Resolves a `rule` argument: None (default rule), a name, or a pair (points, weights)."""
    if rule is None:
        rule = default_rule(purpose, cell_type, degree, geometry_degree, axisymmetric)
    if isinstance(rule, str):
        rule = quadrature(cell_type, rule)
    points, weights = rule
    return np.ascontiguousarray(points, dtype=float), np.ascontiguousarray(weights, dtype=float)
