# SPDX-License-Identifier: MIT
"""Rigid bodies of the hand-written solver alone: rotations, free bodies, and how it says that there is no root."""

import numpy as np
import pytest
from impact_reference import NewmarkScheme, RigidBody, RigidPlane, RigidSphere, rigid_body, rigid_meeting, rotation


def sphere(**given):
    centre = np.array([0.3, -0.2, 5.0])
    return RigidBody(RigidSphere(centre, 0.5, pivot=centre), **given)


def test_rotations():
    angle = np.array([0.3, -1.1, 0.7])
    R = rotation.matrix_of(angle)
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(rotation.angle_of(R), angle, rtol=1e-14)
    np.testing.assert_allclose(R @ angle, angle, rtol=1e-14)
    assert np.all(rotation.matrix_of(np.zeros(3)) == np.eye(3)) and np.all(rotation.angle_of(np.eye(3)) == 0.0)
    np.testing.assert_allclose(rotation.cross_matrix(angle) @ [1.0, 2.0, 3.0], np.cross(angle, [1.0, 2.0, 3.0]))


def test_a_free_body_keeps_its_angular_momentum_and_nearly_its_energy():
    body = sphere(inertia=np.diag([0.1, 0.2, 0.25]), mass=2.0)
    L, dt, R = body.inertia @ [0.1, 3.0, 0.2], 0.01, np.eye(3)
    energies = []
    for _ in range(100):
        R = body.turned(R, L, dt)
        energies.append(L @ body.spin_of(L, R) / 2.0)
    # The square of a turn of 0.03 in a step.
    assert np.ptp(energies) < 1e-3 * energies[0]
    half = [np.eye(3)]
    for _ in range(200):
        half.append(body.turned(half[-1], L, dt / 2))
    quarter = [np.eye(3)]
    for _ in range(400):
        quarter.append(body.turned(quarter[-1], L, dt / 4))
    coarse, fine = np.abs(R - half[-1]).max(), np.abs(half[-1] - quarter[-1]).max()
    assert 3.5 < coarse / fine < 4.5, "second order"


def test_a_ball_turns_exactly_and_axes_that_are_no_axes_of_inertia_are_refused():
    ball = sphere(inertia=0.4 * np.eye(3))
    L = np.array([0.2, 0.1, -0.3])
    np.testing.assert_allclose(ball.turned(np.eye(3), L, 2.0), rotation.matrix_of(5.0 * L), atol=1e-15)
    skew = sphere(inertia=np.array([[1.0, 0.0, 0.3], [0.0, 1.0, 0.0], [0.3, 0.0, 1.0]]), free=(0, 1, 5))
    with pytest.raises(ValueError, match="one axis of inertia"):
        skew.turned(np.eye(3), L, 1.0)
    with pytest.raises(ValueError, match="one axis of inertia"):
        sphere(free=(3, 4)).turned(np.eye(3), L, 1.0)
    still = sphere(free=(0,))
    assert np.all(still.turned(np.eye(3), L, 1.0) == np.eye(3))


def test_a_body_in_implicit_steps_falls_on_a_parabola():
    """Constant loads without contact: exact, and nothing is lacking."""
    body = sphere(mass=2.0, velocity=(0.1, 0.0, 0.0), force=(0.0, 0.0, -4.0), inertia=0.4 * np.eye(3))
    moving = rigid_body.MovingBody(body, 3, NewmarkScheme())
    state, h = moving.start(np.zeros(6)), 0.1
    for _ in range(5):
        q = h * state.rate + h**2 / 2.0 * state.change
        state = moving.end(state, h, q, np.zeros(6))
        lacking, size = moving.lacks(state)
        assert np.abs(lacking).max() < 1e-12 * size
    np.testing.assert_allclose(state.displacement, (0.05, 0.0, -0.25), rtol=0, atol=1e-14)
    assert state.kinetic == pytest.approx(1.01) and state.work == pytest.approx(1.0)


def test_meetings_conserve_momentum_and_energy():
    """A ball on a free plate with friction: what both have together stays."""
    plate = RigidBody(
        RigidPlane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), pivot=np.zeros(3)), mass=3.0, inertia=np.eye(3)
    )  # fmt: skip
    centre = np.array([0.2, 0.0, 0.501])
    ball = RigidBody(
        RigidSphere(centre, 0.5, pivot=centre), 1.0, 0.1 * np.eye(3), velocity=(0.3, 0.0, -1.0), spin=(0.0, 1.0, 0.0)
    )  # fmt: skip
    bodies = [rigid_meeting.MeetingBody(b) for b in (ball, plate)]
    meeting = rigid_meeting.Meeting(
        bodies[0], centre[None], np.ones(1), plate.obstacle, bodies[1], radius=0.5, friction=0.2
    )  # fmt: skip
    meeting.stiffen(0.01, 0.05)
    run = rigid_meeting.run(bodies, [meeting], 5e-4, 300)
    p = run.velocity[:, 0] + 3.0 * run.velocity[:, 1]
    L = np.cross(run.position[:, 0], run.velocity[:, 0]) + 0.1 * run.spin[:, 0] + run.spin[:, 1]
    L += 3.0 * np.cross(run.position[:, 1], run.velocity[:, 1])
    np.testing.assert_allclose(p, p[:1] + 0 * p, atol=1e-13)
    # Velocities of the time level at its places: of second order in the step.
    np.testing.assert_allclose(L, L[:1] + 0 * L, atol=1e-6)
    total = run.kinetic + run.stored + run.dissipated
    assert np.ptp(total) < 1e-4 * total[0] and run.dissipated[-1] > 1e-3 and run.stored.max() > 0.1


def test_a_system_without_a_root_is_named():
    with pytest.raises(RuntimeError, match="no equilibrium"):
        rigid_body.find_root(lambda q: (1.0 + q**2, 1.0), np.array([0.3]), 1e-6, 1e-12)
