# SPDX-License-Identifier: MIT
"""Node-to-surface penalty contact in explicit dynamics of the hand-written solver against closed forms."""

import impact_reference as ir
import numpy as np
import pytest
from contact_bodies import Pair, blocks
from reference_meshes import boundary, box, facets_where, nodes_where

STICK, SLIP = 1, 2


def wall(x, direction=-1.0):
    """Obstacle to the right of x."""
    return ir.RigidPlane([x, 0.0], [direction, 0.0])


def single_mass(plane=1.0):
    """One free dof without stiffness to speak of, mass 1, node area 1/2, in front of a wall: model, dof, facets."""
    points, cells = box("quadrilateral", (1, 1))
    model = ir.Model(points, cells, "quadrilateral", ir.Material(1e-9, 0.0, 4.0, "plane_strain"))
    free = 2 * int(nodes_where(points, lambda x: x.sum() == 2)[0])
    return model, free, facets_where(points, cells, "quadrilateral", lambda x: x[0] == 1)


def test_mass_on_penalty_spring():
    """I-9 of BENCHMARKS: m = 1, v = 1, k = 1e6: 3.141593 ms, 1000 N, 1 mm."""
    model, free, right = single_mass()
    v0 = np.zeros(8)
    v0[free] = 1.0
    contact = ir.NodalPenalty(right, wall(1.0), penalty=2e6)
    fixed = np.delete(np.arange(8), free)
    dt = 2e-6
    run = model.run_explicit(dt, 2000, v0=v0, fixed_dofs=fixed, contacts=[contact])
    force = -run.contacts[0].total[:, 0]
    # In the spring u = sin(omega t) omega^-1 to second order in omega dt = 0.002.
    pressed = run.time[force > 0]
    assert np.isclose(pressed[-1] - pressed[0], np.pi * 1e-3, atol=2 * dt)
    assert np.isclose(force.max(), 1000, rtol=1e-5) and np.isclose(run.u[:, free].max(), 1e-3, rtol=1e-5)
    assert np.isclose(run.v[-1, free], -1, rtol=1e-5)
    # Closing and opening between two steps with the mean overlap: of the order (omega dt)^2.
    assert np.abs(run.energies["drift"]).max() < (1e3 * dt) ** 2
    assert np.isclose(run.energies["contact"].max(), 0.5, rtol=1e-5)


@pytest.mark.parametrize("alpha, value", [(0, 1), (1, 0.910180), (10, 0.425438), (100, 0.140716)])
def test_step_of_a_bar_with_a_spring(alpha, value):
    """T-7 of BENCHMARKS: k = alpha EA / h on the end node; the element's bound lies below."""
    n = 40
    points, cells = box("quadrilateral", (n, 1), mapping=lambda x: x * [1, 5])
    model = ir.Model(points, cells, "quadrilateral", ir.Material(1.0, 0.0, 1.0, "plane_strain"))
    right = facets_where(points, cells, "quadrilateral", lambda x: x[0] == 1)
    across = 2 * np.arange(len(points)) + 1
    contacts = [ir.NodalPenalty(right, wall(1.0), penalty=alpha * n)] if alpha else []
    step = model.stable_step("eigenvalue", fixed_dofs=across, contacts=contacts)
    # The table's bar is as long as it likes: the mode lives at the end.
    assert np.isclose(step * n, value, rtol=2e-3 if alpha == 0 else 1e-6)
    bound = model.stable_step(contacts=contacts)
    omega = 2 / model.stable_step()
    assert np.isclose(bound, 2 / np.sqrt(omega**2 + 2 * alpha * n**2)) and bound <= step


def bar(length, cells, start=0.0, height=0.02, E=207e9, density=7800.0):
    return box("quadrilateral", (cells, 2), mapping=lambda x: [start + length * x[0], height * x[1]])


def test_bar_on_rigid_wall():
    """I-1: force rho c v A for 2 L / c, rebound with v."""
    E, rho, L, v, n = 207e9, 7800.0, 0.5, 5.0, 100
    c = np.sqrt(E / rho)
    points, cells = bar(L, n)
    model = ir.Model(points, cells, "quadrilateral", ir.Material(E, 0.0, rho, "plane_strain"))
    right = facets_where(points, cells, "quadrilateral", lambda x: x[0] == L)
    v0 = np.tile([v, 0.0], len(points))
    dt = 0.9 * model.stable_step()
    steps = int(2.6 * L / c / dt)
    for kind in (ir.NodalPenalty, ir.NodalKinematic):
        run = model.run_explicit(dt, steps, v0=v0, contacts=[kind(right, wall(L))])
        force = -run.contacts[0].total[:, 0] / (rho * c * v * 0.02)
        on = run.time[force > 1e-3]
        # Dispersion of the mesh spreads the release over the passage of some cells.
        assert np.isclose(on[-1], 2 * L / c, rtol=0.04)
        middle = (run.time > 0.2 * L / c) & (run.time < 1.8 * L / c)
        assert np.isclose(force[middle].mean(), 1, rtol=1e-2)
        mass = model.mass(lumped=True)[::2]
        assert np.isclose(mass @ run.v[-1, ::2] / (mass.sum() * v), -1, rtol=2e-2)
        # Less than a tenth of the energy of the end, a 200th of the mass, as the springs open; or round-off.
        assert np.abs(run.energies["drift"]).max() < (5e-4 if kind is ir.NodalPenalty else 1e-12)


def two_bars(n=50, L=0.5, E=207e9, rho=7800.0):
    left, right = bar(L, n, -L), bar(L, n)
    pair = Pair(left, right, "quadrilateral", ir.Material(E, 0.0, rho, "plane_strain"))
    return pair, pair.facets(False, lambda x: abs(x[0]) < 1e-12), pair.facets(True, lambda x: abs(x[0]) < 1e-12)


@pytest.mark.parametrize("kind", ["penalty", "balanced", "kinematic"])
def test_equal_bars_swap_velocities(kind):
    """I-4: stress rho c v for 2 L / c at the closing speed 2 v."""
    pair, left, right = two_bars()
    model, L, v, c = pair.model, 0.5, 5.0, np.sqrt(207e9 / 7800)
    contact = {
        "penalty": ir.NodalPenalty(left, right),
        "balanced": ir.NodalPenalty(left, right, balanced=True),
        "kinematic": ir.NodalKinematic(left, right),
    }[kind]
    sign = np.where(np.arange(len(model.field_points)) < pair.split, 1.0, -1.0)
    v0 = np.stack([v * sign, 0 * sign], 1).reshape(-1)
    dt = 0.9 * model.stable_step()
    # Apart by a step's way: contact that is there from the first step gives nothing back, so that no node would leave.
    u0 = np.stack([-2 * v * dt * (sign > 0), 0 * sign], 1).reshape(-1)
    run = model.run_explicit(dt, int(2.8 * L / c / dt), u0=u0, v0=v0, contacts=[contact])
    mass = model.mass(lumped=True)[::2]
    half = mass[sign > 0].sum()
    assert np.isclose(mass[sign > 0] @ run.v[-1, ::2][sign > 0] / half, -v, rtol=2e-2)
    assert np.abs((run.v[:, ::2] @ mass)).max() < 1e-11 * half * v
    force = -run.contacts[0].total[:, 0] / (7800 * c * v * 0.02)
    middle = (run.time > 0.2 * L / c) & (run.time < 1.8 * L / c)
    assert np.isclose(force[middle].mean(), 1, rtol=1e-2)
    assert np.abs(run.contacts[0].force.reshape(len(run.time), -1, 2).sum(1)).max() < 1e-9 * force.max()
    # As on the wall: the ends are a hundredth of the mass, a twentieth of their energy.
    assert np.abs(run.energies["drift"]).max() < (1e-12 if kind == "kinematic" else 5e-4)
    if kind == "kinematic":
        gap, closed = run.contacts[0].gap, run.contacts[0].status > 0
        leaves = closed & (gap > 1e-15)  # once, at the end
        assert np.abs(gap[closed & ~leaves]).max() < 1e-15 and gap.min() > -1e-15
        assert (leaves.sum(0) == 1).all() and not closed[1:][leaves[:-1]].any()


@pytest.mark.parametrize("kind", [ir.NodalPenalty, ir.NodalKinematic])
def test_sliding_block_stops(kind):
    """G-3: v0 = 5, friction 0.3, g = 9.81: 1.698947 s, 4.247367 m."""
    points, cells = box("quadrilateral", (4, 2), mapping=lambda x: x * [2, 0.5])
    model = ir.Model(points, cells, "quadrilateral", ir.Material(1e4, 0.0, 1.0, "plane_strain"))
    low = facets_where(points, cells, "quadrilateral", lambda x: x[1] == 0)
    dt = 0.5 * model.stable_step()
    # Stiff springs, half a mass over dt^2: what they hold is not dissipated by friction.
    spring = {"penalty": 0.5 * (0.25 / 2) / dt**2} if kind is ir.NodalPenalty else {}
    contact = kind(low, ir.RigidPlane([0, 0], [0, 1.0]), friction=0.3, **spring)
    run = model.run_explicit(
        dt,
        int(2.0 / dt),
        v0=np.tile([5.0, 0.0], len(points)),
        loads=model.body_force([0, -9.81]),
        beta=2e-4,  # or the penalty springs chatter: with them it leaves the floor and the friction's part changes
        contacts=[contact],
        every=5,
    )
    mass = model.mass(lumped=True)[::2]
    speed, place = run.v[:, ::2] @ mass / mass.sum(), run.u[:, ::2] @ mass / mass.sum()
    assert np.isclose(place[-1], 4.247367, rtol=1e-3) and abs(speed[-1]) < 0.02
    assert np.isclose(run.time[np.flatnonzero(speed < 0.02)[0]], 1.698947, rtol=1e-2)
    assert np.isclose(run.energies["friction"][-1], 12.5 * mass.sum(), rtol=2e-3)
    assert np.abs(run.energies["drift"]).max() < (1e-12 if kind is ir.NodalKinematic else 2e-3)


@pytest.mark.parametrize("kind", [ir.NodalPenalty, ir.NodalKinematic])
def test_disc_thrown_without_spin_comes_to_roll(kind):
    """G-3: a disc of finite strain on a floor with friction 0.3 rolls with 2/3 of its speed from v0 / (3 mu g) on."""

    def round_off(x):
        a = 2 * x - 1
        return np.abs(a).max() * a / max(np.linalg.norm(a), 1e-300) + [0, 1]

    points, cells = box("quadrilateral", (10, 10), mapping=round_off)
    law = ir.Material(2e4, 0.2, 1.0, "plane_strain", "st_venant_kirchhoff")
    model = ir.Model(points, cells, "quadrilateral", law)
    contact = kind(boundary(cells, "quadrilateral"), ir.RigidPlane([0, 0], [0, 1.0]), friction=0.3)
    dt = 0.5 * model.stable_step()
    run = model.run_explicit(
        dt,
        int(0.95 / dt),
        v0=np.tile([5.0, 0.0], len(points)),
        loads=model.body_force([0, -9.81]),
        contacts=[contact],
        every=10,
    )
    mass = model.mass(lumped=True)[::2]
    speed = run.v[:, ::2] @ mass / mass.sum()
    sliding = (run.time > 0.05) & (run.time < 0.5)
    # A polygon of 40 edges: it sinks in by its sagitta and rolls in small jumps.
    assert np.allclose(speed[sliding], 5 - 0.3 * 9.81 * run.time[sliding], rtol=0, atol=0.15)
    assert np.isclose(speed[run.time > 0.65].mean(), 10 / 3, rtol=2e-2)
    assert np.abs(run.energies["drift"]).max() < (1e-12 if kind is ir.NodalKinematic else 2e-3)


def collision(
    cell,
    law="st_venant_kirchhoff",
    degree=1,
    geometry_degree=1,
    gap=0.01,
    density=2.0,
    inner=False,
    shift=0.3,
    spin=0.0,
    speed=1.0,
):
    """Two free blocks that meet obliquely, the upper one turning, the lower one half as fast the other way: model,
    slave, master, v0. inner: no slave node leaves the master."""
    d = 2 if cell in ("triangle", "quadrilateral") else 3
    pair = blocks(cell, degree, geometry_degree, gap=gap, shift=shift, law=law)
    law = ir.Material(1e3, 0.3, density, "plane_strain" if d == 2 else "3d", law=law)
    points, cells = np.vstack([pair.lower[0], pair.upper[0]]), np.vstack([pair.lower[1], pair.upper[1] + pair.split])
    if inner:
        points[pair.split :, :-1] = 0.5 * points[pair.split :, :-1] + [0.05, 0.25][: d - 1]
    model = ir.Model(points, cells, cell, law, degree=degree, geometry_degree=geometry_degree)
    upper = np.unique(model.field_cells[len(pair.lower[1]) :])
    v = np.zeros_like(model.field_points)
    v[upper, -1], v[upper, 0] = -2.0, speed
    part = np.full((len(v), 1), -0.5 * spin)
    part[upper] = spin
    arm = model.field_points - 0.5
    if d == 2:
        v += part * np.stack([-arm[:, 1], arm[:, 0]], 1)
    else:
        v += part * np.cross([0.3, -1.0, 0.5], arm)
    return model, pair.slave, pair.master, v.reshape(-1)


def spin_of(model, run):
    """Angular momentum sum x_n x M v_(n+1/2) of every state."""
    d = model.points.shape[1]
    p = (model.mass(lumped=True) * run.v_half).reshape(len(run.time), -1, d)
    x = model.field_points + run.u.reshape(p.shape)
    if d == 2:
        return (
            np.sum(x[..., 0] * p[..., 1] - x[..., 1] * p[..., 0], 1)[:, None],
            p.sum(1),
            np.abs(p).sum(2).sum(1).max(),
        )
    return np.cross(x, p).sum(1), p.sum(1), np.abs(p).sum(2).sum(1).max()


@pytest.mark.parametrize("cell", ["quadrilateral", pytest.param("tetrahedron", marks=pytest.mark.slow)])
def test_drift_falls_with_step_and_penetration(cell):
    """Springs of a given penalty: what closing and opening between two steps takes is of second order in the step, 16
    times less with a fourth of it, and is not drift, of which there is less. With friction, slip counts the turning of
    the normal times the gap as well: friction, penetration and turning multiplied."""
    model, slave, master, v0 = collision(cell, inner=True)

    longest = model.stable_step(contacts=[ir.NodalPenalty(slave, master, penalty=1e5)])

    def drift(factor, chi, friction):
        contact = ir.NodalPenalty(slave, master, friction=friction, penalty=chi)
        dt = factor * longest
        run = model.run_explicit(dt, int(0.13 / dt), v0=v0, contacts=[contact], every=4)
        assert friction == 0 or run.energies["friction"][-1] > 0.02 * run.energies["kinetic"][0]
        return np.abs(run.energies["drift"]).max(), run.energies["impact"][-1] / run.energies["kinetic"][0]

    coarse, fine = drift(0.4, 5e3, 0.0), drift(0.1, 5e3, 0.0)
    assert 0 < coarse[1] < 1e-3 and 0 < fine[1] < coarse[1] / 10
    assert coarse[0] < 0.1 * coarse[1] and fine[0] < 0.1 * coarse[1]
    soft, hard = drift(0.1, 5e3, 0.4)[0], drift(0.02, 1e5, 0.4)[0]
    assert soft < 4e-3 and hard < 1e-3 and hard < 0.8 * soft
