# SPDX-License-Identifier: MIT
"""Bodies that yield on 1, 2 and 3 ranks, and what the law sees of cells of degree 2."""

import basix
import numpy as np
import pytest
import ufl
import yielding_checks
from dolfinx import fem, mesh
from mpi4py import MPI
from on_ranks import rank_tests

import dolfinx_impact as di

test_one_rank, test_several_ranks = rank_tests(yielding_checks)


@pytest.mark.parametrize("kind, hypothesis", [("quadrilateral", "plane_strain"), ("quadrilateral", "axisymmetric"),
                                              ("hexahedron", "3d")])  # fmt: skip
@pytest.mark.parametrize("yield_stress", (1e9, 0.01), ids=["elastic", "yielding"])
def test_mean_stress_of_degree_2_is_a_least_squares_fit(kind, hypothesis, yield_stress):
    """Oracle: in each cell the mean stress is kappa times the linear function that fits tr(eps) best at the points,
    with their weights and volumes (and radii). Plastic flow does not change it. Distorted cells."""
    domain = mesh.create_unit_square(MPI.COMM_SELF, 2, 2, mesh.CellType.quadrilateral)
    if kind == "hexahedron":
        domain = mesh.create_unit_cube(MPI.COMM_SELF, 2, 1, 1, mesh.CellType.hexahedron)
    dim, x = domain.geometry.dim, domain.geometry.x
    x[:, 0] += 0.5
    x[:, :dim] += 0.05 * np.sin(7 * x[:, :dim] + 3 * x[:, dim - 1 :: -1])
    V = fem.functionspace(domain, ("Lagrange", 2, (dim,)))
    u = fem.Function(V, name="u")
    u.x.array[:] = 0.05 * np.random.default_rng(2).uniform(-1, 1, len(u.x.array))
    E, nu = 2.0, 0.3
    steel = di.J2Plasticity(E, nu, 1.0, yield_stress, hypothesis=hypothesis)
    problem = di.ExplicitProblem(u, steel, velocity=fem.Function(V))
    stress = problem.history["stress"].values
    points, weights = basix.make_quadrature(getattr(basix.CellType, kind), problem.history["stress"].degree)
    cells = np.arange(len(stress), dtype=np.int32)
    trace = ufl.div(u) + (u[0] / ufl.SpatialCoordinate(domain)[0] if hypothesis == "axisymmetric" else 0)
    volume = abs(ufl.JacobianDeterminant(domain))
    wanted = ufl.as_vector([trace, volume, *ufl.SpatialCoordinate(domain)])
    values = fem.Expression(wanted, points).eval(domain, cells).reshape(len(cells), len(points), -1)
    kappa = E / (3 * (1 - 2 * nu))
    for cell in cells:
        t, det, place = values[cell, :, 0], values[cell, :, 1], values[cell, :, 2:]
        root = np.sqrt(weights * det * (place[:, 0] if hypothesis == "axisymmetric" else 1.0))
        basis = np.column_stack([np.ones(len(t)), place])
        fit = basis @ np.linalg.lstsq(root[:, None] * basis, root * t, rcond=None)[0]
        found = stress[cell, :, :3].sum(axis=1) / 3
        assert np.abs(found - kappa * fit).max() <= 1e-12 * kappa * np.abs(t).max()
        assert np.abs(found - kappa * t).max() > 1e-2 * kappa * np.abs(t).max(), "the fit differs from what it fits"
    assert (problem.history["plastic_strain"].values.max() > 0.01) == (yield_stress < 1)
