# SPDX-License-Identifier: MIT
"""Every integration rule against every monomial it claims to integrate."""

import itertools
from math import factorial

import impact_reference as ir
import numpy as np
import pytest
from reference_meshes import CELLS
from scipy.special import roots_jacobi

TABLES = [("triangle", d) for d in range(1, 9)] + [("tetrahedron", d) for d in range(1, 7)]


def simplex_error(points, weights, degree):
    """Largest error over all monomials of total degree <= degree: exact value prod(e_i!) / (sum e_i + d)!."""
    d, worst = points.shape[1], 0.0
    for e in itertools.product(range(degree + 1), repeat=d):
        if sum(e) <= degree:
            exact = np.prod([factorial(k) for k in e]) / factorial(sum(e) + d)
            worst = max(worst, abs(weights @ np.prod(points**e, axis=1) - exact))
    return worst


def box_error(points, weights, degree):
    """Largest error over all monomials of degree <= degree in each variable on [-1, 1]^d."""
    d, worst = points.shape[1], 0.0
    for e in itertools.product(range(degree + 1), repeat=d):
        exact = np.prod([0 if k % 2 else 2 / (k + 1) for k in e])
        worst = max(worst, abs(weights @ np.prod(points**e, axis=1) - exact))
    return worst


@pytest.mark.parametrize("cell, degree", TABLES)
def test_simplex_tables(cell, degree):
    points, weights = ir.quadrature(cell, f"table:{degree}")
    assert simplex_error(points, weights, degree) < 1e-16 * 10  # sums of up to 24 terms below 1/2
    assert weights.min() > 0
    assert points.min() > 0 and points.sum(axis=1).max() < 1  # all points strictly inside


@pytest.mark.parametrize("cell, degree", [("triangle", 4), ("triangle", 6), ("tetrahedron", 2), ("tetrahedron", 6)])
def test_the_monomial_test_can_fail(cell, degree):
    points, weights = ir.quadrature(cell, f"table:{degree}")
    assert simplex_error(points, weights, degree + 1) > 1e-8
    points[0, 0] += 1e-6
    assert simplex_error(points, weights, degree) > 1e-9


@pytest.mark.parametrize("cell", ["triangle", "tetrahedron"])
@pytest.mark.parametrize("degree", range(0, 11))
def test_collapsed_gauss_jacobi(cell, degree):
    points, weights = ir.quadrature(cell, f"gauss_jacobi:{degree}")
    m = (degree + 2) // 2
    assert len(weights) == m ** points.shape[1]
    assert simplex_error(points, weights, 2 * m - 1) < 1e-14
    # the same points as the definition evaluated with SciPy's Gauss-Jacobi roots
    s, ws = roots_jacobi(m, 0, 0)
    t, wt = roots_jacobi(m, 1, 0)
    if cell == "triangle":
        expected = [[(1 + a) * (1 - b) / 4, (1 + b) / 2, u * v / 8] for b, v in zip(t, wt) for a, u in zip(s, ws)]
    else:
        r, wr = roots_jacobi(m, 2, 0)
        expected = [
            [(1 + a) * (1 - b) * (1 - c) / 8, (1 + b) * (1 - c) / 4, (1 + c) / 2, u * v * w / 64]
            for c, w in zip(r, wr)
            for b, v in zip(t, wt)
            for a, u in zip(s, ws)
        ]
    assert np.allclose(np.column_stack([points, weights]), expected, atol=1e-13)  # two eigenvalue solvers


@pytest.mark.parametrize("cell", ["interval", "quadrilateral", "hexahedron"])
@pytest.mark.parametrize("name", ["table", "gauss_jacobi"])
@pytest.mark.parametrize("degree", [1, 2, 3, 5, 8])
def test_gauss_legendre(cell, name, degree):
    points, weights = ir.quadrature(cell, f"{name}:{degree}")
    m = (degree + 2) // 2
    assert len(weights) == m ** points.shape[1]
    assert box_error(points, weights, 2 * m - 1) < 5e-14  # eigenvalue solver, sums up to volume 8


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("degree", [1, 2])
def test_default_rules_are_exact_on_affine_cells(cell, degree):
    """Default stiffness and mass equal those of a rule of much higher degree."""
    solid = cell in ("tetrahedron", "hexahedron")
    material = ir.Material(200.0, 0.3, 7.0, "3d" if solid else "plane_strain")
    A = np.array([[2, 0.3, 0.1], [0.4, 1.5, -0.2], [0.2, 0.1, 1.2]])
    nodes = ir.reference_nodes(cell, 1)
    X = nodes @ A[: nodes.shape[1], : nodes.shape[1]]
    for function in (ir.element_stiffness, ir.element_mass):
        exact = function(cell, X, material, degree, 1, "gauss_jacobi:12")
        # rounding only, relative to the largest entry
        assert np.abs(function(cell, X, material, degree, 1) - exact).max() < 1e-13 * np.abs(exact).max()


def test_points_and_weights_can_be_given():
    material = ir.Material(200.0, 0.3, hypothesis="plane_stress")
    X = ir.reference_nodes("triangle", 1)
    given = ir.element_stiffness("triangle", X, material, rule=([[1 / 3, 1 / 3]], [0.5]))
    assert np.allclose(given, ir.element_stiffness("triangle", X, material), rtol=1e-14)
    halved = ir.element_stiffness("triangle", X, material, rule=([[1 / 3, 1 / 3]], [0.25]))
    assert np.allclose(halved, given / 2, rtol=1e-14)


def test_errors():
    for bad in ["table", "table:", "table:-1", "gauss:3", "table:2.5", ""]:
        with pytest.raises(ValueError, match="unknown quadrature rule"):
            ir.quadrature("triangle", bad)
    with pytest.raises(ValueError, match='reach degree 6, not 7: use "gauss_jacobi:7"'):
        ir.quadrature("tetrahedron", "table:7")
    with pytest.raises(ValueError, match="points of shape .n, 2."):
        ir.element_mass(
            "triangle", ir.reference_nodes("triangle", 1), ir.Material(1, 0, 1, "plane_strain"), rule=([[0.3]], [1])
        )
    with pytest.raises(ValueError, match="unknown purpose"):
        ir.default_rule("heat", "triangle", 1)
