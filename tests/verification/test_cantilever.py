# SPDX-License-Identifier: MIT
"""Cantilever with a parabolic shear at its end, plane stress (Timoshenko & Goodier, Theory of Elasticity, art. 21)."""

import numpy as np
import pytest
import ufl
from meshes_and_supports import rectangle, tagged, value_at
from dolfinx import fem

from dolfinx_impact import LinearElastic, StaticProblem, Traction

LENGTH, HEIGHT, LOAD, E, NU = 8.0, 1.0, 2e-3, 5.0, 0.25
INERTIA = HEIGHT**3 / 12


def exact(x):
    """Displacement of the plane-stress solution; it is free of rotation and translation at the middle of the clamp."""
    s, y = x[0], x[1]
    c = LOAD / (6 * E * INERTIA)
    along = c * y * ((6 * LENGTH - 3 * s) * s + (2 + NU) * (y**2 - HEIGHT**2 / 4))
    across = -c * (3 * NU * y**2 * (LENGTH - s) + (4 + 5 * NU) * HEIGHT**2 * s / 4 + (3 * LENGTH - s) * s**2)
    return np.array([along, across])


def solve(cell, shape, degree):
    domain = rectangle(cell, (0, -HEIGHT / 2), (LENGTH, HEIGHT / 2), shape)
    tags = tagged(domain, end=lambda x: np.isclose(x[0], LENGTH), clamp=lambda x: np.isclose(x[0], 0))
    V = fem.functionspace(domain, ("Lagrange", degree, (2,)))
    u, held = fem.Function(V, name="u"), fem.Function(V)
    held.interpolate(exact)
    bcs = [fem.dirichletbc(held, fem.locate_dofs_topological(V, 1, tags.find(2)))]
    y = ufl.SpatialCoordinate(domain)[1]
    shear = ufl.as_vector([0.0, -LOAD / (2 * INERTIA) * (HEIGHT**2 / 4 - y**2)])
    problem = StaticProblem(
        u, LinearElastic(E, NU, hypothesis="plane_stress"), bcs=bcs, loads=[Traction(tags, 1, shear)]
    )
    problem.solve()
    return u, problem


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
def test_tip_deflection_of_degree_2(cell):
    u, problem = solve(cell, (16, 4), 2)
    tip = value_at(u, (LENGTH, 0.0))[1]
    bending, shear = LOAD * LENGTH**3 / (3 * E * INERTIA), (4 + 5 * NU) * LOAD * HEIGHT**2 * LENGTH / (24 * E * INERTIA)
    # The error in energy is of order h^4 with h = 1/4 of the height: some 1e-5; shear's share of the tip is 1.3 %.
    assert -tip == pytest.approx(bending + shear, rel=1e-4)
    assert abs(-tip / bending - 1) > 5e-3, "bending alone must not pass"
    reactions = problem.reactions().x.array.reshape(-1, 2)
    x = u.function_space.tabulate_dof_coordinates()
    np.testing.assert_allclose(reactions.sum(axis=0), [0.0, LOAD], atol=1e-10 * LOAD * LENGTH)
    moment = np.sum(x[:, 0] * reactions[:, 1] - x[:, 1] * reactions[:, 0])
    assert moment == pytest.approx(LOAD * LENGTH, rel=1e-9)  # about the origin; round-off times the condition number


def test_degree_1_comes_closer_with_the_mesh():
    """Bilinear cells are stiff in bending: from below, with order 2."""
    exact_tip = exact(np.array([LENGTH, 0.0]))[1]
    errors = [
        1 - value_at(solve("quadrilateral", (8 * n, 2 * n), 1)[0], (LENGTH, 0.0))[1] / exact_tip for n in (2, 4, 8)
    ]
    assert errors[0] > errors[1] > errors[2] > 0
    assert np.log2(errors[1] / errors[2]) > 1.85
