# SPDX-License-Identifier: MIT
"""Slave quadrature points: weights against measured areas, gaps against closed forms."""

import basix
import numpy as np
import partitioned_bodies
import pytest
from mpi4py import MPI

from dolfinx_impact import _cpp


FACETS = {"triangle": "interval", "quadrilateral": "interval", "tetrahedron": "triangle", "hexahedron": "quadrilateral"}
ROUND_OFF = 1e-13


def rule(cell, degree=4):
    return basix.make_quadrature(getattr(basix.CellType, FACETS[cell]), degree)


def pair(cell, **more):
    dim = 2 if cell in ("triangle", "quadrilateral") else 3
    V, slave, master = partitioned_bodies.two_bodies(MPI.COMM_SELF, dim, cell, **more)
    exchange = _cpp.search.Exchange(V._cpp_object, slave, master, 1.0)
    return V, exchange


@pytest.mark.parametrize("cell", FACETS)
def test_weights_and_positions(cell):
    """Sum of weights: the area of a polygon; sum of weight times x: its first moment. Axisymmetric: Pappus."""
    V, exchange = pair(cell)
    slave, dim = exchange.slave, V.mesh.geometry.dim
    points = _cpp.penalty.Points(slave, *rule(cell, 12))
    assert points.size == slave.size * points.per_facet and points.gdim == dim
    corners = slave.X
    if dim == 2:
        areas = np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1)
        centres = corners.mean(axis=1)
    elif FACETS[cell] == "triangle":
        areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
        centres = corners.mean(axis=1)
    else:
        areas = None
    per_facet = points.weight.reshape(slave.size, -1)
    if areas is not None:
        assert np.allclose(per_facet.sum(axis=1), areas, rtol=ROUND_OFF)
        moments = (points.weight[:, None] * points.x).reshape(slave.size, -1, dim).sum(axis=1)
        assert np.allclose(moments, areas[:, None] * centres, rtol=10 * ROUND_OFF)
    for q in range(points.size):
        at = slave.evaluate(points.facet[q], *points.xi[q])
        assert np.allclose(points.x[q], at[:dim], atol=ROUND_OFF)
    if dim == 2:
        ring = _cpp.penalty.Points(slave, *rule(cell, 12), True).weight.reshape(slave.size, -1).sum(axis=1)
        assert np.allclose(ring, 2 * np.pi * centres[:, 0] * areas, rtol=ROUND_OFF)


@pytest.mark.parametrize("cell", FACETS)
def test_deformable_master(cell):
    """The same as projecting the points one by one; open before the first update."""
    V, exchange = pair(cell, geometry_degree=2, degree=2)
    dim = V.mesh.geometry.dim
    points = _cpp.penalty.Points(exchange.slave, *rule(cell))
    assert np.all(np.isinf(points.gap)) and np.all(points.master == -1) and np.all(points.status == 3)
    search = _cpp.search.SurfaceSearch(exchange.master)
    points.update(exchange.slave, search, 0.5)
    normals = [exchange.slave.evaluate(f, *xi)[3 : 3 + dim] for f, xi in zip(points.facet, points.xi)]
    found = search.project(points.x, np.array(normals), 0.5)
    for name, values in (("gap", points.gap), ("normal", points.normal), ("xi", points.master_xi)):
        assert np.array_equal(found[name], values)
    assert np.array_equal(found["facet"], points.master)
    assert np.all(np.abs(points.gap) < 0.05) and np.all(points.normal[:, -1] > 0.9)
    points.update(exchange.slave, search, 0.5, keep=True)
    assert np.array_equal(found["gap"], points.gap)  # nothing has moved
    points.update(exchange.slave, search, 1e-9)
    assert np.all(np.isinf(points.gap[points.status == 3])) and np.any(points.status == 3)


@pytest.mark.parametrize("cell", ("quadrilateral", "tetrahedron"))
def test_rigid_master(cell):
    """A plane and a sphere, by hand."""
    V, exchange = pair(cell)
    slave, dim = exchange.slave, V.mesh.geometry.dim
    points = _cpp.penalty.Points(slave, *rule(cell))
    up, centre = np.eye(3)[dim - 1], np.array([0.4, 0.1, 0.2][:dim] + [0.0] * (3 - dim))
    points.update_rigid(slave, _cpp.gap.Rigid("plane", dim, centre.tolist(), up.tolist(), 0.0))
    assert np.allclose(points.gap, points.x[:, -1] - centre[dim - 1], atol=ROUND_OFF)
    assert np.allclose(points.normal, up[:dim]) and np.all(points.master == -1)
    points.update_rigid(slave, _cpp.gap.Rigid("sphere", dim, centre.tolist(), up.tolist(), 0.5))
    distance = np.linalg.norm(points.x - centre[:dim], axis=1)
    assert np.allclose(points.gap, distance - 0.5, atol=ROUND_OFF)
    assert np.allclose(points.normal, (points.x - centre[:dim]) / distance[:, None], atol=ROUND_OFF)


def test_refused():
    V, exchange = pair("quadrilateral")
    points, weights = rule("quadrilateral")
    with pytest.raises(ValueError, match="as many weights"):
        _cpp.penalty.Points(exchange.slave, points, weights[1:])
    with pytest.raises(ValueError, match="dimension of the facet"):
        _cpp.penalty.Points(exchange.slave, *rule("hexahedron"))
    _, solid = pair("hexahedron")
    with pytest.raises(ValueError, match="curves in the plane"):
        _cpp.penalty.Points(solid.slave, *rule("hexahedron"), True)
    made = _cpp.penalty.Points(exchange.slave, points, weights)
    with pytest.raises(ValueError, match="another surface"):
        made.update(exchange.master, _cpp.search.SurfaceSearch(exchange.master), 1.0)
    with pytest.raises(ValueError, match="dimension"):
        made.update_rigid(exchange.slave, _cpp.gap.Rigid("plane", 3, [0, 0, 0], [0, 0, 1], 0.0))
