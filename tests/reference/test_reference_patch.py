# SPDX-License-Identifier: MIT
"""Patch tests, constant strain and rigid motions for every cell, degree, geometry degree and hypothesis."""

import impact_reference as ir
import numpy as np
import pytest
from reference_meshes import box, boundary_nodes, dofs

PLANE = ["plane_strain", "plane_stress", "axisymmetric"]
CASES = [
    (cell, degree, geometry, hypothesis)
    for cell in ["triangle", "quadrilateral", "tetrahedron", "hexahedron"]
    for degree in (1, 2)
    for geometry in (1, 2)
    for hypothesis in (PLANE if cell in ("triangle", "quadrilateral") else ["3d"])
]
GRADIENT = np.array([[0.02, 0.013, -0.007], [-0.005, 0.03, 0.011], [0.009, -0.004, -0.016]])


def patch(cell, degree, geometry, hypothesis, law="linear_elastic"):
    """Distorted mesh; curved too where the field can represent linear functions on it (degree >= geometry degree)."""
    solid = hypothesis == "3d"
    bend = 0.06 if degree == geometry == 2 else 0.0

    def mapping(x):
        y = np.array(x)
        y[0] += bend * np.sin(2 * x[1]) + (0.5 if hypothesis == "axisymmetric" else 0)
        y[1] += bend * x[0] ** 2 + 0.1 * x[0]
        return y

    points, cells = box(cell, (2, 2, 2) if solid else (3, 3), geometry, mapping, distort=0.2)
    material = ir.Material(200.0, 0.3, 7.0, hypothesis, law)
    return ir.Model(points, cells, cell, material, degree=degree, geometry_degree=geometry), material


def linear_field(x, hypothesis, factor=1.0):
    """Displacements of constant strain: u = G x, or u_r = a r, u_z = b z + c r-free shift if axisymmetric."""
    if hypothesis == "axisymmetric":
        return factor * np.column_stack([0.02 * x[:, 0], 0.01 - 0.03 * x[:, 1]])
    d = x.shape[1]
    return factor * (x @ GRADIENT[:d, :d].T + 0.1)


def strain(hypothesis):
    G = GRADIENT
    if hypothesis == "axisymmetric":
        return np.array([0.02, -0.03, 0.02, 0.0])
    if hypothesis == "3d":
        return np.array([G[0, 0], G[1, 1], G[2, 2], G[0, 1] + G[1, 0], G[1, 2] + G[2, 1], G[0, 2] + G[2, 0]])
    return np.array([G[0, 0], G[1, 1], G[0, 1] + G[1, 0]])


@pytest.mark.parametrize("cell, degree, geometry, hypothesis", CASES)
def test_patch(cell, degree, geometry, hypothesis):
    model, material = patch(cell, degree, geometry, hypothesis)
    exact = linear_field(model.field_points, hypothesis).reshape(-1)
    fixed = dofs(boundary_nodes(model), range(model.field_points.shape[1]), model.field_points.shape[1])
    assert len(fixed) < model.num_dofs  # there are inner nodes to be found
    u, _ = model.solve_static(fixed, exact[fixed])
    assert np.abs(u - exact).max() < 1e-13  # displacements of 0.1: rounding of a small solve
    stresses, _ = model.stress(u)
    expected = material.elasticity_matrix @ strain(hypothesis)
    assert np.abs(stresses - expected).max() < 1e-11  # stresses of 10


@pytest.mark.parametrize("law", ["st_venant_kirchhoff", "neo_hookean"])
@pytest.mark.parametrize("cell, degree, geometry, hypothesis", [c for c in CASES if c[1] == c[2]])
def test_patch_at_finite_strain(cell, degree, geometry, hypothesis, law):
    model, _ = patch(cell, degree, geometry, hypothesis, law)
    exact = linear_field(model.field_points, hypothesis, 8.0).reshape(-1)  # strains up to 0.24
    fixed = dofs(boundary_nodes(model), range(model.field_points.shape[1]), model.field_points.shape[1])
    result = model.solve_static(fixed, exact[fixed], tolerance=1e-12)
    assert np.abs(result.u - exact).max() < 1e-11  # Newton to 1e-12
    stresses, _ = model.stress(result.u)
    assert np.ptp(stresses, axis=(0, 1)).max() < 1e-9 * np.abs(stresses).max()


@pytest.mark.parametrize("cell, degree, geometry, hypothesis", CASES)
def test_rigid_motions_and_no_others(cell, degree, geometry, hypothesis):
    """Zero eigenvalues of one element: 3 in the plane, 6 in space, 1 if axisymmetric."""
    model, material = patch(cell, degree, geometry, hypothesis)
    expected = {"3d": 6, "axisymmetric": 1}.get(hypothesis, 3)
    for c in range(0, len(model.cells), 5):
        K = ir.element_stiffness(cell, model.points[model.cells[c]], material, degree, geometry)
        assert np.abs(K - K.T).max() < 1e-13 * np.abs(K).max()
        values = np.linalg.eigvalsh(K)
        # zeros are rounding of the largest; the softest elastic mode of these cells is above 1e-5 of it
        assert np.sum(np.abs(values) < 1e-12 * values[-1]) == expected
        assert values[expected] > 1e-6 * values[-1]
        assert values[0] > -1e-12 * values[-1]
    modes = model.rigid_modes()
    assert modes.shape == (model.num_dofs, expected)
    assert np.linalg.matrix_rank(modes) == expected
    K = model.stiffness()
    assert max(np.abs(K.dot(mode)).max() for mode in modes.T) < 1e-11  # stiffness entries of 1e3


@pytest.mark.parametrize("cell, degree, geometry, hypothesis", CASES)
def test_b_matrix_gives_the_strain(cell, degree, geometry, hypothesis):
    model, _ = patch(cell, degree, geometry, hypothesis)
    u = linear_field(model.field_points, hypothesis)
    point = ir.quadrature(cell, "table:1")[0][0]
    X = model.points[model.cells[0]]
    B = ir.element_b_matrix(cell, X, point, hypothesis, degree, geometry)
    assert np.abs(B @ u[model.field_cells[0]].reshape(-1) - strain(hypothesis)).max() < 1e-14  # sums of 27 terms of 0.1


@pytest.mark.parametrize("cell, degree, geometry, hypothesis", CASES)
def test_stiffness_is_b_transpose_d_b(cell, degree, geometry, hypothesis):
    """The element routine against the formula, with B point by point and the Jacobian taken here."""
    model, material = patch(cell, degree, geometry, hypothesis)
    X = model.points[model.cells[1]]
    points, weights = ir.quadrature(cell, "gauss_jacobi:5")
    N, dN = ir.shape_functions(cell, geometry, points)
    K = 0
    for q in range(len(weights)):
        B = ir.element_b_matrix(cell, X, points[q], hypothesis, degree, geometry)
        volume = weights[q] * np.linalg.det(dN[q].T @ X)
        volume *= 2 * np.pi * (N[q] @ X)[0] if hypothesis == "axisymmetric" else 1
        K = K + B.T @ material.elasticity_matrix @ B * volume
    element = ir.element_stiffness(cell, X, material, degree, geometry, "gauss_jacobi:5")
    assert np.abs(K - element).max() < 1e-13 * np.abs(K).max()
