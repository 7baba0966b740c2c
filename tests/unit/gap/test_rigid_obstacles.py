# SPDX-License-Identifier: MIT
"""Surfaces of rigid obstacles: closest points against closed forms and brute force, derivatives by differences."""

import numpy as np
import pytest
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import _cpp

STEP = 1e-5  # of central differences: errors of its square and of 1e-16/step


def derivatives_are_right(obstacle, x, tolerance=1e-8):
    gdim = len(x)
    gap, normal, hessian = (a[0] for a in obstacle.evaluate(x))
    steps = STEP * np.eye(gdim)
    up, down = (obstacle.evaluate((x + s * steps).ravel()) for s in (1, -1))
    assert np.isclose(np.linalg.norm(normal), 1.0, rtol=1e-13)
    np.testing.assert_allclose((up[0] - down[0]) / (2 * STEP), normal, atol=tolerance)
    np.testing.assert_allclose((up[1] - down[1]) / (2 * STEP), hessian, atol=tolerance)
    np.testing.assert_allclose(hessian @ normal, 0.0, atol=1e-9)
    return gap, normal


def dense(height, bounds, n):
    """Points of a surface over its bounds."""
    axes = [np.linspace(*b, n) for b in np.reshape(bounds, (-1, 2))]
    grid = np.meshgrid(*axes, indexing="ij")
    return np.stack([*(g.ravel() for g in grid), height(*grid).ravel()], axis=1)


@pytest.mark.parametrize("gdim", (2, 3))
def test_heights_are_signed_distances(gdim, rng):
    """A wavy surface, against the nearest of many points of it, above and below, and beyond its bounds."""
    if gdim == 2:
        height, bounds, normal = lambda x: 0.2 * np.sin(2 * x), (-2.0, 2.0), (0.0, 1.0)
        surface = dense(height, bounds, 40001)
    else:
        height, bounds = lambda x, y: 0.2 * np.sin(2 * x) * np.cos(1.5 * y), ((-1.0, 1.0), (-1.5, 1.0))
        surface, normal = dense(height, bounds, 801), (0.0, 0.0, 1.0)
    made = di.RigidSurface.from_function(height, bounds, np.zeros(gdim), normal)
    obstacle = made.obstacle(gdim)
    for _ in range(20):
        x = np.append(rng.uniform(-0.6, 0.6, size=gdim - 1), rng.uniform(-0.5, 0.6))
        gap, normal = derivatives_are_right(obstacle, x)
        nearest = np.linalg.norm(surface - x, axis=1).min()
        # The points are 1e-4 (plane) and 3e-3 apart: their distance is larger by half its square over the distance.
        assert abs(abs(gap) - nearest) < 1e-7 + (1e-9 if gdim == 2 else 5e-6) / nearest
        assert np.sign(gap) == np.sign(x[-1] - height(*x[:-1]))
    # Beyond the bounds it goes on straight.
    end = np.reshape(bounds, (-1, 2))[0, 1]
    derivatives_are_right(obstacle, np.append(np.full(gdim - 1, 0.1), 0.3) + (end + 0.4) * np.eye(gdim)[0])
    if gdim == 2:
        slope = 0.4 * np.cos(4.0)
        line = np.array([-slope, 1.0]) / np.hypot(slope, 1.0)
        x = np.array([2.7, 0.3])
        expected = line @ (x - [2.0, 0.2 * np.sin(4.0)])
        # The slope at the end errs by the tolerance over a cell, 4e-7/0.06, and x is 0.7 beyond.
        assert obstacle.evaluate(x)[0][0] == pytest.approx(expected, abs=2e-5)


@pytest.mark.parametrize("gdim", (2, 3))
def test_a_sphere_by_heights_is_the_sphere(gdim, rng):
    """Gaps to the tolerance, normals and curvatures to its order over the grid's size; moved, and pointing down."""
    radius, centre = 1.5, np.array([0.2, 0.4, 0.1])[:gdim]
    down = -np.eye(3)[gdim - 1][:gdim]

    def height(*x):
        return np.sqrt(radius**2 - sum(c**2 for c in x)) - radius

    bounds = (-0.8, 0.8) if gdim == 2 else ((-0.8, 0.8), (-0.8, 0.8))
    made = di.RigidSurface.from_function(height, bounds, centre + radius * down, down, tolerance=1e-10)
    here = made.obstacle(gdim)
    ball = _cpp.gap.Rigid("sphere", gdim, np.pad(centre, (0, 3 - gdim)).tolist(), [0.0, 0.0, 1.0], radius)
    for obstacle in (here, ball):
        obstacle.displacement = [0.05, -0.02, 0.0 if gdim == 2 else 0.03]
    for _ in range(20):
        direction = down + 0.3 * rng.uniform(-1, 1, size=gdim)
        x = centre + (radius + rng.uniform(-0.2, 0.5)) * direction / np.linalg.norm(direction)
        ours, theirs = here.evaluate(x), ball.evaluate(x)
        for a, b, tolerance in zip(ours, theirs, (1e-9, 1e-7, 1e-4)):
            np.testing.assert_allclose(a, b, rtol=0, atol=tolerance)


def test_an_oblique_plane_by_heights_is_the_plane(rng):
    for gdim in (2, 3):
        normal, point = rng.uniform(-1, 1, size=gdim), rng.uniform(-1, 1, size=gdim)
        bounds = [(-1.0, 1.0)] * (gdim - 1)
        made = di.RigidSurface.from_function(lambda *x: 0.0, bounds, point, normal).obstacle(gdim)
        plane = di.RigidPlane(point, normal).obstacle(gdim)
        x = rng.uniform(-3, 3, size=(10, gdim)).ravel()
        for a, b in zip(made.evaluate(x), plane.evaluate(x)):
            np.testing.assert_allclose(a, b, rtol=0, atol=1e-14)


def octahedron():
    """Points and triangles of a regular octahedron, counter-clockwise seen from outside."""
    points = np.vstack([np.eye(3), -np.eye(3)])
    facets = []
    for signs in np.ndindex(2, 2, 2):
        triangle = [c + 3 * s for c, s in enumerate(signs)]
        facets.append(triangle if sum(signs) % 2 == 0 else triangle[::-1])
    return points, np.array(facets)


def test_a_closed_surface_of_triangles(rng):
    """Inside and outside of an octahedron, |x| + |y| + |z| = 1; faces, edges and vertices are met from outside."""
    obstacle = di.RigidSurface.from_facets(*octahedron()).obstacle(3)
    curved = set()
    for _ in range(200):
        x = rng.uniform(-1.2, 1.2, size=3)
        gap, normal = derivatives_are_right(obstacle, x, 1e-6)
        outside = np.abs(x).sum() - 1.0
        assert np.sign(gap) == np.sign(outside)
        if gap < 0:
            assert gap == pytest.approx(outside / np.sqrt(3), abs=1e-14)
        foot = x - gap * normal
        assert np.abs(foot).sum() == pytest.approx(1.0, abs=1e-12)
        curved.add(int(np.linalg.matrix_rank(obstacle.evaluate(x)[2][0], tol=1e-9)))
    assert curved == {0, 1, 2}
    gap, normal, hessian = (a[0] for a in obstacle.evaluate(np.array([0.0, 0.0, 1.0])))  # on a vertex
    np.testing.assert_allclose((gap, *normal), (0.0, 0.0, 0.0, 1.0), atol=1e-15)
    assert np.all(hessian == 0.0)
    assert np.isnan(obstacle.evaluate(np.array([np.nan, 0.0, 0.0]))[0][0])


def test_a_polyline_and_its_rim():
    """An angle with the obstacle on its left: concave at the corner; beyond its ends, by more than a twentieth of
    a segment of length two, is outside."""
    points, facets = [[2.0, 0.0], [0.0, 0.0], [0.0, 2.0]], [[0, 1], [1, 2]]  # the obstacle is x < 0 or y < 0
    obstacle = di.RigidSurface.from_facets(points, facets).obstacle(2)
    for x, expected in (
        ((1.0, 0.3), 0.3), ((0.2, 1.0), 0.2), ((1.0, -0.4), -0.4), ((-0.3, 1.0), -0.3), ((-3.0, -4.0), -5.0),
        ((5.0, -4.0), 5.0), ((2.0, -0.1), -0.1), ((2.09, -0.1), -0.1), ((2.2, -0.1), np.hypot(0.2, 0.1)),
    ):  # fmt: skip
        assert obstacle.evaluate(np.array(x))[0][0] == pytest.approx(expected, abs=1e-12), x


def test_facets_of_a_mesh_are_those_of_its_boundary(rng):
    """The sides of a cube, of hexahedra and of tetrahedra; the box in the plane."""
    from dolfinx import mesh

    for kind in ("hexahedron", "tetrahedron", "quadrilateral", "triangle"):
        cell = getattr(mesh.CellType, kind)
        plane = kind in ("quadrilateral", "triangle")
        domain = mesh.create_unit_square(MPI.COMM_SELF, 3, 2, cell) if plane else mesh.create_unit_cube(
            MPI.COMM_SELF, 2, 3, 2, cell)  # fmt: skip
        gdim = domain.geometry.dim
        domain.topology.create_connectivity(gdim - 1, gdim)
        facets = mesh.exterior_facet_indices(domain.topology)
        tags = mesh.meshtags(domain, gdim - 1, facets, np.full(len(facets), 4, dtype=np.int32))
        obstacle = di.RigidSurface.from_mesh(domain, tags, 4).obstacle(gdim)
        x = rng.uniform(-0.5, 1.5, size=(50, gdim))
        out = np.abs(x - 0.5) - 0.5
        expected = np.where(out.max(axis=1) < 0, out.max(axis=1), np.linalg.norm(np.maximum(out, 0.0), axis=1))
        np.testing.assert_allclose(obstacle.evaluate(x.ravel())[0], expected, atol=1e-14)
        with pytest.raises(ValueError, match="no facet carries the tag 5"):
            di.RigidSurface.from_mesh(domain, tags, 5)


def test_what_is_no_surface_is_refused():
    make, points, facets = di.RigidSurface.from_function, *octahedron()
    flat, up = lambda x: 0.0 * x, (0.0, 1.0)
    turned = facets.copy()
    turned[3] = turned[3, ::-1]
    for error, text, call in (
        (TypeError, "must be a function", lambda: make(1.0, (0, 1), (0, 0), up)),
        (ValueError, "bounds are", lambda: make(flat, (1, 0), (0, 0), up)),
        (ValueError, "two pairs", lambda: make(flat, (0, 1), (0, 0, 0), (0, 0, 1))),
        (ValueError, "is zero", lambda: make(flat, (0, 1), (0, 0), (0, 0))),
        (ValueError, "height is nan at", lambda: make(lambda x: np.sqrt(0.5 - x), (0, 1), (0, 0), up)),
        (ValueError, "returns shape", lambda: make(lambda x: np.zeros(3), (0, 1), (0, 0), up)),
        (TypeError, "1 coordinates", lambda: make(lambda x, y: x, (0, 1), (0, 0), up)),
        (ValueError, "round kinks", lambda: make(lambda x: np.floor(3 * x), (0, 1), (0, 0), up)),
        (ValueError, "tolerance is", lambda: make(flat, (0, 1), (0, 0), up, tolerance=0.0)),
        (ValueError, "shape", lambda: di.RigidSurface.from_facets(points, facets[:, :2])),
        (ValueError, "whole numbers", lambda: di.RigidSurface.from_facets(points, facets + 0.5)),
        (ValueError, "has the point 9", lambda: di.RigidSurface.from_facets(points, [[0, 1, 9]])),
        (ValueError, "no size", lambda: di.RigidSurface.from_facets(points, [[0, 1, 1]])),
        (ValueError, "oriented differently", lambda: di.RigidSurface.from_facets(points, turned)),
        (ValueError, "share the edge", lambda: di.RigidSurface.from_facets(points, [[0, 1, 2], [1, 0, 3], [0, 1, 5]])),
        (ValueError, "on their left", lambda: di.RigidSurface.from_facets(points[:3, :2], [[0, 1], [0, 2]])),
        (TypeError, "from_function", lambda: di.RigidSurface(None, 2, "")),
        (ValueError, "has 3 dimensions", lambda: di.RigidSurface.from_facets(points, facets).obstacle(2)),
    ):  # fmt: skip
        with np.errstate(invalid="ignore"), pytest.raises(error, match=text):
            call()
