# SPDX-License-Identifier: MIT
"""Penalty contact of the hand-written solver: tangents, balances and Coulomb's law at single states."""

import impact_reference as ir
import numpy as np
import pytest
from contact_bodies import DEGREES, blocks, central_difference, gdim_of, material, moment
from reference_meshes import CELLS, box, facets_where

CHI, CHI_T = 50.0, 30.0
# Round-off 1e-16 over the step 1e-6 leaves 1e-10 of the force, third derivatives (1 / size of a facet) ** 2 as little
# times step ** 2; slip directions of points that have hardly moved are the worst. The bound has a factor 10 in hand.
TANGENT = 2e-6


def pressed(cell, degree, geometry_degree, seed=3):
    """A pair with a random displacement that closes about half of the points."""
    pair = blocks(cell, degree, geometry_degree)
    d, model = pair.gdim, pair.model
    rng = np.random.default_rng(seed)
    u = 0.01 * rng.standard_normal(model.num_dofs)
    upper = np.unique(model.field_cells[len(pair.lower[1]) :])
    u.reshape(-1, d)[upper, -1] -= 0.004
    return pair, u, rng


@pytest.mark.covering(2)
@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("degree, geometry_degree", DEGREES)
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_tangent_is_the_derivative(cell, degree, geometry_degree, friction):
    pair, u, rng = pressed(cell, degree, geometry_degree)
    contact = ir.Contact(pair.model, pair.slave, pair.master, friction=friction)
    history = contact.no_history()
    history.u = u + 0.004 * rng.standard_normal(u.size)
    history.traction = 0.05 * rng.standard_normal(history.traction.shape)
    result = contact.penalty(u, CHI, CHI_T, history)
    assert (result.status == 0).any() and (result.status == 2).any()
    assert friction == 0 or (result.status == 1).any()
    for _ in range(3):
        direction = rng.standard_normal(u.size)
        numeric = -central_difference(lambda v: contact.penalty(v, CHI, CHI_T, history).force, u, direction, 1e-6)
        assert np.abs(result.tangent @ direction - numeric).max() < TANGENT * np.abs(numeric).max()
    if friction == 0:  # a potential: the tangent is symmetric to round-off
        K = result.tangent.toarray()
        assert np.abs(K - K.T).max() < 1e-12 * np.abs(K).max()
        energy = lambda v: energy_of(contact, v)  # noqa: E731
        assert np.isclose(central_difference(energy, u, direction, 1e-6), -result.force @ direction, rtol=1e-7)


def energy_of(contact, u):
    """Potential of the penalty method, sum of w p^2 / (2 chi)."""
    result = contact.penalty(u, CHI)
    return np.sum(result.points.weight * result.pressure**2) / (2 * CHI)


def roof(cell):
    """A ridged master below a narrow flat slave: points are nearest to the ridge."""
    d = gdim_of(cell)

    def lower(x):
        return np.concatenate([[2 * x[0] - 1], x[1:-1], [x[-1] - 1 - 0.3 * abs(2 * x[0] - 1) * x[-1]]])

    def upper(x):
        return np.concatenate([[0.01 * (x[0] - 0.4)], 0.6 * x[1:-1] + 0.2, [x[-1] + 0.04]])

    from contact_bodies import Pair

    low = box(cell, (2, 1) if d == 2 else (2, 1, 1), 1, lower)
    up = box(cell, (1, 1) if d == 2 else (1, 1, 1), 1, upper)
    pair = Pair(low, up, cell, material(cell))
    pair.master = pair.facets(False, lambda x: x[-1] > -0.31)
    pair.slave = pair.facets(True, lambda x: x[-1] < 0.04 + 1e-9)
    return pair


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_tangent_on_edges(cell, friction):
    """A multiplier presses the open points that are nearest to the ridge."""
    pair = roof(cell)
    rng = np.random.default_rng(7)
    u = 5e-4 * rng.standard_normal(pair.model.num_dofs)
    contact = ir.Contact(pair.model, pair.slave, pair.master, friction=friction)
    history = contact.no_history()
    history.traction = 0.02 * rng.standard_normal(history.traction.shape)
    multiplier = np.full(contact.num_points, 3.0)
    result = contact.penalty(u, CHI, CHI_T, history, multiplier)
    assert (result.gap > 0).all() and (result.pressure > 0).all()
    # on an edge the normal is no facet's normal: it turns with the point
    facets = np.array([[0.3, 1.0], [-0.3, 1.0]]) / np.hypot(0.3, 1)
    assert np.abs(result.points.normal[:, [0, -1]][:, None] - facets).max(axis=2).min() > 0.01
    direction = rng.standard_normal(u.size)
    force = lambda v: contact.penalty(v, CHI, CHI_T, history, multiplier).force  # noqa: E731
    numeric = -central_difference(force, u, direction, 1e-6)
    assert np.abs(result.tangent @ direction - numeric).max() < TANGENT * np.abs(numeric).max()


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("shape", ["plane", "sphere", "cylinder"])
def test_tangent_against_obstacles(cell, shape):
    d = gdim_of(cell)
    points, cells = box(cell, (2,) * d, 1)
    model = ir.Model(points, cells, cell, material(cell), degree=2)
    slave = facets_where(points, cells, cell, lambda x: x[-1] < 1e-9)
    rng = np.random.default_rng(5)
    u = 0.02 * rng.standard_normal(model.num_dofs)
    middle = np.full(d, 0.5)
    middle[-1] = -0.55
    obstacle = {
        "plane": ir.RigidPlane(np.zeros(d), np.arange(1, d + 1.0) * np.eye(d)[-1] + 0.02),
        "sphere": ir.RigidSphere(middle, 0.6),
        "cylinder": ir.RigidCylinder(middle, 0.6, axis=[0.1, 1.0, 0.0]),
    }[shape]
    contact = ir.Contact(model, slave, obstacle, friction=0.4)
    history = contact.no_history()
    history.u = u + 0.01 * rng.standard_normal(u.size)
    history.traction = 0.05 * rng.standard_normal(history.traction.shape)
    obstacle.displacement = 0.01 * np.ones(d)
    result = contact.penalty(u, CHI, CHI_T, history)
    assert set(result.status) >= {0, 1} or set(result.status) >= {0, 2}
    direction = rng.standard_normal(u.size)
    numeric = -central_difference(lambda v: contact.penalty(v, CHI, CHI_T, history).force, u, direction, 1e-6)
    assert np.abs(result.tangent @ direction - numeric).max() < TANGENT * np.abs(numeric).max()


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("degree, geometry_degree", DEGREES)
def test_forces_balance(cell, degree, geometry_degree):
    pair, u, rng = pressed(cell, degree, geometry_degree, seed=8)
    model, d = pair.model, pair.gdim
    x = model.field_points + u.reshape(-1, d)
    upper = np.zeros(len(x), dtype=bool)
    upper[np.unique(model.field_cells[len(pair.lower[1]) :])] = True
    for friction in (0.0, 0.5):
        contact = ir.Contact(model, pair.slave, pair.master, friction=friction)
        history = contact.no_history()
        history.u = u + 0.01 * rng.standard_normal(u.size)
        result = contact.penalty(u, CHI, CHI_T, history)
        force = result.force.reshape(-1, d)
        total = (
            result.points.weight[:, None] * (result.pressure[:, None] * result.points.normal + result.traction)
        ).sum(0)
        scale = np.abs(force).sum()
        assert scale > 0.01
        assert np.allclose(force[upper].sum(0), total, atol=1e-14 * scale)  # + on the slave
        assert np.allclose(force[~upper].sum(0), -total, atol=1e-14 * scale)
        if friction == 0 and degree >= geometry_degree:  # positions are then sums of shape functions times nodes
            assert np.allclose(moment(x, force), 0, atol=1e-14 * scale)


def test_coulomb_law_by_hand():
    """One facet dragged over a plane: stick, slip, unloading, an open point forgets."""
    points, cells = box("quadrilateral", (1, 1), 1)
    model = ir.Model(points, cells, "quadrilateral", material("quadrilateral"))
    slave = facets_where(points, cells, "quadrilateral", lambda x: x[1] < 1e-9)
    contact = ir.Contact(model, slave, ir.RigidPlane([0, 0], [0, 1]), friction=0.5, rule=2)
    chi, chi_t, depth = 100.0, 40.0, 0.01  # p = 1, bound 0.5, which a slip of 0.0125 reaches

    def state(x, y=-depth):
        return np.tile([x, y], 4)

    result = contact.penalty(state(0.01), chi, chi_t)
    assert np.allclose(result.pressure, 1) and np.all(result.status == 1)
    assert np.allclose(result.traction, [-0.4, 0])
    assert np.allclose(result.history.slip, 0)
    assert np.allclose(result.force.reshape(-1, 2).sum(0), [-0.4, 1])
    result = contact.penalty(state(0.03), chi, chi_t, result.history)
    assert np.all(result.status == 2) and np.allclose(result.traction, [-0.5, 0])
    assert np.allclose(result.history.slip, [0.03 - 0.0125, 0])  # less the elastic part 0.5 / chi_t
    back = contact.penalty(state(0.02), chi, chi_t, result.history)
    assert np.all(back.status == 1) and np.allclose(back.traction, [-0.1, 0])
    assert np.allclose(back.history.slip, result.history.slip)
    lifted = contact.penalty(state(0.02, 0.1), chi, chi_t, back.history)
    assert np.all(lifted.status == 0) and np.allclose(lifted.history.traction, 0)
    again = contact.penalty(state(0.02), chi, chi_t, lifted.history)
    assert np.allclose(again.traction, 0) and np.all(again.status == 1)
    # without chi_t it is chi
    assert np.allclose(contact.penalty(state(0.001), chi).traction, [-0.1, 0])
    # moving the obstacle is the same as moving the body the other way
    contact.obstacle.displacement = [-0.01, 0]
    assert np.allclose(contact.penalty(state(0.0), chi, chi_t).traction, [-0.4, 0])


@pytest.mark.parametrize("rigid", [True, False])
def test_motion_counts_from_closing(rigid):
    """Lowered from a gap of 0.03 to a penetration of 0.01 and dragged by 0.02: a quarter of that is in contact."""
    if rigid:
        points, cells = box("quadrilateral", (1, 1), 1)
        model, master = ir.Model(points, cells, "quadrilateral", material("quadrilateral")), ir.RigidPlane(
            [0, 0], [0, 1]
        )
        slave, upper = facets_where(points, cells, "quadrilateral", lambda x: x[1] < 1e-9), slice(None)
    else:
        pair = blocks("quadrilateral", lower=(1, 1), upper=(1, 1), gap=0.0)
        model, slave, master = pair.model, pair.slave, pair.master
        upper = np.unique(model.field_cells[1:])
    contact = ir.Contact(model, slave, master, friction=9.0, rule=2)
    u = np.zeros((len(model.field_points), 2))
    u[upper] = [0.02, -0.01]
    history = contact.no_history()
    history.u = np.where(u != 0, [0.0, 0.03], 0.0).ravel()
    assert np.allclose(contact.closest_points(history.u).gap, 0.03)
    result = contact.penalty(u.ravel(), 100.0, 40.0, history)
    assert np.allclose(result.traction, [-40 * 0.02 / 4, 0]) and np.all(result.history.touched == 1)
    history.touched[:] = 1  # held closed by a multiplier: the whole step counts
    assert np.allclose(contact.penalty(u.ravel(), 100.0, 40.0, history).traction, [-40 * 0.02, 0])


def test_traction_turns_with_the_normal():
    """A rigid rotation of both bodies turns the traction of the last state, keeping its length and the stick."""
    pair = blocks("quadrilateral", degree=2, geometry_degree=1, lower=(1, 1), upper=(1, 1))
    model = pair.model
    contact = ir.Contact(model, pair.slave, pair.master, friction=0.4)
    x = model.field_points

    def rotated(angle):
        R = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        u = np.zeros_like(x)
        u[np.unique(model.field_cells[1:]), 1] = -0.01
        return ((x + u) @ R.T - x).reshape(-1), R

    history = contact.penalty(rotated(0)[0], 100.0).history
    history.traction[:] = [0.3, 0]
    u, R = rotated(0.1)
    result = contact.penalty(u, 100.0, 1e-9, history)  # hardly any spring: what is left is the turned traction
    assert np.allclose(result.pressure, 1) and np.all(result.status == 1)
    # chi_t times the displacement of the rotation: 1e-10
    assert np.allclose(np.linalg.norm(result.traction, axis=1), 0.3, atol=1e-9)
    assert np.allclose(result.traction, R @ [0.3, 0], atol=1e-9)


def test_axisymmetric_weight():
    """A disc of radius 1 under unit pressure: pi, whatever the displacement."""
    points, cells = box("quadrilateral", (3, 1), 1)
    model = ir.Model(points, cells, "quadrilateral", material("quadrilateral", hypothesis="axisymmetric"), degree=2)
    slave = facets_where(points, cells, "quadrilateral", lambda x: x[1] < 1e-9)
    contact = ir.Contact(model, slave, ir.RigidPlane([0, 0], [0, 1]))
    u = np.tile([0.0, -0.1], len(model.field_points))
    u[0::2] = 0.3 * model.field_points[:, 0]  # the reference radius counts
    result = contact.penalty(u, 10.0)
    assert np.isclose(result.force[1::2].sum(), np.pi, rtol=1e-14)
    assert np.isclose(result.points.weight.sum(), np.pi, rtol=1e-14)
    sphere = ir.Contact(model, slave, ir.RigidSphere([0, -0.9], 1.0))
    x = model.field_points
    assert np.allclose(
        sphere.closest_points(np.zeros_like(u)).gap,
        np.hypot(*(sphere.closest_points(0 * u).position - [0, -0.9]).T) - 1,
    )
    assert x[:, 0].min() >= 0


def test_multiplier_of_the_augmented_method():
    pair = blocks("triangle", gap=-0.01)
    contact = ir.Contact(pair.model, pair.slave, pair.master)
    zero = np.zeros(pair.model.num_dofs)
    multiplier = np.linspace(-2, 2, contact.num_points)
    result = contact.penalty(zero, 100.0, multiplier=multiplier)
    assert np.allclose(result.pressure, np.maximum(0, multiplier + 1))


def test_points_and_rules():
    """The default rule has degree 2 p + 2; a rule may be given as degree or as points and weights."""
    for degree in (1, 2):
        pair = blocks("hexahedron", degree=degree)
        contact = ir.Contact(pair.model, pair.slave, pair.master)
        assert len(contact.facet_rule[1]) == (degree + 2) ** 2
        same = ir.Contact(
            pair.model, pair.slave, pair.master, rule=ir.quadrature("quadrilateral", f"table:{2 * degree + 2}")
        )
        other = ir.Contact(pair.model, pair.slave, pair.master, rule=1)
        u = np.zeros(pair.model.num_dofs)
        u.reshape(-1, 3)[np.unique(pair.model.field_cells[len(pair.lower[1]) :]), 2] = -0.01
        assert np.array_equal(same.penalty(u, 1.0).force, contact.penalty(u, 1.0).force)
        assert other.num_points == len(pair.slave)
        assert np.isclose(other.penalty(u, 1.0).force[2::3].clip(0).sum(), 0.01)
