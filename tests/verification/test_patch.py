# SPDX-License-Identifier: MIT
"""Patch test: a linear displacement on the boundary is the solution inside, on distorted and curved meshes."""

import numpy as np
import pytest
from meshes_and_supports import block, every_boundary_dof
from dolfinx import fem

from dolfinx_impact import LinearElastic, NeoHookean, StaticProblem, StVenantKirchhoff
from dolfinx_impact.assembly.operators import PointValues

CELLS = {"triangle": 2, "quadrilateral": 2, "tetrahedron": 3, "hexahedron": 3}
GRADIENT = np.array([[0.03, 0.02, -0.01], [-0.015, 0.02, 0.01], [0.01, -0.02, 0.025]])


def solve(domain, degree, material):
    dim = domain.geometry.dim
    V = fem.functionspace(domain, ("Lagrange", degree, (dim,)))
    H = GRADIENT[:dim, :dim]
    target = fem.Function(V)
    target.interpolate(lambda x: H @ x[:dim])
    u = fem.Function(V, name="u")
    problem = StaticProblem(u, material, bcs=[fem.dirichletbc(target, every_boundary_dof(V))])
    problem.solve(rtol=1e-13)
    return u, target, H


def assert_constant_strain(domain, degree, material, stress):
    u, target, H = solve(domain, degree, material)
    inside = len(u.x.array) // domain.geometry.dim - len(every_boundary_dof(u.function_space))
    assert inside > 0, "the mesh must have nodes inside"
    # Round-off times the condition number of these small meshes, at most 1e3.
    np.testing.assert_allclose(u.x.array, target.x.array, atol=1e-12 * np.abs(target.x.array).max())
    points = np.full((1, domain.topology.dim), 0.3)
    values = PointValues(material.stress(u), points).values()
    expected = np.ravel(stress(H))
    np.testing.assert_allclose(values.reshape(len(values), -1), np.tile(expected, (len(values), 1)), atol=1e-11)


def hooke(hypothesis):
    """Stress of E = 1, nu = 0.3, written out independently of the package."""
    E, nu = 1.0, 0.3
    mu = E / 2.6

    def stress(H):
        e = (H + H.T) / 2
        if hypothesis == "plane_stress":
            return E / (1 - nu**2) * ((1 - nu) * e + nu * np.trace(e) * np.eye(2))
        full = np.zeros((3, 3))
        full[: len(e), : len(e)] = e
        return 2 * mu * (full + nu / (1 - 2 * nu) * np.trace(e) * np.eye(3))

    return stress


@pytest.mark.parametrize("geometry_degree, degree", [(1, 1), (1, 2), (2, 2)])
@pytest.mark.parametrize("cell", CELLS)
def test_constant_strain(cell, geometry_degree, degree):
    domain = block(cell, 3 if CELLS[cell] == 2 else 2, geometry_degree, distortion=0.1)
    hypothesis = "3d" if CELLS[cell] == 3 else "plane_strain"
    assert_constant_strain(domain, degree, LinearElastic(1.0, 0.3, hypothesis=hypothesis), hooke(hypothesis))


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
@pytest.mark.parametrize("degree", [1, 2])
def test_constant_strain_in_plane_stress(cell, degree):
    domain = block(cell, 3, distortion=0.1)
    assert_constant_strain(domain, degree, LinearElastic(1.0, 0.3, hypothesis="plane_stress"), hooke("plane_stress"))


@pytest.mark.parametrize("kind", [StVenantKirchhoff, NeoHookean])
@pytest.mark.parametrize("cell, degree", [("triangle", 2), ("quadrilateral", 1), ("hexahedron", 1)])
def test_constant_strain_at_finite_strain(kind, cell, degree):
    """A uniform deformation is in equilibrium whatever the law; its stress P is written out here."""
    domain = block(cell, 3 if CELLS[cell] == 2 else 2, distortion=0.1)
    hypothesis = "3d" if CELLS[cell] == 3 else "plane_strain"

    def stress(H):
        full = np.zeros((3, 3))
        full[: len(H), : len(H)] = H
        F = np.eye(3) + full
        lmbda, mu = 0.3 / (1.3 * 0.4), 1 / 2.6
        if kind is StVenantKirchhoff:
            E = (F.T @ F - np.eye(3)) / 2
            return F @ (lmbda * np.trace(E) * np.eye(3) + 2 * mu * E)
        inverse = np.linalg.inv(F).T
        return mu * (F - inverse) + lmbda * np.log(np.linalg.det(F)) * inverse

    assert_constant_strain(domain, degree, kind(1.0, 0.3, hypothesis=hypothesis), stress)
