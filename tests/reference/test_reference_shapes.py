# SPDX-License-Identifier: MIT
"""Shape functions, node order and facets of the hand-written elements."""

import impact_reference as ir
import numpy as np
import pytest
from reference_meshes import CELLS

NUM_NODES = {"triangle": (3, 6), "quadrilateral": (4, 9), "tetrahedron": (4, 10), "hexahedron": (8, 27)}
PAIRS = [(cell, degree) for cell in CELLS + ["interval"] for degree in (1, 2)]


def some_points(cell):
    """Points inside and outside the cell: the identities are polynomial and hold everywhere."""
    return np.random.default_rng(3).uniform(-1.2, 1.2, (7, ir.reference_nodes(cell, 1).shape[1]))


@pytest.mark.parametrize("cell, degree", PAIRS)
def test_partition_of_unity_and_linear_completeness(cell, degree):
    x = some_points(cell)
    N, dN = ir.shape_functions(cell, degree, x)
    # rounding of at most 27 terms of size about 10
    assert np.allclose(N.sum(axis=1), 1, atol=1e-13)
    assert np.allclose(dN.sum(axis=1), 0, atol=1e-13)
    assert np.allclose(N @ ir.reference_nodes(cell, degree), x, atol=1e-13)


@pytest.mark.parametrize("cell, degree", PAIRS)
def test_kronecker(cell, degree):
    N, _ = ir.shape_functions(cell, degree, ir.reference_nodes(cell, degree))
    assert np.abs(N - np.eye(len(N))).max() < 1e-15  # products of exact zeros and ones


@pytest.mark.parametrize("cell, degree", PAIRS)
def test_derivatives(cell, degree):
    x, h = some_points(cell), 1e-3
    _, dN = ir.shape_functions(cell, degree, x)
    for k in range(x.shape[1]):
        step = h * np.eye(x.shape[1])[k]
        difference = ir.shape_functions(cell, degree, x + step)[0] - ir.shape_functions(cell, degree, x - step)[0]
        # central differences are exact for quadratics in one variable; what is left is rounding / h
        assert np.allclose(difference / (2 * h), dN[:, :, k], atol=1e-11)


@pytest.mark.parametrize("cell", CELLS)
def test_number_and_order_of_nodes(cell):
    first, second = ir.reference_nodes(cell, 1), ir.reference_nodes(cell, 2)
    assert (len(first), len(second)) == NUM_NODES[cell]
    assert np.array_equal(second[: len(first)], first)  # vertices come first
    assert len(np.unique(second, axis=0)) == len(second)
    if cell in ("quadrilateral", "hexahedron"):
        assert np.array_equal(second[-1], np.zeros(second.shape[1]))  # the centre comes last


def test_order_of_known_elements():
    assert np.allclose(ir.reference_nodes("triangle", 2)[3:], [[0.5, 0], [0.5, 0.5], [0, 0.5]])
    assert np.allclose(ir.reference_nodes("quadrilateral", 2)[4:8], [[0, -1], [1, 0], [0, 1], [-1, 0]])
    assert np.allclose(ir.reference_nodes("hexahedron", 2)[20:26], np.kron(np.eye(3), [[-1], [1]]))
    assert np.allclose(ir.reference_nodes("tetrahedron", 2)[7], [0, 0, 0.5])


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("degree", [1, 2])
def test_facets_point_outwards_and_hold_their_nodes(cell, degree):
    nodes = ir.reference_nodes(cell, degree)
    facet_type = ir.facet_type(cell)
    s = ir.reference_nodes(facet_type, degree)
    N, dN = ir.shape_functions(facet_type, 1, s)
    for number, facet in enumerate(ir.facets(cell)):
        X = nodes[facet]
        # the facet's nodes sit where the facet's own element has them
        assert np.allclose(nodes[ir.facet_nodes(cell, degree, number)], N @ X, atol=1e-15)
        tangent = dN[0].T @ X
        normal = np.array([tangent[0, 1], -tangent[0, 0]]) if len(tangent) == 1 else np.cross(*tangent)
        assert normal @ (X.mean(axis=0) - nodes.mean(axis=0)) > 0


def test_errors():
    with pytest.raises(ValueError, match="unknown cell type 'wedge'.*hexahedron"):
        ir.reference_nodes("wedge", 1)
    with pytest.raises(ValueError, match="degree is 3"):
        ir.shape_functions("triangle", 3, [[0.2, 0.2]])
    with pytest.raises(ValueError, match="2 coordinates each, but 3"):
        ir.shape_functions("triangle", 1, [[0.2, 0.2, 0.2]])
    with pytest.raises(ValueError, match="facet 4 does not exist"):
        ir.facet_nodes("tetrahedron", 1, 4)
