# SPDX-License-Identifier: MIT
"""Cells, shape functions and integration rules.

Every integral of this package gets its points and weights from `quadrature` and the name of its default rule from
`default_rule`. Both are looked up in this module at each call, so that tests can replace them by a wrong rule.
"""

import numpy as np

from . import _reference
from .array_types import ArrayLike, FloatArray, Rule


def reference_nodes(cell_type: str, degree: int) -> FloatArray:
    """Nodes of the reference cell in the node order of this package.

    Simplices have vertices at the origin and at 1 on each axis; tensor-product cells fill [-1, 1]^d. The order is:
    vertices (counter-clockwise, bottom face before top face), edge midpoints, face midpoints, centre.

    - triangle: 0 1 2 | 01 12 20
    - quadrilateral: 0 1 2 3 | 01 12 23 30 | centre
    - tetrahedron: 0 1 2 3 | 01 12 20 03 13 23
    - hexahedron: 0-3 bottom, 4-7 top | 01 12 23 30 45 56 67 74 04 15 26 37 | faces x- x+ y- y+ z- z+ | centre

    Args:
        cell_type: "interval", "triangle", "quadrilateral", "tetrahedron" or "hexahedron".
        degree: degree of the element, 1 or 2.

    Returns:
        Reference coordinates of the nodes, shape (num_nodes, tdim) [1].

    Raises:
        ValueError: an unknown cell, or a degree other than 1 and 2.
    """
    return _reference.reference_nodes(cell_type, degree)


def shape_functions(cell_type: str, degree: int, points: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Lagrange shape functions and their derivatives; Zienkiewicz & Taylor vol. 1 ch. 4.

    Args:
        cell_type: cell, as in `reference_nodes`.
        degree: degree of the element, 1 or 2.
        points: reference coordinates, shape (num_points, tdim) [1].

    Returns:
        N, shape (num_points, num_nodes) [1], and dN, shape (num_points, num_nodes, tdim) [1].
    """
    N, dN = _reference.shape_functions(cell_type, degree, np.ascontiguousarray(points, dtype=float))
    return N, np.array(dN).reshape(N.shape + (-1,))


def quadrature(cell_type: str, rule: str) -> tuple[FloatArray, FloatArray]:
    """Points and weights of a named rule on the reference cell.

    - "table:D": tables exact to degree D on simplices (positive weights, points inside; D <= 8 on triangles, 6 on
      tetrahedra), Gauss-Legendre on tensor-product cells and the interval.
    - "gauss_jacobi:D": collapsed Gauss-Jacobi product with (D + 2) // 2 points per direction on simplices,
      Gauss-Legendre with as many on tensor-product cells.

    Args:
        cell_type: cell, as in `reference_nodes`.
        rule: name of the rule.

    Returns:
        Points, shape (num_points, tdim) [1], and weights, shape (num_points) [1].

    Raises:
        ValueError: an unknown name, or a degree beyond the tables.
    """
    return _reference.quadrature(cell_type, rule)


def default_rule(
    purpose: str | None,
    cell_type: str,
    degree: int | None,
    geometry_degree: int | None = 1,
    axisymmetric: bool | None = False,
) -> str:
    """Name of the rule that is used when none is given.

    On affine cells every integral of a linear problem is exact, apart from the hoop terms N N / r of an axisymmetric
    stiffness. Masses and loads are exact on distorted and curved cells too.

    Args:
        purpose: "stiffness", "finite_strain", "mass", "load" or "facet".
        cell_type: cell that is integrated over; for "facet" the cell type of the facet.
        degree: degree of the field, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.
        axisymmetric: whether integrands carry the factor 2 pi r.

    Returns:
        A name for `quadrature`.
    """
    return _reference.default_rule(purpose, cell_type, degree, geometry_degree, axisymmetric)


def facet_type(cell_type: str) -> str:
    """Cell type of a cell's facets.

    Args:
        cell_type: "triangle", "quadrilateral", "tetrahedron" or "hexahedron".

    Returns:
        "interval", "triangle" or "quadrilateral".
    """
    return _reference.facet_type(cell_type)


def facets(cell_type: str) -> list[list[int]]:
    """Local vertices of every facet of a cell.

    Args:
        cell_type: cell, as in `facet_type`.

    Returns:
        Vertices by facet, in an order that makes the facet's normal point outwards.
    """
    return _reference.facets(cell_type)


def facet_nodes(cell_type: str, degree: int, facet: int) -> list[int]:
    """Local nodes of one facet of a cell.

    Args:
        cell_type: cell, as in `facet_type`.
        degree: degree of the element, 1 or 2.
        facet: local number of the facet.

    Returns:
        Nodes in the order of the facet's own element.
    """
    return _reference.facet_nodes(cell_type, degree, facet)


def points_and_weights(
    cell_type: str,
    rule: Rule,
    purpose: str | None,
    degree: int | None,
    geometry_degree: int | None,
    axisymmetric: bool | None,
) -> tuple[FloatArray, FloatArray]:
    """Points and weights of a `rule` argument. What follows it is needed only where the rule is None.

    Args:
        cell_type: cell that is integrated over.
        rule: None (the default rule of the purpose), a name, or a pair (points, weights).
        purpose: what the integral is for, as in `default_rule`.
        degree: degree of the field, 1 or 2.
        geometry_degree: degree of the geometry, 1 or 2.
        axisymmetric: whether integrands carry the factor 2 pi r.

    Returns:
        Points, shape (num_points, tdim) [1], and weights, shape (num_points) [1].
    """
    if rule is None:
        rule = default_rule(purpose, cell_type, degree, geometry_degree, axisymmetric)
    if isinstance(rule, str):
        rule = quadrature(cell_type, rule)
    points, weights = rule
    return np.ascontiguousarray(points, dtype=float), np.ascontiguousarray(weights, dtype=float)
