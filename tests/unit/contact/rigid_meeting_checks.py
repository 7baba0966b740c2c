# SPDX-License-Identifier: MIT
"""Rigid bodies that meet each other and rigid obstacles in explicit problems. See on_ranks.py."""

import numpy as np
from dolfinx import fem, mesh
from mpi4py import MPI
from rigid_body_checks import block
from shared_folder import shared_folder

import dolfinx_impact as di

COMM = MPI.COMM_WORLD


def meeting(comm, dim, *bodies):
    """A problem with a block far below, which the bodies would touch; it is stiff, as springs follow its step."""
    V, tags = block(comm, dim, 2)
    law = di.LinearElastic(1e4, 0.3, 1.0, "plane_strain" if dim == 2 else "3d")
    return di.ExplicitProblem(fem.Function(V), law, contact=[di.Penalty(di.ContactPair(tags, 1, b)) for b in bodies])


def spheres(friction=0.0, **given):
    """Two balls of different masses on their way to each other, not quite centrally; the first meets the second."""
    other = di.RigidBody(di.RigidSphere((1.6, 0.1, 9.0), 0.7), mass=1.0, inertia=0.2, velocity=(-0.2, 0.0, 0.1))
    first = di.RigidBody(
        di.RigidSphere((0.0, 0.0, 9.0), 0.8), mass=0.5, inertia=0.13, velocity=(0.5, 0.0, 0.0), spin=(0.0, 0.0, 0.4),
        meets=other, friction=friction, **given,
    )  # fmt: skip
    return first, other


def momenta(bodies):
    """Momentum, and angular momentum about the origin."""
    return np.concatenate([
        sum(b.momentum for b in bodies), sum(np.cross(b.position, b.momentum) + b.angular_momentum for b in bodies)
    ])  # fmt: skip


def check_two_balls_collide():
    """Momentum and angular momentum to round-off, energy; frictionless the velocities along the normal are those of the
    elastic impact."""
    for friction in (0.0, 0.3):
        bodies = spheres(friction)
        problem = meeting(COMM, 3, bodies[0])
        before, kinetic = momenta(bodies), problem.energy["kinetic"]
        velocities = [b.velocity for b in bodies]
        problem.advance(1.0, dt=5e-4, progress=False)
        # Some thousand steps.
        np.testing.assert_allclose(momenta(bodies), before, rtol=0, atol=1e-11)
        assert np.all(bodies[0].meeting_gaps > 0.0) and np.all(bodies[0].meeting_forces == 0.0)
        # Of second order in the step, see check_an_impact_keeps_its_energy.
        assert abs(problem.energy["drift"]) < 1e-3, problem.energy
        lost = kinetic - problem.energy["kinetic"]
        assert abs(lost - problem.energy["friction"]) < 1e-3 * kinetic
        if friction:
            assert lost > 1e-4 and bodies[1].spin[2] != 0.0
            continue
        impulse = 0.5 * (bodies[0].velocity - velocities[0])
        n = -impulse / np.linalg.norm(impulse)
        closing = (velocities[0] - velocities[1]) @ n
        np.testing.assert_allclose((bodies[1].velocity - bodies[0].velocity) @ n, closing, rtol=1e-3)
        np.testing.assert_allclose(bodies[1].spin, 0.0, atol=1e-12)


def check_an_impact_keeps_its_energy():
    """A ball on a rigid wall comes back with its energy in the problem's own steps, wherever in a step the impact
    begins; in shorter ones up to what a step's way through the wall takes and gives back."""
    part = np.sin(np.pi / 14.0) ** 2  # docs/rigid_bodies.md
    wall, speed = di.RigidPlane((0, 0, 5), (0, 0, 1)), 0.5
    body = di.RigidBody(di.RigidSphere((0, 0, 6), 0.5), mass=1.0, velocity=(0, 0, -speed), meets=wall)
    natural = 0.9 * meeting(COMM, 3, body).stable_step()
    for fraction, most in ((1.0, 1e-10), (0.9, 1.0)):
        changes = []
        for offset in (0.1, 0.4, 0.9):
            dt = fraction * natural
            gap = (1.0 + offset) * speed * dt
            body = di.RigidBody(
                di.RigidSphere((0, 0, 5.5 + gap), 0.5), mass=1.0, velocity=(0, 0, -speed), meets=wall
            )  # fmt: skip
            problem = meeting(COMM, 3, body)
            problem.advance((10.0 / fraction + 3.0) * dt, dt=dt, progress=False)
            assert body.velocity[2] > 0.0 and np.all(body.meeting_forces == 0.0)
            changes.append((body.velocity[2] / speed) ** 2 - 1.0)
        # The first place beyond the wall, d deep, takes k d (v h - d)/2, at most k (v h)^2/8, which is part fraction^2
        # of m v^2/2; the last one gives as much.
        assert np.abs(changes).max() <= most * part * fraction**2, changes


def brick(velocity, friction, height=0.0):
    """A rigid brick from the tagged surface of a mesh, on a rigid floor."""
    box = mesh.create_box(COMM, [[0, 0, 5], [1, 0.6, 5.3]], [2, 2, 1], mesh.CellType.hexahedron)
    rim = mesh.locate_entities_boundary(box, 2, lambda x: np.full(x.shape[1], True))
    surface = di.RigidSurface.from_mesh(box, mesh.meshtags(box, 2, rim, np.full(len(rim), 7, dtype=np.int32)), 7)
    floor = di.RigidPlane((0, 0, 5 - height), (0, 0, 1))
    mass, weight = 2.0, 3.0
    inertia = mass / 12.0 * np.array([0.6**2 + 0.3**2, 1 + 0.3**2, 1 + 0.6**2])
    return di.RigidBody(
        surface, mass=mass, inertia=inertia, centre=(0.5, 0.3, 5.15), velocity=velocity, force=(0.0, 0.0, -weight),
        meets=floor, friction=friction,
    )  # fmt: skip


def check_a_brick_slides():
    """Facets of a mesh as the slave: a brick on a floor is slowed down by friction alone, and stops."""
    body = brick((0.4, 0.0, 0.0), 0.2)
    problem = meeting(COMM, 3, body)
    problem.advance(0.5, dt=5e-4, progress=False)
    # Friction coefficient times weight over mass; it hops by what the springs give way.
    np.testing.assert_allclose(body.velocity[0], 0.4 - 0.2 * 1.5 * 0.5, rtol=0.03)
    heights = []
    problem.advance(2.5, dt=5e-4, progress=False, callback=lambda p: heights.append(body.position[2] - 5.15))
    np.testing.assert_allclose(body.position[0], 0.5 + 0.4**2 / (2.0 * 0.3), rtol=0.02)
    assert abs(body.velocity[0]) < 0.02
    # It hops between its first place and twice what its weight presses the springs of its lower side by.
    points, areas = body.surface.vertices()
    mobility = 1.0 / 2.0 + (0.5**2 + 0.3**2 + 0.15**2) / np.linalg.eigvalsh(body.inertia)[0]
    stiffness = 4.0 * np.sin(np.pi / 14.0) ** 2 / ((0.9 * problem.stable_step()) ** 2 * mobility)
    sag = 3.0 / (stiffness * areas[np.isclose(points[:, 2], 5.0)].sum() / areas.sum())
    np.testing.assert_allclose([min(heights), max(heights)], [-2.0 * sag, 0.0], rtol=0, atol=0.02 * sag)
    np.testing.assert_allclose(body.rotation, np.eye(3), atol=0.01)
    assert abs(problem.energy["drift"]) < 0.02, problem.energy


def check_a_ball_in_a_groove():
    """A ball bounces in a V groove of two rigid planes: alike on both, nothing moves it to the side or turns it."""
    walls = [di.RigidPlane((0, 0, 5), (s, 0.0, 1.0)) for s in (-1, 1)]
    center = (0.0, 0.0, 5.0 + np.sqrt(2.0) * 0.5 + 0.01)
    body = di.RigidBody(di.RigidSphere(center, 0.5), mass=1.0, inertia=0.1, force=(0, 0, -2.0), meets=walls)
    problem = meeting(COMM, 3, body)
    lowest, impulse = [], []

    def look(p):
        left, right = body.meeting_forces
        assert abs(left[0] + right[0]) <= 1e-9 * (1.0 + abs(left[0]))
        lowest.append(body.position[2])
        impulse.append(left[2] + right[2])

    problem.advance(0.18, dt=5e-4, progress=False, callback=look)
    assert min(lowest) < 5.0 + np.sqrt(2.0) * 0.5 and max(impulse) > 2.0 and body.velocity[2] > 0.05
    assert abs(body.position[0]) < 1e-10 and np.all(body.spin == 0.0)
    # It fell by 0.01 without contact: it comes back as high.
    assert abs(problem.energy["drift"]) < 1e-3


def check_checkpoints_of_meetings():
    """In contact with friction: what the springs remember is in the file."""
    whole = spheres(0.3)
    problem = meeting(COMM, 3, whole[0])
    while whole[0].meeting_forces.max() <= 0.0:
        problem.advance(problem.time + 0.005, dt=0.001, progress=False)
    with shared_folder() as path:
        problem.save(path / "half.h5")
        COMM.barrier()
        end = problem.time + 0.3
        problem.advance(end, dt=0.001, progress=False)
        parts = spheres(0.3)
        again = meeting(COMM, 3, parts[0])
        again.restore(path / "half.h5")
        again.advance(end, dt=0.001, progress=False)
        for one, other in zip(whole, parts):
            for name in ("position", "velocity", "spin", "rotation"):
                np.testing.assert_allclose(getattr(other, name), getattr(one, name), rtol=0, atol=1e-12)
        smoother = meeting(COMM, 3, spheres(0.2)[0])
        try:
            smoother.restore(path / "half.h5")
        except ValueError as e:
            assert "another problem" in str(e), e
        else:
            raise AssertionError("a checkpoint of bodies with other friction was taken")
