# SPDX-License-Identifier: MIT
"""Reactions balance the loads, in force and in moment."""

import numpy as np
import pytest
from meshes_and_supports import block, clamp, tagged
from dolfinx import fem

from dolfinx_impact import BodyForce, FollowerPressure, LinearElastic, NeoHookean, StaticProblem, Traction

DENSITY = 1.5
CASES = [
    ("triangle", 1, "plane_strain"),
    ("triangle", 2, "plane_stress"),
    ("quadrilateral", 2, "plane_strain"),
    ("tetrahedron", 1, "3d"),
    ("tetrahedron", 2, "3d"),
    ("hexahedron", 1, "3d"),
    ("hexahedron", 2, "3d"),
]


def ends(domain):
    axis = domain.geometry.dim - 1
    return tagged(domain, low=lambda x: np.isclose(x[axis], 0), high=lambda x: np.isclose(x[axis], 1))


def moment(x, f):
    """About the origin; the z component in the plane."""
    return x[:, 0] @ f[:, 1] - x[:, 1] @ f[:, 0] if x.shape[1] == 2 else np.cross(x, f).sum(axis=0)


@pytest.mark.parametrize("cell, degree, hypothesis", CASES)
def test_traction_and_gravity(cell, degree, hypothesis):
    """Unit block, clamped below: area 1 and volume 1 are exact, since the faces stay plane on the distorted mesh."""
    domain = block(cell, 3, distortion=0.1)
    dim = domain.geometry.dim
    tags = ends(domain)
    V = fem.functionspace(domain, ("Lagrange", degree, (dim,)))
    u = fem.Function(V, name="u")
    t, g = np.array([0.01, -0.02, 0.03])[:dim], np.array([-0.005, 0.004, -0.03])[:dim]
    steel = LinearElastic(1.0, 0.3, DENSITY, hypothesis)
    problem = StaticProblem(u, steel, bcs=[clamp(V, tags, 1)], loads=[Traction(tags, 2, t), BodyForce(g)])
    problem.solve()
    reactions = problem.reactions().x.array.reshape(-1, dim)
    x = V.tabulate_dof_coordinates()[:, :dim]
    total = t + DENSITY * g
    # Sums of a hundred terms with residuals of 1e-13 times the load.
    np.testing.assert_allclose(reactions.sum(axis=0), -total, atol=1e-12)
    top, middle = np.full((1, dim), 0.5), np.full((1, dim), 0.5)
    top[0, -1] = 1.0
    applied = moment(top, t[None]) + moment(middle, DENSITY * g[None])
    np.testing.assert_allclose(moment(x, reactions), -applied, atol=1e-11)
    held = np.zeros(len(x), dtype=bool)
    held[fem.locate_dofs_topological(V, dim - 1, tags.find(1))] = True
    assert np.abs(reactions[~held]).max() < 1e-12 and np.abs(reactions[held]).max() > 1e-4


def test_axisymmetric_weight_is_that_of_the_whole_ring():
    domain = block("quadrilateral", 4, distortion=0.0)
    domain.geometry.x[:, 0] += 1.0
    tags = ends(domain)
    V = fem.functionspace(domain, ("Lagrange", 2, (2,)))
    u = fem.Function(V, name="u")
    steel = LinearElastic(1.0, 0.3, DENSITY, "axisymmetric")
    loads = [BodyForce((0.0, -0.02)), Traction(tags, 2, (0.0, 0.005))]
    problem = StaticProblem(u, steel, bcs=[clamp(V, tags, 1)], loads=loads)
    problem.solve()
    area = np.pi * (2.0**2 - 1.0**2)  # of the ring; its height is 1
    force = problem.reactions().x.array.reshape(-1, 2)[:, 1].sum()
    assert force == pytest.approx(area * (0.02 * DENSITY - 0.005), rel=1e-11)


def test_a_follower_pressure_pushes_along_the_deformed_normal():
    """On a closed part of the surface only its rim counts: force = p times the vector area of the deformed face."""
    domain = block("quadrilateral", 4)
    tags = ends(domain)
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    u = fem.Function(V, name="u")
    p = 0.05
    problem = StaticProblem(
        u,
        NeoHookean(1.0, 0.3, hypothesis="plane_strain"),
        bcs=[clamp(V, tags, 1)],
        loads=[FollowerPressure(tags, 2, p)],
    )
    problem.solve(rtol=1e-13)
    x = V.tabulate_dof_coordinates()[:, :2] + u.x.array.reshape(-1, 2)
    X = V.tabulate_dof_coordinates()
    left, right = (x[np.argmin(np.hypot(X[:, 0] - a, X[:, 1] - 1))] for a in (0, 1))
    along = right - left
    outward = np.array([-along[1], along[0]])  # of the top face, times its length
    total = problem.reactions().x.array.reshape(-1, 2).sum(axis=0)
    np.testing.assert_allclose(total, p * outward, atol=1e-12)
    assert abs(np.linalg.norm(outward) - 1) > 1e-3, "the face has changed its length: the pressure follows it"
