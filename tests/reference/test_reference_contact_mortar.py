# SPDX-License-Identifier: MIT
"""Mortar integrals of the hand-written contact: partitions, areas, exactness, normals and derivatives."""

import impact_reference as ir
import numpy as np
import pytest
from contact_bodies import DEGREES, Pair, blocks, central_difference, gdim_of, in_space, material
from reference_meshes import CELLS, box, facets_where, nodes_where

BASES = ["dual", "standard", "linear"]
quadratic_in_space = pytest.mark.long_rows(
    where=lambda cell, degree, basis: in_space(cell) and degree == 2 and basis != "dual"
)


def moved_apart(pair, rng, size=0.01):
    return size * rng.standard_normal(pair.model.num_dofs)


@pytest.mark.covering(2)
@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("degree, geometry_degree", DEGREES)
@pytest.mark.parametrize("basis", BASES)
def test_partition_of_unity_and_biorthogonality(cell, degree, geometry_degree, basis):
    """Shape functions of both sides add up to one, whatever the deformation, so forces balance to round-off."""
    pair = blocks(cell, degree, geometry_degree)
    rng = np.random.default_rng(2)
    u = moved_apart(pair, rng)
    contact = ir.Contact(pair.model, pair.slave, pair.master)
    z = rng.standard_normal(pair.model.field_points.shape)
    m = contact.mortar(u, basis, z)
    D, M = m.D.toarray(), m.M.toarray()
    area = m.cover.sum()
    assert 0.9 < area < 1.01  # corners make the polygons: bent sides of quadratic facets leave them either way
    assert np.allclose(D.sum(1), m.cover, atol=1e-14) and np.allclose(M.sum(1), m.cover, atol=1e-14)
    on = np.flatnonzero(m.participates)
    assert np.all(np.delete(D, on, axis=0) == 0)
    among = D[np.ix_(on, on)]
    if basis == "dual":
        assert np.array_equal(among, np.diag(np.diag(among)))
    elif basis == "standard" and not (cell == "tetrahedron" and degree == 2):
        assert np.allclose(among, among.T, atol=1e-15)
    force = m.force.reshape(-1, pair.gdim)
    # the basis adds up to one as well: equal multipliers give the covered area
    one = contact.mortar(u, basis, np.ones_like(z)).force.reshape(-1, pair.gdim)
    upper = np.zeros(len(z), dtype=bool)
    upper[np.unique(pair.model.field_cells[len(pair.lower[1]) :])] = True
    assert np.allclose(one[upper].sum(0), area, atol=1e-13)
    assert np.allclose(force.sum(0), 0, atol=1e-14 * np.abs(force).sum())
    assert np.allclose(force, (D.T - M.T) @ z, atol=1e-14)


@pytest.mark.covering(2)
@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("degree, geometry_degree", DEGREES)
@pytest.mark.parametrize("basis", BASES)
def test_polynomials_pass_between_flat_meshes(cell, degree, geometry_degree, basis):
    """D times values on the slave is M times those on the master for polynomials of the space; gamma = area gap."""
    d = gdim_of(cell)
    pair = blocks(cell, degree, geometry_degree, gap=0.05)
    contact = ir.Contact(pair.model, pair.slave, pair.master)
    m = contact.mortar(np.zeros(pair.model.num_dofs), basis)
    x = pair.model.field_points
    powers = [lambda y: y[:, 0], lambda y: y[:, d - 2] - 2 * y[:, 0]]
    if degree == 2:
        powers += [lambda y: y[:, 0] ** 2, lambda y: y[:, 0] * y[:, d - 2] - 2 * y[:, d - 2] ** 2]
    for f in powers:
        values = f(x)
        right = m.M @ values
        assert np.abs(right).max() > 1e-3
        assert np.allclose(m.D @ values, right, atol=1e-14)
    assert np.allclose(m.gamma, 0.05 * m.cover[:, None] * np.eye(d)[-1], atol=1e-15)
    on = m.cover > 0
    assert np.allclose(m.normals[on], np.eye(d)[-1], atol=1e-15)
    assert np.allclose(m.gap[m.participates], 0.05, atol=1e-14)
    # quadratic triangles have their multipliers at the midpoints: corners have no area; linear ones live at corners
    face = np.unique(np.concatenate([[n for n in c if abs(x[n, -1] - 0.05) < 1e-9] for c in pair.model.field_cells]))
    corners = 4 ** (d - 1) if d == 3 else 5
    none_there = cell == "tetrahedron" and degree == 2
    expected = corners if basis == "linear" else len(face) - corners if none_there else len(face)
    assert m.participates.sum() == expected


def plate(points, height, up):
    """A quadrilateral column of one hexahedron from the given corners at `height`."""
    other = height + (1.0 if up else -1.0)
    low, high = (height, other) if up else (other, height)
    p = np.vstack([np.column_stack([points, np.full(4, h)]) for h in (low, high)])
    return p, np.arange(8)[None]


def polygon_area(p):
    return 0.5 * np.sum(p[:, 0] * np.roll(p[:, 1], -1) - p[:, 1] * np.roll(p[:, 0], -1))


SQUARE = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])


def turned(angle):
    c, s = np.cos(angle), np.sin(angle)
    return SQUARE @ np.array([[c, s], [-s, c]])


@pytest.mark.parametrize(
    "corners, exact",
    [
        (SQUARE + [0.3, 0.2], 0.7 * 0.8),
        (turned(np.pi / 4), 2 * (np.sqrt(2) - 1)),  # a regular octagon of inradius 1/2
        (2 * turned(0.3), 1.0),  # covers all
        (0.5 * turned(1.1), 0.25),  # is covered
        (SQUARE + [1.0 - 5e-2, 0], 5e-2),
        (SQUARE + [1.0 - 5e-3, 0], 0.0),  # too little for any of its nodes to carry a multiplier
        (SQUARE + [2.0, 0], 0.0),
    ],
)
def test_known_overlaps(corners, exact):
    pair = Pair(plate(corners, 0, False), plate(SQUARE, 0, True), "hexahedron", material("hexahedron"))
    face = lambda x: abs(x[2]) < 1e-9  # noqa: E731
    m = ir.Contact(pair.model, pair.facets(True, face), pair.facets(False, face)).mortar(np.zeros(48), "standard")
    # the sides of the polygons lie at 1e-17, which the square root of these areas does not see
    assert np.isclose(m.cover.sum(), exact, rtol=1e-10, atol=1e-14)


def halves(p, a, b):
    """Part of a polygon left of the line from a to b, written with complex numbers to be unlike the code under test."""
    z = p[:, 0] + 1j * p[:, 1]
    za, t = complex(*a), complex(*(b - a))
    side = ((z - za) * np.conj(t)).imag
    result = []
    for k in range(len(z)):
        n = (k + 1) % len(z)
        if side[k] >= 0:
            result.append(z[k])
        if side[k] * side[n] < 0:
            result.append(z[k] + (z[n] - z[k]) * side[k] / (side[k] - side[n]))
    return np.column_stack([np.real(result), np.imag(result)])


def test_random_turned_patches():
    """Two triangulated plates at any angle: covered area and first moments against exact polygon sums."""
    rng = np.random.default_rng(11)
    for angle in rng.uniform(0, 2 * np.pi, 4):
        low, up = box("tetrahedron", (3, 2, 1), 1), box("tetrahedron", (2, 3, 1), 1)
        R = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        moved = low[0] * [1.0, 1.0, -1.0]
        moved[:, :2] = (moved[:, :2] - 0.5) @ R.T + 0.5 + rng.uniform(-0.2, 0.2, 2)
        cells = low[1][:, [1, 0, 2, 3]]  # mirrored
        pair = Pair((moved, cells), up, "tetrahedron", material("tetrahedron"))
        face = lambda x: abs(x[2]) < 1e-9  # noqa: E731
        slave, master = pair.facets(True, face), pair.facets(False, face)
        contact = ir.Contact(pair.model, slave, master)
        m = contact.mortar(np.zeros(pair.model.num_dofs), "standard")
        area, first = 0.0, np.zeros(2)
        for s in slave:
            for t in master:
                p, q = pair.model.points[s][:, :2], pair.model.points[t][:, :2]
                p = p if polygon_area(p) > 0 else p[::-1]
                q = q if polygon_area(q) > 0 else q[::-1]
                for k in range(3):
                    p = halves(p, q[k], q[(k + 1) % 3]) if len(p) > 2 else p[:0]
                if len(p) > 2:
                    area += polygon_area(p)
                    for k in range(1, len(p) - 1):
                        triangle = p[[0, k, k + 1]]
                        first += polygon_area(triangle) * triangle.mean(0)
        assert 0.2 < area < 1
        assert np.isclose(m.cover.sum(), area, rtol=1e-12)
        x = pair.model.field_points
        for k in range(2):  # int x over the cover, from both sides
            assert np.isclose((m.D @ x[:, k]).sum(), first[k], rtol=1e-12)
            assert np.isclose((m.M @ x[:, k]).sum(), first[k], rtol=1e-12)


@pytest.mark.covering(2)
@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("degree, geometry_degree", DEGREES)
@pytest.mark.parametrize("basis", BASES)
def test_derivative_of_the_force(cell, degree, geometry_degree, basis):
    """Weights, cover and dual basis move as well: the tangent is exact."""
    pair = blocks(cell, degree, geometry_degree, shift=0.2)  # the slave overhangs
    rng = np.random.default_rng(6)
    u = moved_apart(pair, rng)
    contact = ir.Contact(pair.model, pair.slave, pair.master)
    z = rng.standard_normal(pair.model.field_points.shape)
    tangent = contact.mortar(u, basis, z).tangent
    direction = rng.standard_normal(u.size)
    numeric = -central_difference(lambda v: contact.mortar(v, basis, z).force, u, direction, 1e-6)
    # the dual basis of a facet that is hardly covered has large derivatives; 1e-8 is usual
    assert np.abs(tangent @ direction - numeric).max() < 1e-5 * np.abs(numeric).max()


@pytest.mark.parametrize("height, in_plane", [(2.2, True), (1.9, False), (1.0, False)])
def test_nodal_normals(height, in_plane):
    """Mean of the facets' normals, each with the same weight, turned round. Where that is within 5 degrees of a plane
    of symmetry (4.4 is, 6.3 and 13 are not) the prescribed component is taken out."""
    roof = np.array([[-1.0, 1], [0, 0], [3, height], [-1, 4], [0, 4], [3, 4]]), np.array([[0, 1, 4, 3], [1, 2, 5, 4]])
    plane = box("quadrilateral", (1, 1), 1, lambda x: np.array([10 * x[0] - 5, x[1] - 2]))
    pair = Pair(plane, roof, "quadrilateral", material("quadrilateral"))
    slave, master = pair.facets(True, lambda x: x[1] < 3.9), pair.facets(False, lambda x: x[1] > -1.1)
    left, right = np.array([1.0, 1]) / np.sqrt(2), np.array([-height, 3]) / np.hypot(height, 3)
    mean = (left + right) / np.linalg.norm(left + right)
    assert (abs(mean[0]) < np.sin(np.deg2rad(5))) == in_plane
    zero = np.zeros(pair.model.num_dofs)
    normals = ir.Contact(pair.model, slave, master).mortar(zero).normals[pair.split :]
    assert np.allclose(normals[:3], [left, mean, right], atol=1e-15)
    prescribed = [2 * (pair.split + 1)]
    held = ir.Contact(pair.model, slave, master, prescribed=prescribed).mortar(zero).normals[pair.split :]
    assert np.allclose(held[:3], [left, [0, 1] if in_plane else mean, right], atol=1e-15)


def test_dual_basis_of_quadratic_edges():
    """int phi over an interval of length h: h/6, 2h/3, h/6."""
    pair = blocks("quadrilateral", 2, 1, lower=(3, 1), upper=(2, 1))
    m = ir.Contact(pair.model, pair.slave, pair.master).mortar(np.zeros(pair.model.num_dofs))
    values = np.sort(m.cover[m.cover > 0])
    assert np.allclose(values, np.sort([1 / 12, 1 / 3, 1 / 6, 1 / 3, 1 / 12]), atol=1e-15)


def test_axisymmetric_weight():
    pair = blocks("triangle", 2, 1, hypothesis="axisymmetric")
    m = ir.Contact(pair.model, pair.slave, pair.master).mortar(np.zeros(pair.model.num_dofs))
    assert np.isclose(m.cover.sum(), np.pi, rtol=1e-14)
    assert np.allclose(m.M.toarray().sum(1), m.cover, atol=1e-14)


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("basis", BASES)
def test_rigid_master(cell, basis):
    d = gdim_of(cell)
    points, cells = box(cell, (2,) * d, 1)
    model = ir.Model(points, cells, cell, material(cell), degree=2)
    slave = facets_where(points, cells, cell, lambda x: x[-1] < 1e-9)
    middle = np.full(d, 0.5)
    middle[-1] = -1.0
    contact = ir.Contact(model, slave, ir.RigidSphere(middle, 0.9))
    rng = np.random.default_rng(9)
    u = 0.01 * rng.standard_normal(model.num_dofs)
    m = contact.mortar(u, basis)
    on = nodes_where(model.field_points, lambda x: x[-1] < 1e-9)
    r = (model.field_points + u.reshape(-1, d))[on] - middle
    normal = r / np.linalg.norm(r, axis=1)[:, None]
    gap = np.linalg.norm(r, axis=1) - 0.9
    assert np.isclose(m.cover.sum(), 1, atol=1e-14) and m.M.data.size == 0
    assert np.allclose(m.normals[on], normal, atol=1e-14)
    assert np.allclose(m.gamma[on], (m.cover[on] * gap)[:, None] * normal, atol=1e-15)
    # the increments since a history, less those of the obstacle
    history = contact.no_history()
    contact.obstacle.displacement = np.arange(1.0, d + 1)
    moved = contact.mortar(np.tile(np.ones(d), len(model.field_points)), basis, history=history).moved
    assert np.allclose(moved, m.cover[:, None] * (1 - np.arange(1.0, d + 1)), atol=1e-14)
