# SPDX-License-Identifier: MIT
"""The energy of springs and of nodes that leave, in explicit contact of the hand-written solver: what contact has not
taken it does not give."""

import impact_reference as ir
import numpy as np
import pytest
from reference_meshes import box, facets_where
from test_reference_explicit_contact import collision, single_mass, wall
from test_reference_explicit_overlap import flight

# Sums of some hundred steps.
ROUND_OFF = 1e-12


@pytest.mark.parametrize("kappa, num_steps", [(0.5, 12), (0.1, 20)])
def test_mass_that_bounces_once(kappa, num_steps):
    """`impact` is what the bounce costs, to round-off, wherever the first touch lies between two steps; it costs a
    little less than nothing only where the mass opens faster than foreseen."""
    gains = []
    for k in range(40):
        _, free, run = flight(kappa, 1 + (k + 0.5) / 40, num_steps)
        e = run.energies
        assert run.contacts[0].status[-1].max() == 0 and run.v_half[-1, free] < 0
        assert np.abs(e["drift"]).max() < ROUND_OFF
        # The cell's own energy: 1e-9 times the square of displacements up to 20.
        assert np.isclose(e["impact"][-1], e["kinetic"][0] - run.v_half[-1, free] ** 2 / 2, rtol=0, atol=5e-7)
        gains.append(-e["impact"][-1] / e["kinetic"][0])
    # docs/explicit/accuracy.md, "What closing between two steps costs": the largest gain.
    assert min(gains) < 0 and max(gains) < (0.0045 if kappa == 0.5 else 0.00005)


def test_pressed_at_the_start():
    """A spring that is compressed at t_0 holds k g^2 / 2 from the start and gives that back, not more."""
    model, free, right = single_mass()
    u0 = np.zeros(8)
    u0[free] = 0.3
    fixed = np.delete(np.arange(8), free)
    contact = ir.NodalPenalty(right, wall(1.0), penalty=0.4)  # the node's area is 1/2
    run = model.run_explicit(0.1, 60, u0=u0, fixed_dofs=fixed, contacts=[contact])
    e = run.energies
    assert np.isclose(e["contact"][0], 0.2 * 0.3**2 / 2) and abs(e["impact"][0]) < ROUND_OFF
    assert np.abs(e["drift"]).max() < ROUND_OFF and run.contacts[0].status[-1].max() == 0
    # k dt^2 / m = 0.002
    assert np.isclose(e["kinetic"][-1], e["contact"][0], rtol=2e-3)


def resting(friction):
    """A single quadrilateral that falls on a plane and stays there."""
    points, cells = box("quadrilateral", (1, 1))
    model = ir.Model(points, cells, "quadrilateral", ir.Material(1.0, 0.3, 1.0, "plane_strain"))
    low = facets_where(points, cells, "quadrilateral", lambda x: x[1] == 0)
    contact = ir.NodalPenalty(low, ir.RigidPlane([0, -0.01], [0, 1.0]), friction=friction)
    run = model.run_explicit(
        0.9 * model.stable_step(),
        20000,
        v0=np.tile([0.0, -0.02], 4),
        loads=model.body_force([0.0, -0.01]),
        contacts=[contact],
        every=10,
    )
    return run.energies, 0.02**2 / 2 + 0.01 * 0.01


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_what_rests_comes_to_rest(friction):
    """Nodes close and open for 20,000 steps: what moves falls instead of growing, and `total` is kept."""
    e, touch = resting(friction)
    # Round-off of 20,000 steps; the plane neither turns nor bends.
    assert np.abs(e["drift"]).max() < 1e-9
    late = len(e["kinetic"]) // 2
    assert e["kinetic"][late:].max() < 0.5 * touch
    moving = e["kinetic"] + e["internal"] + e["contact"] - e["external"]
    # Debts: nodes that open faster than foreseen.
    assert moving.max() < moving[0] + 0.03 * touch and e["impact"].min() > -0.03 * touch
    assert friction == 0 or e["friction"][-1] > 0


def pulled_off(load, num_steps):
    """A mass 1 with the speed 1, 1/4 from a wall, pressed by a load for 80 steps of 0.1 and then not: the run, its
    free dof."""
    model, free, right = single_mass()
    v0, direction = np.zeros(8), np.zeros(8)
    v0[free] = direction[free] = 1.0
    times, amplitudes = np.array([0, 8.04, 8.06, 1e3]), np.array([load, load, 0, 0])
    run = model.run_explicit(
        0.1,
        num_steps,
        v0=v0,
        fixed_dofs=np.delete(np.arange(8), free),
        loads=[(direction, (times, amplitudes)), (-1e-6 * direction, 1.0)],
        contacts=[ir.NodalKinematic(right, wall(1.25))],
    )
    return run, free


def test_a_node_that_leaves_gets_back_what_it_lost():
    """Pressed with an impulse of more than m V in 20 steps, it leaves with the speed V at which it came."""
    load = 1.0
    run, free = pulled_off(load, 100)
    speed, e = -run.v_half[:, free], run.energies
    came = np.sqrt(2 * (e["kinetic"][0] + load * 0.25))
    assert np.allclose(speed[4:80], 0, atol=1e-9)
    # Of 1e-6: the load that pulls it off, the cell's stiffness.
    assert np.isclose(e["impact"][70], came**2 / 2, rtol=1e-5)
    assert np.allclose(speed[83:], came, rtol=1e-5)
    assert np.abs(e["impact"][-1]) < 1e-5 and np.abs(e["drift"]).max() < ROUND_OFF
    status = run.contacts[0].status[:, -1]
    left = int(np.flatnonzero(status)[-1])
    assert status[left] == 2 and (run.contacts[0].force[left + 1 :] == 0).all()
    assert np.isclose(-run.contacts[0].total[left, 0] * 0.1, came, rtol=1e-4)


def test_a_node_that_is_lifted_off_gently_is_not_thrown_off():
    """Pressed lightly it leaves with the impulse of about its last 20 steps: P = 0.95 P + dt f."""
    load = 0.001
    run, free = pulled_off(load, 100)
    f = -run.contacts[0].total[:, 0]
    left = int(np.flatnonzero(f)[-1])
    P = 0.0
    for n in range(left):
        P = 0.95 * P + 0.1 * f[n]
    assert left > 79 and np.isclose(f[left] * 0.1, P, rtol=1e-12)
    assert np.allclose(-run.v_half[left + 2 :, free], P, rtol=1e-2) and P < 0.05
    assert np.abs(run.energies["drift"]).max() < ROUND_OFF and run.energies["impact"][-1] > 0.4


def test_a_bar_leaves_the_wall_with_what_it_brought():
    """I-1: nothing is lost but the work of forces at which nodes part from the wall by fractions of a step."""
    points, cells = box("quadrilateral", (50, 1), mapping=lambda x: x * [1, 0.02])
    model = ir.Model(points, cells, "quadrilateral", ir.Material(1.0, 0.0, 1.0, "plane_strain"))
    right = facets_where(points, cells, "quadrilateral", lambda x: x[0] == 1)
    dt = 0.9 * model.stable_step()
    v0 = np.tile([0.01, 0.0], len(points))
    run = model.run_explicit(dt, int(3.0 / dt), v0=v0, contacts=[ir.NodalKinematic(right, wall(1.0))])
    e = run.energies
    end = 1e-4 / 2 * 0.02 / 100  # of the end's nodes: half a cell
    assert np.isclose(e["impact"][int(1.0 / dt)], end, rtol=0.05)
    assert run.contacts[0].status[-1].max() == 0 and -1e-9 * end < e["impact"][-1] < 0.02 * end
    assert np.abs(e["drift"]).max() < ROUND_OFF


@pytest.mark.covering(1)
@pytest.mark.parametrize("cell", ["quadrilateral", "triangle", "hexahedron", "tetrahedron"])
@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_nodes_that_leave_a_body(cell, friction):
    """Bodies that are not flat, do not match and turn: in all contact takes, and both momenta's forces stay
    opposite."""
    model, slave, master, v0 = collision(cell, "linear_elastic", density=2.0, inner=True)
    run = model.run_explicit(
        0.8 * model.stable_step(), 400, v0=v0, contacts=[ir.NodalKinematic(slave, master, friction=friction)]
    )
    contact, e = run.contacts[0], run.energies
    d = model.points.shape[1]
    f = contact.force.reshape(len(run.time), -1, d)
    assert np.abs(f.sum(1)).max() < 1e-12 * np.abs(f).max()
    assert (contact.status[:-1] > 0)[(contact.status[1:] == 0)].any()
    apart = np.flatnonzero((np.abs(f).max((1, 2)) > 0))[-1] + 1
    assert apart < len(run.time)  # all have left
    assert e["impact"][apart:].min() > 0 and np.abs(e["drift"]).max() < ROUND_OFF
    moving = e["kinetic"] + e["internal"]
    assert moving.max() < moving[0] * (1 + ROUND_OFF)
