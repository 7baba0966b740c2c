# SPDX-License-Identifier: MIT
"""Implicit contact of the hand-written solver: exact impacts, momentum, friction, springs."""

import impact_reference as ir
import numpy as np
import pytest
from contact_bodies import blocks
from reference_meshes import box, dofs, facets_where, nodes_where

MULTIPLIERS, PENALTY = {}, {"chi": 3e5}


def falling_bar(cells=40, **method):
    """I-2 of BENCHMARKS: E = 900, density 1, length 10, 5 above a wall, falling with 10."""
    points, c = box("quadrilateral", (1, cells), mapping=lambda x: np.array([0.1 * x[0], 5 + 10 * x[1]]))
    model = ir.Model(points, c, "quadrilateral", ir.Material(900.0, 0.0, 1.0, "plane_strain"))
    foot = facets_where(points, c, "quadrilateral", lambda x: abs(x[1] - 5) < 1e-9)
    across = 2 * np.arange(len(points))
    wall = ir.RigidPlane((0.0, 0.0), (0.0, 1.0))
    contact = ir.ImplicitContact(ir.Contact(model, foot, wall, prescribed=across), **method)
    v0 = np.tile([0.0, -10.0], len(points))
    return model, {"v0": v0, "fixed_dofs": across, "contact": contact, "scheme": ir.NewmarkScheme.chung_hulbert(0.8)}


@pytest.mark.parametrize("method", (MULTIPLIERS, PENALTY))
def test_bar_on_a_wall(method):
    """I-2: contact from 0.5 to 1.1667 (limit: one step and what waves take through two cells), pressure 300 within
    1 %, energy: no gain (0.1 %), 5 % loss at most."""
    model, options = falling_bar(**method)
    run = model.run_newmark(5e-3, 320, **options)
    pressure = run.contact.total[:, 1] / 0.1
    closed = run.time[pressure > 30]
    assert abs(closed[0] - 0.5) < 0.01 and abs(closed[-1] - 7 / 6) < 0.02
    plateau = pressure[(run.time > closed[0] + 0.07) & (run.time < closed[-1] - 0.07)]
    assert abs(plateau.mean() / 300 - 1) < 0.01
    energy = run.energies["total"] / run.energies["total"][0]
    assert energy.max() < 1.001 and energy[-1] > 0.95
    assert np.allclose(run.contact.force.reshape(len(run.time), -1, 2).sum(axis=1), run.contact.total)
    mass = model.mass()
    momentum = np.array([mass.dot(v)[1::2].sum() for v in run.v])
    assert abs(momentum[0] + 10) < 1e-12 and abs(momentum[-1] - 10) < 0.02 * 10
    if method is MULTIPLIERS:  # with mass on the foot the pressure rattles: what the redistribution is for
        rattling = model.run_newmark(5e-3, 320, redistribute=False, **options).contact.total[:, 1] / 0.1
        on = (run.time > closed[0] + 0.2) & (run.time < closed[-1] - 0.1)
        assert np.ptp(pressure[on]) < 0.02 * 300 < 300 < np.ptp(rattling[on])


@pytest.mark.parametrize("lumping", ("consistent", "auto"))
@pytest.mark.parametrize("method", (MULTIPLIERS, {"chi": 50.0}))
def test_two_bodies_keep_momentum(method, lumping):
    """A block thrown on another one in free flight: the impulse of contact goes from one to the other."""
    pair = blocks("quadrilateral", gap=0.01, shift=0.2, E=1.0, nu=0.3)
    law = ir.Material(1.0, 0.3, 1.0, "plane_strain")
    model = ir.Model(pair.model.points, pair.model.cells, pair.cell, law)
    contact = ir.ImplicitContact(ir.Contact(model, pair.slave, pair.master), **method)
    v0 = np.zeros_like(model.field_points)
    upper = np.arange(len(v0)) >= pair.split
    v0[upper] = [0.02, -0.05]
    run = model.run_newmark(0.05, 60, v0=v0.ravel(), contact=contact, lumping=lumping)
    flags = np.zeros(len(v0), dtype=bool)
    flags[np.unique(np.concatenate([pair.slave.ravel(), pair.master.ravel()]))] = True
    mass = ir.newmark._reference.inertia_matrix(model._model, *model._rule("mass"), lumping, flags.tolist())
    momenta = np.array([ir.Csr(*mass.arrays).dot(v).reshape(-1, 2) for v in run.v])
    total = momenta.sum(axis=1)
    assert np.abs(total - total[0]).max() < 1e-9 * np.abs(total[0]).max()
    assert momenta[-1, ~upper, 1].sum() < 0.2 * total[0, 1] < 0, "the lower block has been pushed"
    assert np.allclose(run.contact.force.reshape(61, -1, 2).sum(axis=1), 0, atol=1e-12)
    assert run.contact.total[:, 1].max() > 0.005
    energy = run.energies["total"]
    assert np.abs(energy / energy[0] - 1).max() < 0.05


@pytest.mark.parametrize("method", (MULTIPLIERS, {"chi": 2e3}))
def test_block_slides_to_rest(method):
    """Coulomb friction: a stiff block with the velocity v under gravity g stops after v^2 / (2 mu g), within 2 %."""
    points, c = box("quadrilateral", (4, 2), mapping=lambda x: x * [2.0, 0.5])
    model = ir.Model(points, c, "quadrilateral", ir.Material(200.0, 0.3, 1.0, "plane_strain"))
    foot = facets_where(points, c, "quadrilateral", lambda x: x[1] < 1e-9)
    floor = ir.RigidPlane((0.0, 0.0), (0.0, 1.0))
    contact = ir.ImplicitContact(ir.Contact(model, foot, floor, friction=0.3), **method)
    weight = model.body_force([0.0, -1.0])
    corner = nodes_where(points, lambda x: np.all(x < 1e-9))
    side = dofs(nodes_where(points, lambda x: x[1] < 1e-9), 1, 2)
    rest = model.solve_static(np.concatenate([side, 2 * corner]), load=weight).u
    v0 = np.tile([0.5, 0.0], len(points))
    run = model.run_newmark(
        0.01, 250, u0=rest, v0=v0, loads=[weight], contact=contact, scheme=ir.NewmarkScheme.chung_hulbert(0.5),
        damping=(0.0, 0.02),
    )  # fmt: skip
    way, expected = run.u[-1, ::2].mean() - rest[::2].mean(), 0.5**2 / (2 * 0.3)
    assert abs(way / expected - 1) < 0.02
    assert np.abs(run.v[-1]).max() < 0.02
    status = run.contact.status
    assert np.any(status[50] == 2) and np.all(status[-1][status[-1] > 0] == 1), "it has slid, and sticks"
    # Its kinetic energy has become work of friction, within 3 % (the rest goes to swings and their damping).
    assert abs(run.energies["friction"][-1] / run.energies["kinetic"][0] - 1) < 0.03


def test_moving_obstacle_does_work():
    """A plane that pushes a free block: its work is the energy of the block, its impulse the momentum."""
    points, c = box("quadrilateral", (3, 3), distort=0.1)
    model = ir.Model(points, c, "quadrilateral", ir.Material(10.0, 0.3, 1.0, "plane_strain"))
    foot = facets_where(points, c, "quadrilateral", lambda x: x[1] < 1e-9)
    plane = ir.RigidPlane((0.0, -1.03e-3), (0.0, 1.0))  # it touches between two steps
    moved = lambda t: np.array([0.0, 0.1 * t**2])  # noqa: E731
    contact = ir.ImplicitContact(ir.Contact(model, foot, plane), motion=moved)
    run = model.run_newmark(0.01, 200, contact=contact, scheme=ir.NewmarkScheme.chung_hulbert(0.9))
    assert np.array_equal(np.broadcast_to(plane.displacement, 2), np.zeros(2)), "the obstacle is left where it was"
    energies = run.energies
    work = energies["external"][-1]
    assert work > 0.05 and abs(energies["total"][-1]) < 0.01 * work
    force = run.contact.total[:, 1]
    impulse = 0.01 * (force.sum() - force[-1] / 2)
    momentum = model.mass().dot(run.v[-1])[1::2].sum()
    assert abs(impulse / momentum - 1) < 0.01
    # The block follows the plane up to a swing of 2 * 0.2 / omega^2, omega^2 about (pi / 2)^2 E = 25.
    assert abs(run.u[-1, 1::2].mean() - moved(run.time[-1])[1]) < 0.02


def test_penalty_springs_swing():
    """I-9 of BENCHMARKS in small: a nearly rigid block on springs, half a period of sqrt(chi A / m) in contact."""
    points, c = box("quadrilateral", (1, 1))
    model = ir.Model(points, c, "quadrilateral", ir.Material(1e6, 0.0, 1.0, "plane_strain"))
    foot = facets_where(points, c, "quadrilateral", lambda x: x[1] < 1e-9)
    floor = ir.RigidPlane((0.0, -1e-9), (0.0, 1.0))
    contact = ir.ImplicitContact(ir.Contact(model, foot, floor), chi=1.0)
    v0 = np.tile([0.0, -0.1], 4)
    run = model.run_newmark(
        0.01, 400, v0=v0, contact=contact, redistribute=False, scheme=ir.NewmarkScheme.chung_hulbert(0.5)
    )
    closed = run.time[run.contact.total[:, 1] > 0]
    assert abs(closed[-1] - np.pi) < 0.02, "half a period of omega = 1"
    assert abs(run.contact.total[:, 1].max() - 0.1) < 1e-4
    assert abs(run.energies["contact"].max() / run.energies["kinetic"][0] - 1) < 1e-3
    assert np.allclose(run.v[-1, 1::2], 0.1, atol=1e-3)


def test_what_does_not_fit_is_refused():
    model, options = falling_bar(2)
    contact = options["contact"].contact
    with pytest.raises(ValueError, match="positive"):
        ir.ImplicitContact(contact, chi=0.0)
    pair = blocks("quadrilateral")
    with pytest.raises(ValueError, match="motion"):
        ir.ImplicitContact(ir.Contact(pair.model, pair.slave, pair.master), motion=[0.0, 1.0])
    with pytest.raises(ValueError, match="basis"):
        model.run_newmark(0.1, 1, **{**options, "contact": ir.ImplicitContact(contact, basis="best")})
    with pytest.raises(RuntimeError, match="converge"):
        model.run_newmark(0.5, 2, max_iterations=1, **options)
