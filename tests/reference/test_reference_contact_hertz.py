# SPDX-License-Identifier: MIT
"""Curved contact of the hand-written solver: Hertz's lines and points, the press fit, large sliding."""

import impact_reference as ir
import numpy as np
import pytest
from contact_bodies import Pair, material
from reference_meshes import box, dofs, facets_where, nodes_where

METHODS = ["lagrange", "penalty"]
E, NU = 200.0, 0.3


def cylinder_on_block(degree, law="linear_elastic", friction=0.0, swap=False, n=12):
    """Half of a cylinder of radius 1 on a block of its own material, finer towards the axis of symmetry."""
    cell = "quadrilateral"

    def disc(x):
        r, angle = 0.2 + 0.8 * x[0], -np.pi / 2 * (1 - x[1] ** 1.8)
        return r * np.array([np.cos(angle), np.sin(angle)])

    upper = box(cell, (8, n), degree, disc)
    lower = box(cell, (n, 6), degree, lambda x: np.array([1.5 * x[0] ** 1.8, x[1] - 2]))
    pair = Pair(lower, upper, cell, material(cell, E, NU, law=law), degree, degree)
    round_side = pair.facets(True, lambda x: np.hypot(*x) > 0.99 and x[0] < 0.7 and x[1] < 0)
    flat_side = pair.facets(False, lambda x: x[1] > -1 - 1e-9)
    fixed, values = pair.held(
        (lambda x: abs(x[0]) < 1e-9, 0, 0.0),
        (lambda x: x[1] < -2 + 1e-9, (0, 1), 0.0),
        (lambda x: np.hypot(*x) < 0.2 + 1e-6, 0, 0.0),
        (lambda x: np.hypot(*x) < 0.2 + 1e-6, 1, -0.01),
    )
    slave, master = (flat_side, round_side) if swap else (round_side, flat_side)
    contact = ir.Contact(pair.model, slave, master, friction=friction, prescribed=fixed)
    return pair, contact, fixed, values


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("swap", [False, True])
@pytest.mark.parametrize("law", ["linear_elastic", "neo_hookean"])
def test_line_contact(method, degree, swap, law):
    """Largest pressure of Hertz, BENCHMARKS A: p0 = 2 P / (pi a), a = 2 sqrt(P R / (pi E*)), here a = 0.08."""
    pair, contact, fixed, values = cylinder_on_block(degree, law, swap=swap)
    if method == "lagrange":
        s = contact.solve_lagrange(fixed, values)
    else:
        s = contact.solve_penalty(fixed, values, chi=1e5)
    upper = np.unique(pair.model.field_cells[len(pair.lower[1]) :])
    force = s.contact_force.reshape(-1, 2)
    P = 2 * force[upper, 1].sum()  # the other half
    modulus = E / (1 - NU**2) / 2
    a = np.sqrt(4 * P / (np.pi * modulus))
    p0 = 2 * P / (np.pi * a)
    # three linear or two quadratic facets inside a, the edge of contact somewhere in the last one: 10 %, 17 % by points
    assert np.isclose(s.pressure.max(), p0, rtol=0.09 if degree == 2 else 0.17)
    closed = s.status > 0
    x = s.points.position if method == "penalty" else (s.u.reshape(-1, 2) + pair.model.field_points)
    width = 0.036 if degree == 1 else 0.02  # of the facet around the edge of contact
    assert abs(x[closed, 0].max() - a) < width
    assert np.all(s.pressure[closed] > -1e-12) and np.all(s.gap[~closed] > -1e-12)
    total = s.reactions.reshape(-1, 2)[:, 1].sum()
    assert abs(total) < 1e-9 * P


@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("swap", [False, True])
def test_line_contact_with_friction(degree, swap):
    """Equal materials: the surfaces move alike, so that friction hardly changes anything; both methods agree."""
    pair, contact, fixed, values = cylinder_on_block(degree, friction=0.3, swap=swap)
    smooth = cylinder_on_block(degree, swap=swap)[1].solve_lagrange(fixed, values)
    rough = contact.solve_lagrange(fixed, values, steps=3)
    springs = contact.solve_penalty(fixed, values, chi=1e5, steps=3)
    assert len(rough.iterations) == len(springs.iterations) == 3  # no step was halved
    closed = rough.status > 0
    assert np.all(np.linalg.norm(rough.traction[closed], axis=1) <= 0.3 * rough.pressure[closed] * (1 + 1e-10))
    load = [np.abs(s.contact_force[1::2]).sum() for s in (smooth, rough, springs)]
    assert abs(load[1] / load[0] - 1) < 2e-3 and abs(load[2] / load[0] - 1) < 0.02
    assert np.abs(rough.traction[closed]).max() > 1e-3 * rough.pressure.max()


@pytest.mark.parametrize("method", METHODS)
def test_point_contact_with_a_rigid_sphere(method):
    """P = 4/3 E* sqrt(R) delta^1.5 for a rigid sphere on a quarter of a block; axisymmetric with the same answer."""
    R, delta = 1.0, 0.02
    modulus = E / (1 - NU**2)
    exact = 4 / 3 * modulus * np.sqrt(R) * delta**1.5  # a = 0.141
    found = []
    for cell in ("hexahedron", "quadrilateral"):
        d, side = (3, 2.0) if cell == "hexahedron" else (2, 4.0)
        n = (7, 7, 5) if d == 3 else (14, 12)

        def graded(x):
            return np.concatenate([side * x[:-1] ** 1.8, [-side * (1 - x[-1]) ** 1.8]])

        points, cells = box(cell, n, 1, graded)
        law = material(cell, E, NU, hypothesis="3d" if d == 3 else "axisymmetric")
        model = ir.Model(points, cells, cell, law, degree=2 if d == 2 else 1)
        top = facets_where(points, cells, cell, lambda x: x[-1] > -1e-9 and max(x[:-1]) < 0.8)
        x = model.field_points
        fixed = [dofs(nodes_where(x, lambda y: abs(y[k]) < 1e-9), k, d) for k in range(d - 1)]
        fixed = np.unique(np.concatenate([*fixed, dofs(nodes_where(x, lambda y: y[-1] < -side + 1e-9), range(d), d)]))
        sphere = ir.RigidSphere(R * np.eye(d)[-1], R, displacement=-delta * np.eye(d)[-1])
        contact = ir.Contact(model, top, sphere, prescribed=fixed)
        if method == "lagrange":
            s = contact.solve_lagrange(fixed)
        else:
            s = contact.solve_penalty(fixed, chi=2e5)
        found.append(-s.contact_force[d - 1 :: d].sum() * (4 if d == 3 else 1))
    # what a half-space gives below the block's depth is missing: u_z of a point force (Boussinesq) there; the rest is
    # the mesh: ten facets inside a, and three
    for P, depth, tolerance in ((found[1], 4.0, 0.03), (found[0], 2.0, 0.12)):
        missing = exact * (1 + NU) / (2 * np.pi * E) * (3 - 2 * NU) / depth
        assert np.isclose(P, exact * (1 + missing / delta) ** 1.5, rtol=tolerance)


def ring(inner, outer):
    def mapping(x):
        angle = np.pi / 2 * x[1]
        return (inner + (outer - inner) * x[0]) * np.array([np.cos(angle), np.sin(angle)])

    return mapping


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
@pytest.mark.parametrize("swap", [False, True])
def test_press_fit(cell, swap):
    """BENCHMARKS G-4 with a bore of radius 10 (Lame): p = 75.7, 1 % on the mean; non-matching quadratic facets."""
    a, b, c, modulus, interference = 10.0, 50.0, 100.0, 210e3, 0.05
    shaft, hub = box(cell, (4, 8), 2, ring(a, b + interference)), box(cell, (5, 11), 2, ring(b, c))
    pair = Pair(shaft, hub, cell, material(cell, modulus, NU, hypothesis="plane_stress"), 2, 2)
    outer = pair.facets(False, lambda x: np.hypot(*x) > b)
    inner = pair.facets(True, lambda x: np.hypot(*x) < b + 1e-6)
    fixed, values = pair.held(*[(lambda x, k=k: abs(x[k]) < 1e-9, k, 0.0) for k in (0, 1)])
    slave, master = (inner, outer) if swap else (outer, inner)
    contact = ir.Contact(pair.model, slave, master, prescribed=fixed)
    s = contact.solve_lagrange(fixed, values)
    shaft_gives, hub_gives = (b**2 + a**2) / (b**2 - a**2) - NU, (c**2 + b**2) / (c**2 - b**2) + NU
    p = interference * modulus / b / (shaft_gives + hub_gives)
    closed = s.status > 0
    assert closed.sum() == np.isfinite(s.gap).sum()
    D = contact.mortar(s.u).cover
    assert np.isclose(np.sum(D * s.pressure) / D.sum(), p, rtol=0.01)
    # facets of the other side have their corners elsewhere: sagittas of 1e-3 of the interference move single pressures
    assert np.allclose(s.pressure[closed], p, rtol=0.1)
    on = np.hypot(*pair.model.field_points.T) > c - 1e-6
    u = np.sum(s.u.reshape(-1, 2) * pair.model.field_points, axis=1)[on] / c
    exact = 2 * p * b**2 * c / (modulus * (c**2 - b**2))
    assert np.allclose(u, exact, rtol=0.01)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_sliding_over_many_facets(method, friction):
    """A stiff block is drawn over a soft one by 40 % of its length: pairs change, forces balance, T = friction N."""
    cell = "quadrilateral"
    lower = box(cell, (10, 2), 1, lambda x: np.array([2 * x[0], 0.5 * x[1] - 0.5]))
    upper = box(cell, (4, 2), 1, lambda x: np.array([0.3 + 0.5 * x[0], 0.3 * x[1] + 0.02 * (2 * x[0] - 1) ** 2]))
    law = material(cell, E, NU, law="neo_hookean")
    pair = Pair(lower, upper, cell, law, 1, 1)
    slave = pair.facets(
        True, lambda x: x[1] < 0.021 and 0.29 < x[0] < 0.81 and x[1] <= 0.02 * ((x[0] - 0.55) / 0.25) ** 2 + 1e-9
    )
    master = pair.facets(False, lambda x: x[1] > -1e-9)
    top, bottom = pair.facets(True, lambda x: x[1] > 0.29), lambda x: x[1] < -0.5 + 1e-9
    nodes = set(top.reshape(-1))
    points = pair.model.field_points

    def loads(x, y):
        on_top = np.array([i in nodes for i in range(len(points))])
        low = np.array([bool(bottom(p)) for p in points])
        fixed = np.concatenate([dofs(np.flatnonzero(low), (0, 1), 2), dofs(np.flatnonzero(on_top), (0, 1), 2)])
        return fixed, np.concatenate([np.zeros(2 * low.sum()), np.tile([x, y], on_top.sum())])

    contact = ir.Contact(pair.model, slave, master, friction=friction)
    solver = {
        "lagrange": contact.solve_lagrange,
        "penalty": lambda *args, **options: contact.solve_penalty(*args, chi=2e4, **options),
    }[method]
    first = solver(*loads(0.0, -0.02))
    s = solver(*loads(0.2, -0.02), steps=8, start=first)
    assert len(s.iterations) == 8
    upper_nodes = np.unique(pair.model.field_cells[len(pair.lower[1]) :])
    force = s.contact_force.reshape(-1, 2)
    T, N = force[upper_nodes].sum(0)
    assert N > 0.5 and np.allclose(force.sum(0), 0, atol=1e-12 * N)
    if friction:
        assert np.all(s.status[s.status > 0] == 2)
    # the surface under the block is dented: normals lean forwards and backwards by some per cent and do not cancel
    assert np.isclose(-T / N, friction, atol=0.02)
    assert np.allclose(s.reactions.reshape(-1, 2).sum(0), 0, atol=1e-9 * N)
