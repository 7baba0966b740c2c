# SPDX-License-Identifier: MIT
"""Rigid bodies in implicit steps, and rotations in statics and as prescribed. See on_ranks.py."""

import functools

import numpy as np
from dolfinx import fem
from mpi4py import MPI
from rigid_body_checks import ball, block, groove, pressed, round_body, thrown
from shared_folder import shared_folder

import dolfinx_impact as di
from dolfinx_impact import interface

COMM = MPI.COMM_WORLD


def implicit(
    comm, dim, master, friction=0.3, bcs=False, cells=None, law=None, penalty={}, method=di.Penalty, **options
):  # fmt: skip
    """The implicit problem of rigid_body_checks.thrown."""
    V, tags = block(comm, dim, cells)
    material = di.NeoHookean(100.0, 0.3, 1.0, "plane_strain" if dim == 2 else "3d")
    pair = di.ContactPair(tags, 1, master, friction=0.0 if law else friction)
    held = [fem.dirichletbc(np.zeros(dim), fem.locate_dofs_topological(V, dim - 1, tags.find(2)), V)] if bcs else []
    contact = di.Lagrange(pair) if method is di.Lagrange else di.Penalty(pair, law=law, **penalty)
    return di.NewmarkProblem(fem.Function(V), material, bcs=held, contact=[contact], **options)


def momenta(problem, body):
    """Momentum, and angular momentum about the origin, of block and body together."""
    dim = problem.space.mesh.geometry.dim
    owned = problem.num_owned
    x = problem.space.tabulate_dof_coordinates()[: owned // dim].copy()
    x[:, :dim] += problem.u.x.array[:owned].reshape(-1, dim)
    p = np.zeros_like(x)
    p[:, :dim] = problem.inertia.times(problem.velocity.x.array[:owned].copy()).reshape(-1, dim)
    here = np.concatenate([p.sum(axis=0), np.cross(x, p).sum(axis=0)])
    there = problem.space.mesh.comm.allreduce(here, MPI.SUM)
    return there + np.concatenate([body.momentum, np.cross(body.position, body.momentum) + body.angular_momentum])


def check_a_free_block_and_a_ball_in_implicit_steps():
    """Momentum stays to the tolerance of the solves, angular momentum and energy nearly; the ball moves as in explicit
    steps."""
    differences = {}
    for dim, dt, cells in ((2, 0.004, 8), (3, 0.01, 2), *([(3, 0.01, 4)] if COMM.size == 1 else [])):
        body, other = ball(dim), ball(dim)
        problem = implicit(COMM, dim, body, cells=cells, penalty={"penalty": 300.0})
        before = momenta(problem, body)
        problem.advance(0.2, dt=dt, progress=False)
        assert problem.contact[0].force[dim - 1] < -0.1 or body.velocity[dim - 1] > -0.3, dim
        size = np.abs(before).max()
        # RigidEquilibrium::tolerance of the contact force in each of the steps.
        np.testing.assert_allclose(momenta(problem, body)[:3], before[:3], rtol=0, atol=1e-6 * size)
        np.testing.assert_allclose(momenta(problem, body)[3:], before[3:], rtol=0, atol=1e-3 * size)
        assert abs(problem.energy["drift"]) < 0.02, problem.energy
        explicit = thrown(COMM, dim, other, cells=cells, penalty=300.0)
        explicit.advance(0.2, progress=False)
        differences[dim, cells] = [
            np.abs(getattr(body, name) - getattr(other, name)).max() for name in ("position", "rotation", "spin")
        ]
        if dim == 2:
            np.testing.assert_allclose(body.position, other.position, rtol=0, atol=0.003)
            np.testing.assert_allclose(body.velocity, other.velocity, rtol=0, atol=0.06)
            np.testing.assert_allclose(body.spin, other.spin, rtol=0, atol=0.15)
            np.testing.assert_allclose(body.rotation, other.rotation, rtol=0, atol=0.02)
    if COMM.size == 1:
        # Contact at quadrature points here, at nodes there: the difference is that of the meshes. Of position, rotation
        # and spin it falls to 0.32, 0.13 and 0.16 with half the cells' size, and to 0.19, 0.11, 0.27 of that with half
        # of it again (5e-4 of the ball's way); half the step changes 4e-3 of it.
        coarse, fine = (np.array(differences[3, cells]) for cells in (2, 4))
        assert np.all(fine < 0.5 * coarse), (coarse, fine)


def check_multipliers_move_a_ball():
    """Momentum stays to the solves' tolerance, angular momentum to second order; friction turns the ball."""
    for dim, dt, cells in ((2, 0.01, 6), (3, 0.02, 2)):
        body = ball(dim)
        problem = implicit(COMM, dim, body, cells=cells, method=di.Lagrange)
        before, spin = momenta(problem, body), body.spin
        problem.advance(0.12, dt=dt, progress=False)
        assert body.velocity[dim - 1] > -0.35 and np.abs(body.spin - spin).max() > 0.01, (body.velocity, body.spin)
        np.testing.assert_allclose(momenta(problem, body)[:3], before[:3], rtol=0, atol=1e-7)
        np.testing.assert_allclose(momenta(problem, body)[3:], before[3:], rtol=0, atol=1e-3 * np.abs(before).max())
        # Multipliers that close gaps take energy (docs/implicit/contact.md): seen -0.0013 and -0.0006.
        assert abs(problem.energy["drift"]) < 0.01, problem.energy


def check_multipliers_move_a_ball_that_does_not_turn():
    """Without inertia a body only translates."""
    body = di.RigidBody(di.RigidCylinder([0.45, 1.701], 0.7), mass=0.5, velocity=[0.3, -0.5])
    problem = implicit(COMM, 2, body, friction=0.0, cells=4, method=di.Lagrange)
    before = momenta(problem, body)
    problem.advance(0.1, dt=0.01, progress=False)
    assert body.velocity[1] > -0.3 and np.all(body.rotation == np.eye(3))
    np.testing.assert_allclose(momenta(problem, body)[:3], before[:3], rtol=0, atol=1e-7)


def check_a_free_body_in_implicit_steps():
    """Without contact: a parabola, and a body that tumbles keeps its angular momentum, and nearly its energy."""
    shape = di.RigidSphere((0.5, 0.5, 6.0), 0.7)
    body = di.RigidBody(
        shape,
        mass=0.5,
        inertia=(0.1, 0.2, 0.25),
        force=(0.0, 0.0, -4.0),
        velocity=(1.0, 0.0, 0.0),
        spin=(0.1, 3.0, 0.2),
    )
    problem = implicit(COMM, 3, body, cells=2)
    angular, rotating = body.angular_momentum, 0.5 * body.angular_momentum @ body.spin
    problem.advance(1.0, dt=0.05, progress=False)
    np.testing.assert_allclose(body.position, (1.5, 0.5, 6.0 - 4.0), rtol=1e-12)
    np.testing.assert_allclose(body.velocity, (1.0, 0.0, -8.0), rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(body.angular_momentum, angular, rtol=1e-13)
    # Steps of 0.05 with a spin of 3: a turn of 0.15, its square is 0.02.
    assert abs(0.5 * body.angular_momentum @ body.spin / rotating - 1.0) < 0.01
    np.testing.assert_allclose(body.rotation @ body.rotation.T, np.eye(3), atol=1e-14)
    energy = problem.energy
    assert abs(energy["external"] - 4.0 * 4.0) < 1e-10 and abs(energy["kinetic"] - body.kinetic_energy) < 1e-14


def check_a_driven_body_is_an_obstacle():
    """All components fixed: a body that moves and turns is an obstacle with motion and angle, in implicit and explicit
    steps, with the same work; and friction sees the turning surface."""
    for dim in (2, 3):
        spin = -1.5 if dim == 2 else (0.3, -1.5, 0.0)
        velocity = np.array([0.05] + [0.0] * (dim - 2) + [-0.1])
        free = {"velocity": velocity, "spin": spin, "fixed": ("x", "y", "z", "rx", "ry", "rz"), "gap": 0.001}
        body = ball(dim, **free)
        shape = ball(dim, gap=0.001).surface
        turn = np.array([0.0, 0.0, spin]) if dim == 2 else np.array(spin)
        shape.motion = lambda t, v=np.pad(velocity, (0, 3 - dim)): t * v
        shape.angle = lambda t, turn=turn: t * turn
        multipliers = functools.partial(implicit, method=di.Lagrange)
        for kind, steps in ((implicit, {"dt": 0.005}), (multipliers, {"dt": 0.02}), (thrown, {})):
            cells = 8 if dim == 2 else 2
            one, other = kind(COMM, dim, body, bcs=True, cells=cells), kind(COMM, dim, shape, bcs=True, cells=cells)
            if kind is thrown:
                steps = {"dt": 0.5 * one.stable_step()}
            one.advance(0.1, progress=False, **steps)
            other.advance(0.1, progress=False, **steps)
            size = np.abs(other.contact[0].force).max()
            assert size > 0.1, (dim, kind)
            np.testing.assert_allclose(one.contact[0].force, other.contact[0].force, rtol=0, atol=1e-7 * size)
            # The surface moves to the left on top of the ball's lower side: it drags the block along.
            assert other.contact[0].force[0] < -0.2 * size or dim == 3, other.contact[0].force
            a, b = one.energy, other.energy
            moving = body.kinetic_energy
            np.testing.assert_allclose(a["kinetic"] - moving, b["kinetic"], rtol=0, atol=1e-6 * a["internal"])
            np.testing.assert_allclose(a["external"], b["external"], rtol=1e-5)
            if kind is thrown:
                assert abs(b["drift"]) < 0.01, (dim, b)
                continue
            # Friction's work is that of the traction at the end of each step: while the shear force grows evenly to F
            # under a slip velocity v, that is more than the mean by h F v/2, and of first order.
            slip = np.pad(velocity, (0, 3 - dim)) + np.cross(turn, -0.7 * np.eye(3)[dim - 1])
            along = other.contact[0].force[: dim - 1]
            excess = 0.5 * steps["dt"] * abs(along @ slip[: dim - 1])
            assert abs(b["total"] - excess) < 0.25 * excess, (dim, b, excess)


def check_implicit_checkpoints():
    """Written by all ranks, read by each alone and by all: the body is where it was, and goes on."""

    for method in (di.Penalty, di.Lagrange):
        _check_implicit_checkpoints(method)


def _check_implicit_checkpoints(method):
    def make(comm):
        body = ball(2)
        return implicit(comm, 2, body, bcs=True, cells=4, method=method), body

    whole, body = make(COMM)
    whole.advance(0.06, dt=0.01, progress=False)
    with shared_folder() as path:
        whole.save(path / "half.h5")
        COMM.barrier()
        whole.advance(0.1, dt=0.01, progress=False)
        for comm in (COMM, MPI.COMM_SELF):
            again, other = make(comm)
            again.restore(path / "half.h5")
            again.advance(0.1, dt=0.01, progress=False)
            close = dict(rtol=0, atol=0.0 if COMM.size == 1 else 1e-9)
            for name in ("position", "rotation", "velocity", "spin", "force", "torque", "angular_momentum"):
                np.testing.assert_allclose(getattr(other, name), getattr(body, name), err_msg=name, **close)
            for name in ("kinetic", "external", "internal"):
                np.testing.assert_allclose(again.energy[name], whole.energy[name], rtol=0, atol=1e-8, err_msg=name)


def check_a_law_in_implicit_steps():
    """A law of the interface with friction between a rigid ball and a block that is held."""
    body = ball(2)
    problem = implicit(COMM, 2, body, bcs=True, law=interface.linear_pressure(300.0, friction=0.3))
    problem.advance(0.1, dt=0.005, progress=False)
    assert problem.energy["friction"] > 0.0 and body.velocity[1] > -0.45 and body.spin[2] > -1.0


def check_torques_in_statics():
    """A disc that friction holds: force and torque find the place and the angle that displacement control has."""
    for method in (di.Penalty, di.Lagrange):
        _check_torques_in_statics(method)


def _check_torques_in_statics(method):
    body = di.RigidBody(round_body(2).surface, inertia=1.0, force=(0.0, -4.0), fixed="x")
    problem = pressed(COMM, 2, method, body, friction=0.5)
    path = []  # friction depends on it
    for torque in (0.0, 0.1, 0.2):
        body.external_torque = torque
        problem.solve()
        path.append((body.position - body.centre, np.arctan2(body.rotation[1, 0], body.rotation[0, 0])))
    # RigidEquilibrium::tolerance of the force; torques over the diagonal of the block.
    np.testing.assert_allclose(body.force[1], 4.0, rtol=0, atol=2e-7)
    np.testing.assert_allclose(body.torque, (0.0, 0.0, -0.2), rtol=0, atol=2e-7)
    assert path[-1][1] > 1e-4
    shape = round_body(2).surface
    shape.angle = 0.0
    other = pressed(COMM, 2, method, shape, friction=0.5)
    for shape.displacement, shape.angle in path:
        other.solve()
    np.testing.assert_allclose(other.contact[0].force, problem.contact[0].force, rtol=0, atol=1e-7)


def check_a_plate_tilts():
    """A rigid half-space on a block, pressed beside its middle: it tilts until force and torque balance, in two and
    three dimensions, and turning it by the same angle gives the same forces."""
    for dim, method in ((2, di.Penalty), (3, di.Penalty), (2, di.Lagrange), (3, di.Lagrange)):
        force = -2.0 * np.eye(3)[dim - 1]
        V, tags = block(COMM, dim, 4 if dim == 2 else 2)
        law = di.LinearElastic(100.0, 0.3, 1.0, "plane_strain" if dim == 2 else "3d")
        held = fem.dirichletbc(np.zeros(dim), fem.locate_dofs_topological(V, dim - 1, tags.find(2)), V)
        up = np.eye(dim)[dim - 1]
        centre = np.append(np.full(dim - 1, 0.55), 1.3)

        def problem(master, V=V, tags=tags, law=law, held=held, method=method):
            contact = method(di.ContactPair(tags, 1, master))
            return di.StaticProblem(fem.Function(V), law, bcs=[held], contact=[contact])

        fixed = ("x",) if dim == 2 else ("x", "y", "rz")
        body = di.RigidBody(di.RigidPlane(up, -up), inertia=1.0, centre=centre, force=force, fixed=fixed)
        one = problem(body)
        one.solve()
        np.testing.assert_allclose(body.force[dim - 1], 2.0, rtol=1e-6)
        np.testing.assert_allclose(body.torque, 0.0, atol=1e-6)
        tilt = body.rotation[dim - 1, 0]
        assert abs(tilt) > 1e-4, tilt
        plane = di.RigidPlane(up, -up)
        plane.pivot = centre
        plane.angle = (0.0, 0.0, 0.0)
        other = problem(plane)
        plane.displacement = body.position - body.centre
        turned = body.rotation
        angle = np.array([turned[2, 1] - turned[1, 2], turned[0, 2] - turned[2, 0], turned[1, 0] - turned[0, 1]]) / 2
        plane.angle = angle * np.arcsin(np.linalg.norm(angle)) / np.linalg.norm(angle)
        other.solve(steps=2)
        np.testing.assert_allclose(other.contact[0].force, one.contact[0].force, rtol=0, atol=1e-6)


def check_nothing_holds_a_rotation():
    """A disc without friction may spin: a sentence on all ranks names the component."""
    body = di.RigidBody(round_body(2).surface, inertia=1.0, force=(0.0, -4.0), torque=0.1, fixed="x")
    try:
        pressed(COMM, 2, di.Penalty, body).solve(cut_backs=0)
    except RuntimeError as e:
        assert "nothing holds a rigid body along rz" in str(e), e
    else:
        raise AssertionError("a torque without friction has found its equilibrium")


def check_a_disc_rests_in_a_groove():
    """A V groove in statics: both walls bear the weight over the root of two, along their normals; with a torque that
    friction bears, the torque is what their shear forces have, too."""
    V, tagged, held = groove()
    radius, weight = 0.6, 3.0
    shape = di.RigidCylinder((0.0, 1.0 + np.sqrt(2.0) * radius), radius)
    law = di.LinearElastic(500.0, 0.2, 1.0, "plane_strain")
    for friction, torque, method in (
        (0.0, 0.0, di.Penalty), (0.4, 0.3, di.Penalty), (0.0, 0.0, di.Lagrange), (0.4, 0.3, di.Lagrange)
    ):  # fmt: skip
        body = di.RigidBody(shape, force=(0.0, -weight), inertia=1.0 if torque else None)
        pairs = [di.ContactPair(tagged, k, body, friction=friction) for k in (1, 2)]
        problem = di.StaticProblem(fem.Function(V), law, bcs=[held], contact=[method(p) for p in pairs])
        problem.solve()
        if torque:  # friction holds what is pressed
            body.external_torque = torque
            problem.solve(steps=2)
        left, right = (c.force for c in problem.contact)
        np.testing.assert_allclose(left + right, (0.0, -weight), rtol=0, atol=1e-6)
        # RigidEquilibrium::tolerance, over the diagonal of the block.
        np.testing.assert_allclose(body.torque, (0.0, 0.0, -torque), rtol=0, atol=1e-6)
        if not torque:
            np.testing.assert_allclose(left[1], right[1], rtol=1e-6)
            # Points and nodes lie beside the foot of the disc's radius, as in check_a_disc_in_a_groove.
            np.testing.assert_allclose(np.abs(left), 0.5 * weight, rtol=0.1 if method is di.Penalty else 0.3)
