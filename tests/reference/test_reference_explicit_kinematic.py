# SPDX-License-Identifier: MIT
"""Kinematic contact in explicit dynamics of the hand-written solver against closed forms."""

import impact_reference as ir
import numpy as np
import pytest
from reference_meshes import CELLS, box, dofs, facets_where, nodes_where
from test_reference_explicit_contact import collision, single_mass, spin_of, wall

OPEN, STICK, SLIP = 0, 1, 2


def test_mass_on_a_wall_step_by_step():
    """Free flight, a stop in two steps: first onto the wall, then no more; force m d / h. Nothing presses it there,
    so that it leaves: with the impulse of the two steps, 0.95 of the first."""
    model, free, right = single_mass()
    v0, dt = np.zeros(8), 0.1
    v0[free] = 1.0
    fixed = np.delete(np.arange(8), free)
    run = model.run_explicit(dt, 8, v0=v0, fixed_dofs=fixed, contacts=[ir.NodalKinematic(right, wall(1.25))])
    force = -run.contacts[0].total[:, 0]
    # u = 0.1 0.2 | 0.3 would be 0.05 too far, and next 0.05 again
    back = 0.5 * 0.95 + 0.5
    places = [0, 0.1, 0.2, 0.25, 0.25] + [0.25 - back * dt * n for n in (1, 2, 3, 4)]
    assert np.allclose(run.u[:, free], places, atol=1e-9)
    assert np.allclose(force, [0, 0, 0.05 / dt**2, 0.05 / dt**2, back / dt, 0, 0, 0, 0], atol=1e-6)
    assert run.contacts[0].status[:, -1].tolist() == [0, 0, 2, 2, 2, 0, 0, 0, 0]
    # The wall takes 1/2; E goes by means over two steps, so that all of it is taken before the mass leaves.
    assert np.isclose(run.energies["impact"][3], 0.5) and np.abs(run.energies["drift"]).max() < 1e-12
    assert np.isclose(run.energies["impact"][-1], (1 - back**2) / 2) and (run.energies["contact"] == 0).all()


def test_mass_pressed_on_a_wall():
    """A load on a mass at the wall: the force is the load from the first state on, and nothing moves."""
    model, free, right = single_mass()
    load = np.zeros(8)
    load[free] = 3.0
    fixed = np.delete(np.arange(8), free)
    for scheme, alpha in (("half_step", 0.0), ("half_step", 0.5), ("classical", 0.0), ("classical", 0.5)):
        contact = ir.NodalKinematic(right, wall(1.0))
        run = model.run_explicit(0.1, 5, fixed_dofs=fixed, loads=load, contacts=[contact], scheme=scheme, alpha=alpha)
        assert np.allclose(run.contacts[0].total[:, 0], -3.0, atol=1e-12)
        assert np.abs(run.u).max() < 1e-15 and np.abs(run.v).max() < 1e-14


@pytest.mark.covering(1)
@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_momentum_and_gap(cell, friction):
    """Not matching: the gap falls with the sweeps, momentum and energy stay whatever their number."""
    model, slave, master, v0 = collision(cell, "linear_elastic", density=2.0)
    dt = 0.8 * model.stable_step()
    deepest = []
    for sweeps in (1, 3, 30):
        contact = ir.NodalKinematic(slave, master, friction=friction, sweeps=sweeps)
        run = model.run_explicit(dt, 120, v0=v0, contacts=[contact])
        _, momentum, size = spin_of(model, run)
        assert np.abs(momentum - momentum[0]).max() < 1e-12 * size
        assert np.abs(run.energies["drift"]).max() < 1e-12
        history = run.contacts[0]
        closed = history.status > 0
        assert closed.any()
        # What is left at t_(n+1), linearised, is the gap found there if nothing has turned.
        deepest.append(-history.gap[closed].min())
        t = np.linalg.norm(history.traction, axis=2)
        if friction:
            assert (history.status == STICK).any() and (history.status == SLIP).any()
            assert run.energies["friction"][-1] > 0
        else:
            assert t.max() == 0
    # With friction the cone holds back what sweeps still lack.
    assert deepest[1] < 0.4 * deepest[0] and deepest[2] < (0.4 * deepest[0] if friction else deepest[1])


def test_sticking_nodes_do_not_slip():
    """A block thrown obliquely at a wall that holds it: friction 5 keeps what has closed in its place."""
    points, cells = box("quadrilateral", (3, 3))
    model = ir.Model(points, cells, "quadrilateral", ir.Material(100.0, 0.3, 1.0, "plane_strain"))
    right = facets_where(points, cells, "quadrilateral", lambda x: x[0] == 1)
    v0 = np.tile([1.0, 0.3], len(points))
    dt = 0.5 * model.stable_step()
    contact = ir.NodalKinematic(right, wall(1.02), friction=5.0)
    run = model.run_explicit(dt, 60, v0=v0, contacts=[contact])
    history = run.contacts[0]
    place = run.u.reshape(len(run.time), -1, 2)[:, history.nodes]
    stuck = history.status[:-1] == STICK
    assert stuck.sum() > 20
    assert np.abs(np.diff(place[..., 1], axis=0)[stuck]).max() < 1e-15
    stays = stuck & (history.status[1:] > 0)  # the others leave, without slip
    assert stays.sum() > 15 and np.abs(place[1:, :, 0][stays] - 0.02).max() < 1e-15
    force = history.total[:, 0]
    assert np.abs(run.energies["drift"]).max() < 1e-12 and force.min() < 0


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_slipping_node_is_cut_back_to_the_cone(friction):
    """A block that slides along a wall it is pressed on: the tangential force is friction times the normal one."""
    points, cells = box("quadrilateral", (1, 1))
    model = ir.Model(points, cells, "quadrilateral", ir.Material(1.0, 0.0, 4.0, "plane_strain"))
    low = facets_where(points, cells, "quadrilateral", lambda x: x[1] == 0)
    contact = ir.NodalKinematic(low, ir.RigidPlane([0, 0], [0, 1.0]), friction=friction)
    run = model.run_explicit(
        0.1, 10, v0=np.tile([9.0, 0.0], 4), loads=model.body_force([0.0, -2.0]), contacts=[contact]
    )
    history = run.contacts[0]
    f = history.force.reshape(len(run.time), -1, 2)[:, history.nodes]
    assert (f[..., 1] > 0).all() and (history.status == SLIP).all()
    assert np.allclose(f[..., 0], -friction * f[..., 1], rtol=1e-12)
    assert np.isclose(run.energies["friction"][-1] > 0, friction > 0)


@pytest.mark.parametrize("kind", [ir.NodalPenalty, ir.NodalKinematic])
@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_both_schemes_agree_with_contact(kind, friction):
    model, slave, master, v0 = collision("triangle")
    dt = 0.5 * model.stable_step()
    runs = [
        model.run_explicit(dt, 300, v0=v0, contacts=[kind(slave, master, friction=friction)], scheme=scheme)
        for scheme in ("half_step", "classical")
    ]
    assert np.abs(runs[0].contacts[0].force).max() > 0
    for name, tolerance in (("u", 1e-10), ("v", 1e-8)):
        one, two = (getattr(run, name) for run in runs)
        assert np.abs(one - two).max() < tolerance * np.abs(one).max()


def test_fixed_master_is_a_wall():
    """A body whose every node is prescribed: masters do not move, sweeps end on it as on a rigid plane."""
    p, c = box("quadrilateral", (3, 1), mapping=lambda x: x - [0, 1])
    q, e = box("quadrilateral", (4, 2), mapping=lambda x: 0.8 * x + [0.1, 0.01])
    points, cells = np.vstack([p, q]), np.vstack([c, e + len(p)])
    model = ir.Model(points, cells, "quadrilateral", ir.Material(10.0, 0.3, 1.0, "plane_strain"))
    slave = facets_where(q, e, "quadrilateral", lambda x: x[1] == 0.01) + len(p)
    master = facets_where(p, c, "quadrilateral", lambda x: x[1] == 0)
    held = dofs(nodes_where(points, lambda x: x[1] <= 0), (0, 1), 2)
    v0 = np.tile([0.02, -1.0], len(points))  # the slave stays over the master
    v0[held] = 0
    dt = 0.5 * model.stable_step()
    for friction in (0.0, 0.3):
        runs = [
            model.run_explicit(
                dt,
                100,
                v0=v0,
                fixed_dofs=held,
                contacts=[ir.NodalKinematic(slave, m, friction=friction, sweeps=sweeps)],
            )
            # Neither gives way: one sweep is enough.
            for m, sweeps in ((master, 1), (ir.RigidPlane([0, 0], [0, 1.0]), 3))
        ]
        assert np.abs(runs[0].contacts[0].total).max() > 0
        assert np.allclose(runs[0].u, runs[1].u, rtol=0, atol=1e-13)
        assert np.allclose(runs[0].contacts[0].total, runs[1].contacts[0].total, rtol=0, atol=1e-10)
        for run in runs:
            assert np.abs(run.energies["drift"]).max() < 1e-12


def test_prescribed_slave_pushes_a_body():
    """A slave that is driven does not move by its forces; the master gives way, and energies add up."""
    p, c = box("quadrilateral", (4, 2), mapping=lambda x: x - [0, 1])
    q, e = box("quadrilateral", (4, 1), mapping=lambda x: x * [1, 0.5])
    points, cells = np.vstack([p, q]), np.vstack([c, e + len(p)])
    model = ir.Model(points, cells, "quadrilateral", ir.Material(10.0, 0.0, 1.0, "plane_strain"))
    slave = facets_where(q, e, "quadrilateral", lambda x: x[1] == 0) + len(p)
    master = facets_where(p, c, "quadrilateral", lambda x: x[1] == 0)
    held = dofs(np.arange(len(p), len(points)), (0, 1), 2)
    down = np.zeros(held.size)
    down[1::2] = -0.1
    run = model.run_explicit(
        0.5 * model.stable_step(),
        100,
        fixed_dofs=held,
        values=lambda t: down * t,
        contacts=[ir.NodalKinematic(slave, master, sweeps=40)],
    )
    assert np.allclose(run.u[:, held], np.outer(run.time, down), rtol=0, atol=1e-15)
    mass = model.mass(lumped=True)
    momentum = mass[1 : 2 * len(p) : 2] @ run.v_half[:, 1 : 2 * len(p) : 2].T
    impulse = np.cumsum(-run.contacts[0].total[:, 1]) * run.time[1]
    impulse += run.contacts[0].total[0, 1] * run.time[1] / 2
    assert np.allclose(momentum, impulse, rtol=0, atol=1e-12) and momentum[-1] < 0
    assert run.contacts[0].gap.min() > -1e-9
    assert np.abs(run.energies["drift"]).max() < 1e-12 and run.energies["external"][-1] > 0
