# SPDX-License-Identifier: MIT
"""Frictional equilibrium of the hand-written solver against hand calculations and published values."""

import impact_reference as ir
import numpy as np
import pytest
from contact_bodies import blocks, gdim_of, material
from reference_meshes import CELLS, box, dofs, facets_where, join, nodes_where

METHODS = ["lagrange", "penalty"]


def solve(contact, method, fixed, values=0.0, load=None, chi=1e7, **options):
    if method == "lagrange":
        return contact.solve_lagrange(fixed, values, load, **options)
    return contact.solve_penalty(fixed, values, load, chi=chi, **options)


def block_on_plane(cell, degree, friction, nu=0.0):
    d = gdim_of(cell)
    points, cells = box(cell, (3, 2, 2)[:d], degree)
    model = ir.Model(points, cells, cell, material(cell, E=1e4, nu=nu), geometry_degree=degree)
    slave = facets_where(points, cells, cell, lambda x: x[-1] < 1e-9)
    top = facets_where(points, cells, cell, lambda x: x[-1] > 1 - 1e-9)
    return model, ir.Contact(model, slave, ir.RigidPlane(np.zeros(d), np.eye(d)[-1]), friction=friction), top


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("degree", [1, 2])
def test_block_sticks(method, cell, degree):
    """A block held by friction alone carries a force of 0.2 of its weight when the coefficient is 0.6."""
    d = gdim_of(cell)
    model, contact, top = block_on_plane(cell, degree, 0.6)
    body = 2.0 * np.eye(d)[0] - 10.0 * np.eye(d)[-1]
    s = solve(contact, method, np.zeros(0, dtype=int), load=model.body_force(body))
    force = s.contact_force.reshape(-1, d).sum(0)
    assert np.allclose(force, -body, atol=1e-9)
    closed = s.status > 0
    assert (s.status == 1).sum() > 0.5 * closed.sum()
    size = np.linalg.norm(s.traction, axis=1)
    assert np.all(size[closed] <= 0.6 * s.pressure[closed] * (1 + 1e-12) + 1e-12)
    slips = s.status == 2
    assert np.allclose(size[slips], 0.6 * s.pressure[slips], rtol=1e-10)
    # no further than an elastic shear: p / G plus, with penalty, p / chi
    assert np.abs(s.u.reshape(-1, d)[:, 0]).max() < 4 * 2.0 / 5e3


@pytest.mark.parametrize("method", METHODS)
def test_block_that_cannot_be_held(method):
    """More than the friction: there is no equilibrium, and the solver says so."""
    model, contact, _ = block_on_plane("quadrilateral", 1, 0.15)
    with pytest.raises(RuntimeError, match="did not converge"):
        solve(contact, method, np.zeros(0, dtype=int), load=model.body_force([2.0, -10.0]), max_iterations=12)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("degree", [1, 2])
def test_block_slides(method, cell, degree):
    """The top is pushed down by 1e-3 and sideways by 1e-2: everything slips, T = friction x N against the motion."""
    d = gdim_of(cell)
    model, contact, _ = block_on_plane(cell, degree, 0.3)
    push = np.array([1e-2, 5e-3, 0])[:d] if d == 3 else np.array([1e-2, 0])
    push[-1] = -1e-3
    top = nodes_where(model.field_points, lambda x: x[-1] > 1 - 1e-9)
    fixed, values = dofs(top, range(d), d), np.tile(push, len(top))
    s = solve(contact, method, fixed, values, steps=2)
    force = s.contact_force.reshape(-1, d).sum(0)
    closed = s.status > 0
    assert np.all(s.status[closed] == 2) and closed.any()
    N, T = force[-1], force[:-1]
    assert np.isclose(N, 10.0, rtol=5e-3)  # E x strain x area; the drag bends the block a little
    # the directions of slip differ from node to node by 1e-4
    assert np.isclose(np.linalg.norm(T), 0.3 * N, rtol=1e-6)
    assert np.allclose(T / np.linalg.norm(T), -push[:-1] / np.linalg.norm(push[:-1]), atol=5e-3)
    assert np.allclose(s.reactions.reshape(-1, d).sum(0), -force, atol=1e-9 * N)


@pytest.mark.parametrize("method", METHODS)
def test_moving_the_plane_is_moving_the_block(method):
    """Obstacle displacements go along with the steps; relative motion is all that counts."""
    model, contact, _ = block_on_plane("quadrilateral", 2, 0.3, nu=0.3)
    top = nodes_where(model.field_points, lambda x: x[1] > 1 - 1e-9)
    fixed = dofs(top, (0, 1), 2)
    moved = solve(contact, method, fixed, np.tile([1e-2, -1e-3], len(top)), steps=3)
    contact.obstacle.displacement = [-1e-2, 1e-3]
    still = solve(contact, method, fixed, 0.0, steps=3)
    assert (moved.status == 2).any()
    assert np.allclose(still.u + np.tile([1e-2, -1e-3], len(model.field_points)), moved.u, atol=1e-12)
    assert np.allclose(still.contact_force, moved.contact_force, atol=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_steps_and_restarts_are_the_same(method):
    """Two steps at once, or one and then another from its solution, with load, values and obstacle half way."""
    model, contact, top = block_on_plane("triangle", 1, 0.4, nu=0.2)
    nodes = nodes_where(model.field_points, lambda x: x[1] > 1 - 1e-9)
    fixed = dofs(nodes, 0, 2)
    load = model.traction(top, [0, -10.0])
    contact.obstacle.displacement = [0.004, 0.0]
    both = solve(contact, method, fixed, -4e-3, load, steps=2)
    contact.obstacle.displacement = [0.002, 0.0]
    half = solve(contact, method, fixed, -2e-3, 0.5 * load)
    contact.obstacle.displacement = [0.004, 0.0]
    rest = solve(contact, method, fixed, -4e-3, load, start=half)
    assert (both.status == 2).any() and len(both.iterations) == 2
    assert np.allclose(rest.u, both.u, atol=1e-13)
    assert np.allclose(rest.contact_force, both.contact_force, atol=1e-10)
    assert np.array_equal(rest.status, both.status)
    # on the way back friction has turned, at the same place on the way out it has not
    contact.obstacle.displacement = [0.0035, 0.0]
    back, out = solve(contact, method, fixed, -4e-3, load, start=both), solve(contact, method, fixed, -4e-3, load)
    assert (both.contact_force @ np.tile([1, 0], len(model.field_points))) > 3.99
    assert back.contact_force[0::2].sum() < out.contact_force[0::2].sum() - 0.2


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("cell", CELLS)
def test_sticking_blocks_are_one_body(method, cell):
    """Matching meshes and a coefficient that is never reached: the solution of the merged mesh."""
    d = gdim_of(cell)
    cut = (3, 2, 1)[:d]
    pair = blocks(cell, lower=cut, upper=cut, E=1e4, nu=0.3)
    points, cells = join((pair.lower[0], pair.lower[1]), (pair.upper[0], pair.upper[1]))
    merged = ir.Model(points, cells, cell, material(cell, E=1e4, nu=0.3))
    push = 2e-3 * np.eye(d)[0] - 2e-2 * np.eye(d)[-1]
    answers = []
    for model in (merged, pair.model):
        bottom, top = (nodes_where(model.field_points, lambda x: abs(x[-1] - z) < 1e-9) for z in (-1, 1))
        fixed = np.concatenate([dofs(bottom, range(d), d), dofs(top, range(d), d)])
        values = np.concatenate([np.zeros(d * len(bottom)), np.tile(push, len(top))])
        if model is merged:
            answers.append(model.solve_static(fixed, values).u)
        else:
            contact = ir.Contact(model, pair.slave, pair.master, friction=3.0)
            s = solve(contact, method, fixed, values, chi=1e9)
    assert np.all(s.status[s.pressure > 0] == 1) and (s.pressure > 0).sum() >= 4
    place = {tuple(np.round(x, 9) + 0.0): i for i, x in enumerate(points)}
    same = [place[tuple(np.round(x, 9) + 0.0)] for x in pair.model.field_points]
    error = s.u.reshape(-1, d) - answers[0].reshape(-1, d)[same]
    # multipliers: round-off of the linear systems, 1e-12 of the forces; penalty: traction / chi = 1e3 / 1e9
    assert np.abs(error).max() < (1e-11 if method == "lagrange" else 1e-6)


def test_greco_plate():
    """BENCHMARKS G-5 (code_aster SSNV128): 40 x 40 mm on a rigid floor with friction 1; u_x of the bottom."""
    points, cells = box("quadrilateral", (32, 32), 1, lambda x: 40 * x)
    model = ir.Model(points, cells, "quadrilateral", material("quadrilateral", E=130e3, nu=0.2))
    side = lambda k, value: facets_where(  # noqa: E731
        points, cells, "quadrilateral", lambda x: abs(x[k] - value) < 1e-6
    )
    load = model.traction(side(1, 40.0), [0, -50.0]) + model.traction(side(0, 0.0), [150.0, 0])
    axis = nodes_where(points, lambda x: x[0] > 40 - 1e-6)
    fixed = dofs(axis, 0, 2)
    contact = ir.Contact(model, side(1, 0.0), ir.RigidPlane([0, 0], [0, 1]), friction=1.0, prescribed=fixed)
    s = contact.solve_lagrange(fixed, 0.0, load)
    measured = []
    for x in (0, 1.25, 5, 7.5, 11.25):
        node = nodes_where(points, lambda y: abs(y[0] - x) < 1e-6 and abs(y[1]) < 1e-6)[0]
        measured.append(s.u[2 * node] * 1e-3)
    published = np.array([2.86, 2.72, 2.28, 1.98, 1.50]) * 1e-5
    finer = np.array([2.861, 2.723, 2.287, 1.981, 1.542]) * 1e-5
    assert np.allclose(measured, finer, rtol=0.03)  # the benchmark's threshold; bilinear cells of 1.25 mm
    assert np.allclose(measured, published, rtol=0.05)  # its own uncertainty
