# SPDX-License-Identifier: MIT
"""Closest points: against dense sampling and SciPy's minimiser on bent facets of every kind, and by hand on edges."""

import basix.ufl
import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI
from scipy.optimize import minimize

from dolfinx_impact import _cpp

CELLS = {"triangle": 2, "quadrilateral": 2, "tetrahedron": 3, "hexahedron": 3}
INSIDE, EDGE, VERTEX, NONE = range(4)


def surface_of(cell, geometry_degree, move, cells=(2, 2, 1), degree=1):
    """Facets of the upper side of the unit box after its nodes were moved."""
    dim = CELLS[cell]
    create = mesh.create_unit_square if dim == 2 else mesh.create_unit_cube
    domain = create(MPI.COMM_SELF, *(cells[:1] + (1,) if dim == 2 else cells), getattr(mesh.CellType, cell))
    if geometry_degree == 2:
        V = fem.functionspace(domain, ("Lagrange", 2, (dim,)))
        element = basix.ufl.element("Lagrange", cell, 2, shape=(dim,))
        points = V.tabulate_dof_coordinates()[:, :dim]
        domain = mesh.create_mesh(MPI.COMM_SELF, V.dofmap.list.astype(np.int64), x=points, e=element)
    upper = mesh.locate_entities_boundary(domain, dim - 1, lambda x: np.isclose(x[dim - 1], 1))
    domain.geometry.x[:, :dim] = move(domain.geometry.x[:, :dim])
    domain.topology.create_connectivity(dim - 1, dim)
    domain.topology.create_connectivity(dim, dim - 1)
    V = fem.functionspace(domain, ("Lagrange", degree, (dim,)))
    return _cpp.surface.make_surface(V._cpp_object, upper.astype(np.int32))


def bent(x, amplitude=0.25):
    """Hills and valleys on the upper side, no two facets alike."""
    out, dim = x.copy(), x.shape[1]
    out[:, dim - 1] += amplitude * x[:, dim - 1] * np.sin(7 * x[:, 0] + 4 * (dim - 2) * x[:, dim - 2])
    return out


def reference_grid(shape, num):
    """Reference points of a facet, a grid up to its edges."""
    t = np.linspace(0, 1, num)
    if shape == "interval":
        return np.stack([t, 0 * t], axis=1)
    grid = np.stack(np.meshgrid(t, t), axis=-1).reshape(-1, 2)
    return grid[grid.sum(axis=1) <= 1 + 1e-12] if shape == "triangle" else grid


def least_distance(facets, point):
    """Smallest distance by brute force: the best of a grid on every facet, then SciPy's SLSQP from the best four."""
    element = facets.geometry
    dim = 1 if element.shape == "interval" else 2
    grid = reference_grid(element.shape, 200 if dim == 1 else 25)
    shapes = np.array([element.tabulate(*xi)[0] for xi in grid])
    distance = np.linalg.norm(np.einsum("qi,fic->fqc", shapes, facets.x) - point, axis=2)
    constraints = [{"type": "ineq", "fun": lambda z: 1 - z.sum()}] if element.shape == "triangle" else []
    found = distance.min()
    for f in np.argsort(distance.min(axis=1))[:4]:
        nodes = facets.x[f]

        def half_square(z):
            r = element.tabulate(*z)[0] @ nodes - point
            return r @ r / 2

        def gradient(z):
            table = element.tabulate(*z)
            return table[1 : 1 + dim] @ nodes @ (table[0] @ nodes - point)

        start = grid[distance[f].argmin(), :dim]
        end = minimize(half_square, start, jac=gradient, bounds=[(0, 1)] * dim, constraints=constraints, tol=1e-15)
        found = min(found, np.sqrt(2 * half_square(np.clip(end.x, 0, 1))))
    return found


@pytest.mark.parametrize("geometry_degree", (1, 2))
@pytest.mark.parametrize("cell", CELLS)
def test_brute_force(cell, geometry_degree, rng):
    facets = surface_of(cell, geometry_degree, bent)
    dim, num = facets.gdim, 60
    x = rng.uniform(-0.1, 1.1, size=(num, dim))
    x[:, -1] = rng.uniform(0.5, 1.6, size=num)
    down = np.tile(-np.eye(dim)[-1], (num, 1))
    search = _cpp.search.SurfaceSearch(facets)
    found = search.project(x, down, 10.0)
    for i in range(num):
        # SLSQP stops at changes of 1e-15 of the half square: distances to 3e-8 where they are small, else better.
        assert abs(abs(found["gap"][i]) - least_distance(facets, x[i])) < 3e-7
        at = facets.evaluate(found["facet"][i], *found["xi"][i])
        d = x[i] - at[:dim]
        assert np.allclose(
            found["gap"][i] * found["normal"][i], d, atol=1e-8 if found["status"][i] == INSIDE else 1e-14
        )
        assert abs(np.linalg.norm(found["normal"][i]) - 1) < 1e-12
        if found["status"][i] == INSIDE:  # orthogonal to round-off of Newton's last step
            assert abs(abs(at[3 : 3 + dim] @ d) - np.linalg.norm(d)) < 1e-12
    assert set(found["status"]) >= ({INSIDE, VERTEX} if dim == 2 else {INSIDE, EDGE})


@pytest.mark.parametrize("cell", CELLS)
def test_sign(cell, rng):
    """Above the surface or below it, whatever the closest point lies on; away from the sides, where it ends."""
    facets = surface_of(cell, 2, bent)
    dim, num = facets.gdim, 300
    x = rng.uniform(0.3, 0.7, size=(num, dim))
    x[:, -1] = rng.uniform(0.5, 1.5, size=num)
    grid = reference_grid(facets.geometry.shape, 60)
    shapes = np.array([facets.geometry.tabulate(*xi)[0] for xi in grid])
    points = np.einsum("qi,fic->fqc", shapes, facets.x).reshape(-1, dim)
    found = _cpp.search.SurfaceSearch(facets).project(x, np.tile(-np.eye(dim)[-1], (num, 1)), 10.0)
    for i in range(num):
        height = x[i, -1] - points[np.linalg.norm(points[:, :-1] - x[i, :-1], axis=1).argmin(), -1]
        if abs(height) > 0.1:  # more than the surface's slope (2) times the distance of samples (0.02)
            assert np.sign(found["gap"][i]) == np.sign(height), (x[i], found["status"][i])


@pytest.mark.parametrize("geometry_degree", (1, 2))
@pytest.mark.parametrize("cell", CELLS)
def test_boxes_contain_facets(cell, geometry_degree):
    """Boxes hold the whole of curved facets, beyond their nodes, and are not much larger."""
    facets = surface_of(cell, geometry_degree, lambda x: bent(x, 0.6))
    dim = facets.gdim
    grid = reference_grid(facets.geometry.shape, 60)
    shapes = np.array([facets.geometry.tabulate(*xi)[0] for xi in grid])
    points = np.einsum("qi,fic->fqc", shapes, facets.x)
    boxes = _cpp.search.bounding_boxes(facets)
    low, high = points.min(axis=1), points.max(axis=1)
    assert np.all(boxes[:, :dim] <= low + 1e-15) and np.all(boxes[:, dim:] >= high - 1e-15)
    assert np.all(boxes[:, dim:] - boxes[:, :dim] < 2.5 * (high - low) + 1e-12)


def ridge(rise):
    """Upper side of two cells in the plane: straight from (0, 1) to (0.5, 1 + rise) to (1, 1)."""

    def move(x):
        out = x.copy()
        out[np.isclose(x[:, 0], 0.5) & np.isclose(x[:, 1], 1), 1] += rise
        return out

    return surface_of("quadrilateral", 1, move)


def one(search, x, previous=None, reach=10.0, normal=(0, -1)):
    last = None if previous is None else np.array([previous], dtype=np.int32)
    found = search.project(np.array([x], dtype=float), np.array([normal], dtype=float), reach, last)
    return {name: value[0] for name, value in found.items()}


def test_ridge_and_valley():
    """Outside a ridge and inside a valley the vertex is closest; its sign is that of the mean normal."""
    search = _cpp.search.SurfaceSearch(ridge(0.2))
    found = one(search, (0.51, 1.5))
    assert found["status"] == VERTEX and abs(found["gap"] - np.hypot(0.01, 0.3)) < 1e-15
    assert np.allclose(found["normal"], np.array([0.01, 0.3]) / np.hypot(0.01, 0.3), atol=1e-14)
    found = one(search, (0.5, 1.1))  # inside, equally far from both sides: the lower id
    assert found["status"] == INSIDE and abs(found["gap"] + 0.1 * 0.5 / np.hypot(0.5, 0.2)) < 1e-15
    assert found["facet"] == np.argmin(search.master.id)
    found = one(_cpp.search.SurfaceSearch(ridge(-0.2)), (0.51, 0.5))
    assert found["status"] == VERTEX and abs(found["gap"] + np.hypot(0.01, 0.3)) < 1e-15
    assert np.allclose(found["normal"], np.array([-0.01, 0.3]) / np.hypot(0.01, 0.3), atol=1e-14)
    found = one(_cpp.search.SurfaceSearch(ridge(-0.2)), (0.5, 0.8))  # at the vertex itself
    assert found["status"] == INSIDE and abs(found["gap"]) < 1e-15 and abs(np.linalg.norm(found["normal"]) - 1) < 1e-14


def test_beside_the_surface():
    """Beyond the end of the surface a point is outside, however deep it lies; right over the end it is not."""
    search = _cpp.search.SurfaceSearch(ridge(0.0))
    for x in ((1.1, 0.99), (-1e-3, 0.9), (1.1, 1.01)):
        found = one(search, x)
        assert found["status"] == VERTEX and found["gap"] > 0
    found = one(search, (1.0, 0.99))
    assert found["status"] == INSIDE and abs(found["gap"] + 0.01) < 1e-15
    flat = _cpp.search.SurfaceSearch(surface_of("hexahedron", 1, lambda x: x))
    down = (0, 0, -1)
    for x, status in (((0.3, 1.1, 0.9), EDGE), ((-0.1, 1.1, 0.9), VERTEX), ((0.5, 1.1, 0.9), EDGE)):
        found = one(flat, x, normal=down)
        assert found["status"] == status and found["gap"] > 0
    assert one(flat, (0.5, 0.5, 0.9), normal=down)["gap"] == pytest.approx(-0.1, abs=1e-15)


def test_under_the_rim_of_a_tilted_facet():
    """A node of a plane of symmetry stays in contact when the last facet is tilted against the plane, either way."""
    for tilt in (-0.02, 0.02):
        search = _cpp.search.SurfaceSearch(
            surface_of("hexahedron", 1, lambda x, t=tilt: x + np.outer(t * x[:, 1], np.eye(3)[2]))
        )
        for y in (0.0, -1e-17, 1e-17):
            found = one(search, (0.5, y, 0.99), normal=-np.eye(3)[2])
            assert found["gap"] == pytest.approx(-0.01, rel=1e-3) and found["normal"][2] > 0.999, (tilt, y)
        assert one(search, (0.5, -0.01, 0.99), normal=-np.eye(3)[2])["gap"] > 0, "beside, not under"


def test_reach_and_facing():
    search = _cpp.search.SurfaceSearch(ridge(0.0))
    assert one(search, (0.3, 1.2), reach=0.19)["status"] == NONE
    found = one(search, (0.3, 1.2), reach=0.21)
    assert found["status"] == INSIDE and found["gap"] == pytest.approx(0.2, abs=1e-15)
    away = one(search, (0.3, 1.2), normal=(0, 1))
    assert away["status"] == NONE and np.isinf(away["gap"]) and away["facet"] == -1


def test_previous_facet_is_kept():
    """Over a common edge the last facet stays; not where another one is clearly nearer."""
    search = _cpp.search.SurfaceSearch(ridge(0.0))
    left, right = one(search, (0.3, 1.2))["facet"], one(search, (0.7, 1.2))["facet"]
    for shift in (-1e-3, 0.0, 1e-3):
        for facet in (left, right):
            found = one(search, (0.5 + shift, 1.2), facet)
            assert found["facet"] == facet and found["status"] == INSIDE
    assert one(search, (0.53, 1.2), left)["facet"] == right
    assert one(search, (0.7, 1.2), 99)["facet"] == right


def test_moved(rng):
    """`update` follows the facets."""
    facets = ridge(0.0)
    search = _cpp.search.SurfaceSearch(facets)
    u = np.zeros(2 * (facets.nodes.max() + 1))
    u[1::2] = 0.3
    facets.move(u)
    search.update()
    assert one(search, (0.3, 1.2))["gap"] == pytest.approx(-0.1, abs=1e-15)


def test_refused():
    search = _cpp.search.SurfaceSearch(ridge(0.0))
    with pytest.raises(ValueError, match="gdim"):
        search.project(np.zeros((2, 3)), np.zeros((2, 3)), 1.0)
    with pytest.raises(ValueError, match="gdim"):
        search.project(np.zeros((2, 2)), np.zeros((1, 2)), 1.0)
    with pytest.raises(ValueError, match="previous"):
        search.project(np.zeros((2, 2)), np.zeros((2, 2)), 1.0, np.zeros(1, dtype=np.int32))
