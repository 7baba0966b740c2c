# SPDX-License-Identifier: MIT
"""Closest points, gaps and normals of the hand-written contact, against SciPy's optimisers and closed forms."""

import impact_reference as ir
import numpy as np
import pytest
from contact_bodies import DEGREES, Pair, blocks, gdim_of, material
from reference_meshes import CELLS, box, facets_where
from scipy.optimize import minimize

# Any quadrature on the slave will do here; few points keep SciPy's work small.
FEW = 2


def positions(model, u, facet, xi):
    """Current position of a reference point of a facet of a model of equal degrees, coded with NumPy alone."""
    cell = ir.facet_type(model.cell_type)
    local = [ir.facet_nodes(model.cell_type, model.degree, f) for f in range(len(ir.facets(model.cell_type)))]
    vertices = len(ir.reference_nodes(cell, 1))
    for nodes in model.field_cells:
        for number in local:
            if set(nodes[number][:vertices]) == set(facet):
                x = (model.field_points + u.reshape(model.field_points.shape))[nodes[number]]
                return ir.shape_functions(cell, model.degree, np.atleast_2d(xi))[0][0] @ x
    raise AssertionError("no such facet")


def inside(cell):
    """Constraints of SciPy's optimiser that keep a point on the reference facet."""
    if cell == "triangle":
        return dict(bounds=[(0, 1)] * 2, constraints={"type": "ineq", "fun": lambda x: 1 - x[0] - x[1]}, method="SLSQP")
    return dict(bounds=[(-1, 1)] * (1 if cell == "interval" else 2), method="SLSQP")


def brute_force_distance(model, u, master, x):
    """Smallest distance over all facets by SciPy, from several starting points."""
    cell = ir.facet_type(model.cell_type)
    starts = ir.reference_nodes(cell, 2) * 0.9 + (0.03 if cell == "triangle" else 0)
    best = np.inf
    for facet in master:
        for start in starts:
            found = minimize(
                lambda xi: np.sum((positions(model, u, facet, xi) - x) ** 2),
                start,
                options=dict(ftol=1e-15, maxiter=200),
                **inside(cell),
            )
            best = min(best, np.sqrt(found.fun))
    return best


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("degree", [1, 2])
def test_distance_is_the_smallest_one(cell, degree):
    """A wavy master and a slave above and below it: interior, edges and vertices all occur."""
    d = gdim_of(cell)
    pair = blocks(cell, degree, degree, lower=(2, 1) if d == 2 else (1, 1, 1), upper=(2, 1) if d == 2 else (1, 1, 1))
    rng = np.random.default_rng(4)
    u = 0.06 * rng.standard_normal(pair.model.num_dofs)
    contact = ir.Contact(pair.model, pair.slave, pair.master, rule=FEW)
    points = contact.closest_points(u)
    found = points.facet >= 0
    assert found.sum() >= len(found) // 2
    for i in np.flatnonzero(found)[:6]:
        exact = brute_force_distance(pair.model, u, pair.master, points.position[i])
        # SLSQP stops when the squared distance no longer changes by 1e-15: 1e-7 in the distance where it is small
        assert np.isclose(abs(points.gap[i]), exact, rtol=1e-6, atol=1e-7)
        foot = points.position[i] - points.gap[i] * points.normal[i]
        on = positions(pair.model, u, pair.master[points.facet[i]], points.coordinate[i])
        assert np.allclose(foot, on, atol=1e-13)  # n = d / g to rounding
        assert np.isclose(np.linalg.norm(points.normal[i]), 1, atol=1e-14)


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("degree, geometry_degree", DEGREES)
def test_gap_of_parallel_faces(cell, degree, geometry_degree):
    """Positive when open, negative when penetrating, normal out of the lower body."""
    for gap in (0.25, -0.125):
        pair = blocks(cell, degree, geometry_degree, gap=gap)
        points = ir.Contact(pair.model, pair.slave, pair.master).closest_points(np.zeros(pair.model.num_dofs))
        assert np.allclose(points.gap, gap, atol=1e-15)
        assert np.allclose(points.normal, np.eye(pair.gdim)[-1], atol=1e-15)
        assert np.all(points.facet >= 0)
        assert np.isclose(points.weight.sum(), 1, atol=1e-14)  # the unit face


def ring(cell, degree, inner, outer, n):
    def mapping(x):
        angle = np.pi / 2 * x[1]
        return (inner + (outer - inner) * x[0]) * np.array([np.cos(angle), np.sin(angle)])

    return box(cell, n, degree, mapping)


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
@pytest.mark.parametrize("inside_out", [False, True])
def test_curved_facets_converge_to_circles(cell, inside_out):
    """Concentric circles of radius 1 and 1.2; facets of degree 2 leave the circle by O(h^4)."""
    errors = []
    for n in (4, 8):
        lower, upper = ring(cell, 2, 0.5, 1.0, (2, n)), ring(cell, 2, 1.2, 1.5, (2, n + 1))
        pair = Pair(lower, upper, cell, material(cell), 2, 2)
        inner = pair.facets(False, lambda x: np.hypot(*x) > 1 - 1e-9)
        outer = pair.facets(True, lambda x: np.hypot(*x) < 1.2 + 1e-9)
        slave, master = (inner, outer) if inside_out else (outer, inner)
        points = ir.Contact(pair.model, slave, master).closest_points(np.zeros(pair.model.num_dofs))
        radial = points.position / np.linalg.norm(points.position, axis=1)[:, None]
        assert np.all(points.facet >= 0)
        # near the ends of the quarter the foot may lie on the rim, which tilts the normal of the polygon a little
        assert np.abs(points.normal - (-radial if inside_out else radial)).max() < 0.02
        errors.append(np.abs(points.gap - 0.2).max())
    assert np.log2(errors[0] / errors[1]) > 3.5
    assert errors[1] < 1e-5


def test_edges_and_vertices():
    """A roof of two facets: above the ridge the distance is to the ridge, with the mean normal deciding the sign."""
    roof = (
        np.array([[-1.0, -1], [0, -1], [1, -1], [-1, -0.5], [0, 0], [1, -0.5]]),
        np.array([[0, 1, 4, 3], [1, 2, 5, 4]]),
    )
    for height in (0.3, -0.02):
        block = np.array([[-0.1, 0.0], [0.1, 0.0], [0.1, 1.0], [-0.1, 1.0]]) + [0, height]
        pair = Pair(roof, (block, np.array([[0, 1, 2, 3]])), "quadrilateral", material("quadrilateral"))
        top = pair.facets(False, lambda x: x[1] > -0.6)
        bottom = pair.facets(True, lambda x: x[1] < height + 1e-9)
        rule = (np.array([[0.0], [0.5]]), np.array([1.0, 1.0]))
        points = ir.Contact(pair.model, bottom, top, rule=rule).closest_points(np.zeros(pair.model.num_dofs))
        if height > 0:  # over the ridge, both points
            assert np.allclose(points.gap, np.hypot([0, 0.05], height), atol=1e-14)
            assert np.allclose(points.normal[1], np.array([0.05, height]) / np.hypot(0.05, height), atol=1e-14)
        else:  # inside the roof: the distance is to a side
            normal = np.array([0.5, 1]) / np.hypot(0.5, 1)
            assert np.isclose(points.gap[1], normal @ [0.05, height], atol=1e-14)
            assert np.isclose(points.gap[0], normal @ [0.0, height], atol=1e-14)
            assert np.allclose(points.normal[1], normal, atol=1e-14)


def test_a_point_without_master_is_open():
    pair = blocks("quadrilateral", shift=0.5)
    u = np.zeros(pair.model.num_dofs)
    u.reshape(-1, 2)[pair.split :, 1] = -0.01
    contact = ir.Contact(pair.model, pair.slave, pair.master)
    points = contact.closest_points(u)
    beside = points.position[:, 0] > 1
    assert beside.any() and (~beside).any()
    assert np.all(np.isinf(points.gap[beside])) and np.all(points.facet[beside] == -1)
    assert np.allclose(points.gap[~beside], -0.01, atol=1e-15)
    result = contact.penalty(u, 10.0)
    assert np.all(result.status[beside] == 0) and np.all(result.pressure[beside] == 0)
    # beyond the search distance
    pair = blocks("quadrilateral", gap=0.5)
    near = ir.Contact(pair.model, pair.slave, pair.master, search_distance=0.4)
    assert np.all(np.isinf(near.closest_points(np.zeros(pair.model.num_dofs)).gap))
    # facets that look the same way do not face each other
    same = ir.Contact(pair.model, pair.slave, facets_where(*pair.lower, "quadrilateral", lambda x: x[1] < -1 + 1e-9))
    assert np.all(np.isinf(same.closest_points(np.zeros(pair.model.num_dofs)).gap))


@pytest.mark.parametrize("cell", CELLS)
def test_rigid_obstacles(cell):
    d = gdim_of(cell)
    points, cells = box(cell, (2,) * d, 1)
    model = ir.Model(points, cells, cell, material(cell))
    slave = facets_where(points, cells, cell, lambda x: x[-1] < 1e-9)
    u = 0.02 * np.random.default_rng(1).standard_normal(model.num_dofs)
    below, tilted = -0.3 * np.eye(d)[-1] + 0.4, np.array([0.2, 1.0]) if d == 2 else np.array([0.2, -0.1, 1.0])
    obstacles = {
        "plane": ir.RigidPlane(below, tilted),
        "sphere": ir.RigidSphere(below, 0.25),
        "cylinder": ir.RigidCylinder(below, 0.25, axis=None if d == 2 else [1.0, 0.3, 0.2]),
    }
    for name, obstacle in obstacles.items():
        for moved in (np.zeros(d), 0.1 * np.arange(1, d + 1)):
            obstacle.displacement = moved
            found = ir.Contact(model, slave, obstacle).closest_points(u)
            x = found.position - below - moved
            if name == "plane":
                normal = np.tile(tilted / np.linalg.norm(tilted), (len(x), 1))
                gap = x @ normal[0]
            else:
                if name == "cylinder" and d == 3:
                    axis = np.array([1.0, 0.3, 0.2]) / np.linalg.norm([1.0, 0.3, 0.2])
                    x = x - np.outer(x @ axis, axis)
                gap = np.linalg.norm(x, axis=1) - 0.25
                normal = x / np.linalg.norm(x, axis=1)[:, None]
            assert np.allclose(found.gap, gap, atol=1e-15)
            assert np.allclose(found.normal, normal, atol=1e-14)


def test_bad_input():
    pair = blocks("quadrilateral")
    model, slave, master = pair.model, pair.slave, pair.master
    zero = np.zeros(model.num_dofs)
    for arguments, message in [
        ((model, slave[:0], master), "slave has no facets"),
        ((model, np.vstack([slave, slave[:1]]), master), "given twice"),
        ((model, slave, np.array([[0, 1000]])), "names node 1000"),
        ((model, slave, ir.RigidPlane([0, 0], [0, 0])), "is zero"),
        ((model, slave, ir.RigidSphere([0, 0], -1.0)), "radius"),
        ((model, slave, ir.RigidSphere([0, 0, 0], 1.0)), "2 finite components"),
    ]:
        with pytest.raises(ValueError, match=message):
            ir.Contact(*arguments)
    inner = [c[[0, 1]] for c in model.cells if model.points[c[0], 1] > 0.4][:1]
    with pytest.raises(ValueError, match="between two cells"):
        ir.Contact(model, np.array(inner), master)
    for options, message in [
        (dict(friction=-0.1), "must not be negative"),
        (dict(search_distance=0.0), "must be positive"),
        (dict(prescribed=[10**6]), "out of range"),
        (dict(rule=1.5), "degree"),
        (dict(rule=(np.zeros((2, 2)), np.ones(2))), "shape"),
    ]:
        with pytest.raises(ValueError, match=message):
            ir.Contact(model, slave, master, **options)
    contact = ir.Contact(model, slave, master)
    with pytest.raises(ValueError, match="finite values"):
        contact.closest_points(zero[:-1])
    with pytest.raises(ValueError, match="finite values"):
        contact.penalty(np.full_like(zero, np.nan), 1.0)
    with pytest.raises(ValueError, match="penalties must be positive"):
        contact.penalty(zero, -1.0)
    with pytest.raises(ValueError, match="multiplier needs"):
        contact.penalty(zero, 1.0, multiplier=[1.0])
    with pytest.raises(ValueError, match="unknown basis"):
        contact.mortar(zero, basis="other")
    with pytest.raises(ValueError, match="multipliers need shape"):
        contact.mortar(zero, multipliers=np.zeros((1, 2)))
    with pytest.raises(ValueError, match="one value per fixed"):
        contact.solve_penalty([0], 0.0, np.zeros(3), chi=1.0)
    with pytest.raises(ValueError, match="penalties must be positive"):
        contact.solve_penalty([0])
