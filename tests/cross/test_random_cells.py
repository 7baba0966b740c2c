# SPDX-License-Identifier: MIT
"""The random cells of level element are what it says: distorted, curved, not inverted, all different, repeatable."""

import impact_reference
import numpy as np
import pytest

from impact_verify import element, nodes

CELLS = ("triangle", "quadrilateral", "tetrahedron", "hexahedron")


def cells(cell, degree, hypothesis=None, count=100, seed=3):
    rng = np.random.default_rng(seed)
    return np.array([nodes.random_cell(rng, cell, degree, hypothesis) for _ in range(count)])


def jacobians(cell, degree, X):
    points, _ = impact_reference.quadrature(cell, "gauss_jacobi:5")
    _, dN = impact_reference.shape_functions(cell, degree, points)
    order = nodes.permutation(cell, degree)
    theirs = np.empty_like(X)
    theirs[:, order] = X
    return np.einsum("qnd,cni->cqid", dN, theirs)


def bend(cell, degree, X):
    """Distance of the nodes from the best affine image of the reference cell, over the cell's size; per cell."""
    reference = nodes.nodes(cell, degree)
    basis = np.column_stack([np.ones(len(reference)), reference])
    fit, *_ = np.linalg.lstsq(basis, np.moveaxis(X, 0, 1).reshape(len(reference), -1), rcond=None)
    rest = np.moveaxis(X, 0, 1).reshape(len(reference), -1) - basis @ fit
    rest = np.linalg.norm(rest.reshape(len(reference), len(X), -1), axis=2).max(axis=0)
    return rest / np.ptp(X, axis=1).max(axis=1)


@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("cell", CELLS)
def test_no_cell_is_inverted(cell, degree):
    det = np.linalg.det(jacobians(cell, degree, cells(cell, degree)))
    assert np.all(np.abs(det) > 0) and np.all(np.sign(det) == np.sign(det[0, 0]))


@pytest.mark.parametrize("cell, degree", [(c, d) for c in CELLS for d in (1, 2) if d == 2 or c[0] in "qh"])
def test_cells_that_can_be_are_not_affine(cell, degree):
    """Straight simplices are affine always; everything else must be distorted or curved, and by more than round-off."""
    X = cells(cell, degree)
    assert np.all(bend(cell, degree, X) > 1e-3) and np.median(bend(cell, degree, X)) > 0.02
    det = np.linalg.det(jacobians(cell, degree, X))
    spread = np.ptp(det, axis=1) / np.abs(det).max(axis=1)
    assert np.all(spread > 1e-3), "the Jacobian must vary within every cell"


@pytest.mark.parametrize("cell", CELLS)
def test_edges_of_degree_2_are_curved(cell):
    """The middle of an edge is off the straight line between its ends."""
    reference = nodes.nodes(cell, 2)
    corners = nodes.nodes(cell, 1)
    X = cells(cell, 2)
    off = []
    for i, a in enumerate(corners):
        for j, b in enumerate(corners[:i]):
            middle = np.flatnonzero(np.linalg.norm(reference - (a + b) / 2, axis=1) < 1e-12)
            if len(middle):
                off.append(
                    np.linalg.norm(X[:, middle[0]] - (X[:, i] + X[:, j]) / 2, axis=1) / np.ptp(X, axis=1).max(axis=1)
                )
    assert len(off) >= {"triangle": 3, "quadrilateral": 4, "tetrahedron": 6, "hexahedron": 12}[cell]
    assert np.all(np.max(off, axis=0) > 1e-3)


@pytest.mark.parametrize("cell", CELLS)
def test_cells_differ_and_are_the_same_for_the_same_seed(cell):
    X = cells(cell, 1)
    assert len(np.unique(np.round(X.reshape(len(X), -1), 12), axis=0)) == len(X)
    np.testing.assert_array_equal(X, cells(cell, 1))
    assert np.ptp(np.ptp(X, axis=1).max(axis=1)) > 0.5, "small and large cells"


def test_axisymmetric_cells_stay_off_the_axis():
    for cell in ("triangle", "quadrilateral"):
        for degree in (1, 2):
            assert cells(cell, degree, "axisymmetric")[:, :, 0].min() >= 0.5 - 1e-15


def test_the_hundred_cells_of_a_comparison_are_these(monkeypatch):
    """`difference` hands random cells to both sides: as many as asked for, each to the hand-written solver once."""
    seen = []
    right = impact_reference.element_stiffness
    monkeypatch.setattr(
        impact_reference,
        "element_stiffness",
        lambda cell, X, *a, **k: (seen.append(X.copy()), right(cell, X, *a, **k))[1],
    )
    case = ("linear_elastic.tangent", "hexahedron", 1, 1, "3d")
    worst, _ = element.difference(case, 100)
    assert worst <= element.TOLERANCE and len(seen) == 100
    ours = np.array(seen)[:, nodes.permutation("hexahedron", 1)]
    assert np.all(bend("hexahedron", 1, ours) > 1e-3)
    seen.clear()
    element.difference(case, 100, seed=1)
    assert not np.allclose(np.array(seen)[:, nodes.permutation("hexahedron", 1)], ours)
