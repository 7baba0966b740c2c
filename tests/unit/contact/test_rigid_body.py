# SPDX-License-Identifier: MIT
"""Rigid bodies: arguments, restart, motion under loads; on ranks: rigid_body_checks.py."""

import numpy as np
import pytest
import rigid_body_checks
import rigid_meeting_checks
import rigid_motion_checks
from dolfinx import fem, mesh
from mpi4py import MPI
from on_ranks import rank_tests
from rigid_body_checks import ball, block, pressed, round_body, thrown

import dolfinx_impact as di
from dolfinx_impact.contact.rigid_body import StaticBody

test_one_rank, test_several_ranks = rank_tests(rigid_body_checks, ranks=(2, 3))
test_meetings_on_one_rank, test_meetings_on_two_ranks = rank_tests(rigid_meeting_checks, ranks=(2,))
test_motion_on_one_rank, test_motion_on_two_ranks = rank_tests(rigid_motion_checks, ranks=(2,))

SELF = MPI.COMM_SELF
PLANE = di.RigidPlane((0, 0, 0), (0, 0, 1))


@pytest.mark.parametrize("dim", (2, 3))
def test_a_run_goes_on_from_its_checkpoint(tmp_path, dim):
    """Bit for bit, in contact, with spin; the ball's motion too."""

    def make():
        body = ball(dim, force=lambda t: np.append(np.zeros(dim - 1), [-np.cos(t)] + [0.0] * (3 - dim)))
        return thrown(SELF, dim, body), body

    whole, body = make()
    dt = 0.5 * whole.stable_step()
    whole.advance(30 * dt, dt=dt, progress=False)
    assert whole.contact[0].area > 0.0
    whole.save(tmp_path / "half.h5")
    whole.advance(80 * dt, dt=dt, progress=False)
    again, other = make()
    again.restore(tmp_path / "half.h5")
    again.advance(80 * dt, dt=dt, progress=False)
    np.testing.assert_array_equal(again.u.x.array, whole.u.x.array)
    for name in ("position", "rotation", "velocity", "spin", "force", "torque", "angular_momentum"):
        np.testing.assert_array_equal(getattr(other, name), getattr(body, name), err_msg=name)
    assert again.energy == pytest.approx(whole.energy, rel=1e-12, abs=1e-15)
    heavier = thrown(SELF, dim, ball(dim, mass=0.6))
    with pytest.raises(ValueError, match="another problem"):
        heavier.restore(tmp_path / "half.h5")


def test_a_static_body_goes_on_from_its_checkpoint(tmp_path):
    """Place and force that were reached are in the file: two load steps as without it."""

    def make():
        body = round_body(2, force=(0.0, -4.0))
        return pressed(SELF, 2, di.Lagrange, body), body

    whole, body = make()
    assert isinstance(body._body, StaticBody) and np.all(body.force == 0.0)
    whole.solve()
    assert np.all(body.rotation == np.eye(3)) and np.all(body.velocity == 0.0) and body.kinetic_energy == 0.0
    # The forces' resultant passes through the centre of a disc without friction.
    np.testing.assert_allclose(body.torque, 0.0, atol=1e-6)
    whole.save(tmp_path / "half.h5")
    body.external_force = (0.0, -6.0)
    whole.solve(steps=2)
    again, other = make()
    again.restore(tmp_path / "half.h5")
    np.testing.assert_allclose(other.force, (other.force[0], 4.0, 0.0), rtol=2e-8)
    other.external_force = (0.0, -6.0)
    again.solve(steps=2)
    np.testing.assert_allclose(other.position, body.position, rtol=1e-9)
    np.testing.assert_allclose(other.force, body.force, rtol=1e-7)


def test_free_flight():
    """Without contact: a parabola, and a spin that stays."""
    body = ball(3, gap=5.0, force=(0.0, 0.0, -4.0), velocity=(1.0, 0.0, 0.0), spin=(0.0, 2.0, 0.0))
    problem = thrown(SELF, 3, body, cells=1)
    start = body.position
    problem.advance(0.5, progress=False)
    np.testing.assert_allclose(body.position - start, (0.5, 0.0, -0.5 * 8.0 * 0.25), rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(body.velocity, (1.0, 0.0, -4.0), rtol=1e-12)
    np.testing.assert_allclose(body.spin, (0.0, 2.0, 0.0), rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(body.momentum, 0.5 * body.velocity)
    # A turn by the angle 1 about y.
    np.testing.assert_allclose(body.rotation[0], (np.cos(1), 0, np.sin(1)), atol=1e-12)
    assert body.kinetic_energy == pytest.approx(0.5 * 0.5 * 17.0 + 0.5 * body.inertia[1, 1] * 4.0)
    # The history has the energies before each step; the work of the weight is what the ball has gained.
    energy = problem.energy
    assert energy["external"] == pytest.approx(4.0 * 1.0, rel=1e-12)
    assert abs(energy["drift"]) < 1e-12 and np.all(body.force == 0.0) and np.all(body.torque == 0.0)


def test_sliding_becomes_rolling():
    """A disc thrown without spin on a soft strip rolls from t = v0/(3 mu g) on, with 2/3 of its velocity."""
    v0, mu, g, radius, mass = 0.5, 0.3, 9.81, 0.05, 0.5
    domain = mesh.create_rectangle(SELF, [[0.0, -0.005], [0.06, 0.0]], [60, 5], mesh.CellType.quadrilateral)
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    top = mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[1], 0.0))
    tags = mesh.meshtags(domain, 1, np.sort(top), np.full(len(top), 1, dtype=np.int32))
    bottom = mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[1], -0.005))
    held = fem.dirichletbc(np.zeros(2), fem.locate_dofs_topological(V, 1, bottom), V)
    disc = di.RigidBody(
        di.RigidCylinder((0.01, radius), radius), mass=mass, inertia=0.5 * mass * radius**2, velocity=(v0, 0.0),
        force=(0.0, -mass * g),
    )  # fmt: skip
    strip = di.LinearElastic(1e5, 0.3, 1000.0, "plane_strain")
    problem = di.ExplicitProblem(
        fem.Function(V), strip, bcs=[held], contact=[di.Penalty(di.ContactPair(tags, 1, disc, friction=mu))],
        damping=di.Rayleigh(200.0, 0.0),
    )  # fmt: skip
    problem.advance(0.9 * v0 / (3 * mu * g), progress=False)
    assert disc.velocity[0] > 1.01 * radius * -disc.spin[2], "it slides still"
    problem.advance(1.3 * v0 / (3 * mu * g), progress=False)
    # G-3 of the benchmarks: 1 %; the strip gives way and takes as much.
    assert disc.velocity[0] == pytest.approx(2 * v0 / 3, rel=0.02)
    assert radius * -disc.spin[2] == pytest.approx(disc.velocity[0], rel=0.02)


def test_an_axisymmetric_body_moves_along_its_axis():
    """A ball on the axis of a disc: it is turned back, and has neither moved aside nor turned."""
    domain = mesh.create_rectangle(SELF, [[0.0, 0.0], [1.0, 1.0]], [8, 8], mesh.CellType.quadrilateral)
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    top = mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[1], 1.0))
    tags = mesh.meshtags(domain, 1, np.sort(top), np.full(len(top), 1, dtype=np.int32))
    bottom = mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[1], 0.0))
    held = fem.dirichletbc(np.zeros(2), fem.locate_dofs_topological(V, 1, bottom), V)
    law = di.LinearElastic(100.0, 0.3, 1.0, "axisymmetric")

    def problem(body):
        return di.ExplicitProblem(fem.Function(V), law, bcs=[held], contact=[di.Penalty(di.ContactPair(tags, 1, body))])

    shape = di.RigidSphere((0.0, 1.701), 0.7)
    body = di.RigidBody(shape, mass=3.0, velocity=(0.0, -0.3))
    run = problem(body)
    run.advance(1.2, progress=False)
    assert body.velocity[1] > 0.2 and body.position[0] == 0.0 and np.all(body.rotation == np.eye(3))
    assert abs(run.energy["drift"]) < 0.01
    with pytest.raises(ValueError, match="moves along its axis"):
        problem(di.RigidBody(shape, mass=3.0, velocity=(0.1, -0.3)))


def test_the_body_gives_way_in_the_stable_step():
    """A given penalty: the bound has the body's mass; without one the springs give way with it, not the step."""
    heavy, light = (thrown(SELF, 2, ball(2, mass=m), penalty=50.0).stable_step() for m in (1e6, 1e-4))
    assert light < 0.5 * heavy
    heavy, light = (thrown(SELF, 2, ball(2, mass=m)).stable_step() for m in (1e6, 1e-4))
    assert light == heavy
    with pytest.raises(ValueError, match="use method 'element'"):
        thrown(SELF, 2, ball(2)).stable_step("eigenvalue")


def test_a_failed_run_takes_the_body_back():
    body = ball(2)
    problem = thrown(SELF, 2, body)
    problem.advance(0.01, progress=False)
    dt = 40.0 * problem.stable_step()
    with pytest.warns(UserWarning, match="beyond the stable step"), pytest.raises(RuntimeError):
        problem.advance(200.0 * dt, dt=dt, unsafe=True, progress=False)
    assert np.all(np.isfinite(body.position)) and abs(body.position[0] - 0.45) < 0.3 * problem.time + 1e-3
    assert np.all(np.isfinite(body.velocity)) and np.linalg.norm(body.velocity) < 1.0


def test_a_body_that_is_lost_is_named():
    """One that meets the master of a pair, which does not meet it, is in no problem."""
    V, tags = block(SELF, 3, 1)
    low = di.RigidBody(di.RigidSphere((0.5, 0.5, 2.0), 0.3), mass=1.0)
    top = di.RigidBody(di.RigidSphere((0.5, 0.5, 3.0), 0.3), mass=1.0, meets=low)
    assert low.met_by() == [top] and top.met_by() == []
    law = di.LinearElastic(100.0, 0.3, 1.0)
    with pytest.warns(UserWarning, match="are not in it: RigidBody"):
        di.ExplicitProblem(fem.Function(V), law, contact=[di.Penalty(di.ContactPair(tags, 1, low))])


def test_what_is_refused():
    V, tags = block(SELF, 2)
    law = di.LinearElastic(100.0, 0.3, 1.0, "plane_strain")
    pair = di.ContactPair(tags, 1, ball(2))
    with pytest.raises(ValueError, match="does not move a RigidBody"):
        di.ExplicitProblem(fem.Function(V), law, contact=[di.Kinematic(pair)])
    for body, text in (
        (di.RigidBody(di.RigidCylinder((0.5, 2.0), 0.5)), "needs a mass"),
        (di.RigidBody(di.RigidCylinder((0.5, 2.0), 0.5), fixed=("x",)), "needs a mass"),
    ):
        with pytest.raises(ValueError, match=text):
            di.ExplicitProblem(fem.Function(V), law, contact=[di.Penalty(di.ContactPair(tags, 1, body))])
    for body, text in (
        (di.RigidBody(di.RigidCylinder((0.5, 2.0), 0.5), torque=lambda t: (0, 0, t)), "torque .* function of time"),
        (di.RigidBody(di.RigidCylinder((0.5, 2.0), 0.5), velocity=(0, 1)), "has no velocity"),
        (di.RigidBody(di.RigidCylinder((0.5, 2.0), 0.5), force=lambda t: (0, t, 0)), "is a function of time"),
    ):
        with pytest.raises(ValueError, match=text):
            di.StaticProblem(fem.Function(V), law, contact=[di.Lagrange(di.ContactPair(tags, 1, body))])
    steady = di.ContactPair(tags, 1, di.RigidBody(di.RigidCylinder((0.5, 2.0), 0.5)))
    with pytest.raises(ValueError, match="steady rolling does not move a RigidBody"):
        steady.refuse_rigid_body("steady rolling")
    with pytest.raises(ValueError, match="moves in its plane"):
        tilted = ball(2, spin=(1.0, 0.0, 0.0))
        di.ExplicitProblem(fem.Function(V), law, contact=[di.Penalty(di.ContactPair(tags, 1, tilted))])
    for arguments, error, text in (
        (dict(surface=1), TypeError, "surface must be a RigidPlane"),
        (dict(), ValueError, "needs its centre of mass"),
        (dict(centre=(0, 0, 0), mass=-1.0), ValueError, "mass"),
        (dict(centre=(0, 0, 0), mass=1.0, inertia=(1.0, 1.0)), ValueError, "inertia is a number"),
        (dict(centre=(0, 0, 0), mass=1.0, inertia=(1.0, 0.0, 1.0)), ValueError, "must be positive"),
        (dict(centre=(0, 0, 0), mass=1.0, spin=(0, 0, 1)), ValueError, "needs its inertia"),
        (dict(centre=(0, 0, 0), mass=1.0, fixed=("up",)), ValueError, "fixed has 'up'"),
        (dict(centre=(0, 0, 0), mass=1.0, inertia=1.0, fixed=("rx",), spin=(1, 0, 0)), ValueError, "must be zero"),
    ):
        with pytest.raises(error, match=text):
            di.RigidBody(**{"surface": PLANE, **arguments})
    moved = di.RigidSphere((0, 0, 0), 1.0)
    moved.motion = lambda t: (0.0, 0.0, t)
    with pytest.raises(ValueError, match="has a motion"):
        di.RigidBody(moved, mass=1.0)
    turned = di.RigidSphere((0, 0, 0), 1.0)
    turned.angle = (0.0, 0.0, 0.1)
    with pytest.raises(ValueError, match="has an angle"):
        di.RigidBody(turned, mass=1.0)
    for name, value in (
        ("displacement", (0, 0, 1)), ("motion", lambda t: (0, 0, t)), ("velocity", (0, 0, 1)), ("angle", (0, 0, 1)),
    ):  # fmt: skip
        with pytest.raises((AttributeError, ValueError), match="moves by forces|is a result|turns by torques"):
            setattr(ball(3), name, value)
    lone = di.RigidBody(di.RigidSphere((0, 0, 0), 1.0), mass=1.0)
    with pytest.raises(RuntimeError, match="belongs to no problem"):
        lone.velocity  # noqa: B018
    assert "mass=1" in repr(lone) and lone.centre.tolist() == [0.0, 0.0, 0.0]


def test_where_obstacles_do_not_turn():
    """Methods and problems that refuse an angle, or one of a wrong kind, with a sentence."""
    V, tags = block(SELF, 2)
    law = di.LinearElastic(100.0, 0.3, 1.0, "plane_strain")

    def pair(angle=(0.0, 0.0, 0.1), pivot=None):
        shape = di.RigidCylinder((0.5, 2.0), 0.5)
        shape.angle = angle
        if pivot is not None:
            shape.pivot = pivot
        return di.ContactPair(tags, 1, shape)

    with pytest.raises(ValueError, match="kinematic contact does not turn a rigid master"):
        di.ExplicitProblem(fem.Function(V), law, contact=[di.Kinematic(pair())])
    with pytest.raises(ValueError, match="turns about z"):
        di.StaticProblem(fem.Function(V), law, contact=[di.Penalty(pair((0.1, 0.0, 0.0)))])
    with pytest.raises(ValueError, match="turns about z"):
        di.StaticProblem(fem.Function(V), law, contact=[di.Penalty(pair(0.1, (0.0, 0.0, 1.0)))])
    flat = di.LinearElastic(100.0, 0.3, 1.0, "axisymmetric")
    for kind, method in (
        (di.NewmarkProblem, di.Penalty), (di.StaticProblem, di.Penalty), (di.ExplicitProblem, di.Penalty),
        (di.NewmarkProblem, di.Lagrange), (di.StaticProblem, di.Lagrange),
    ):  # fmt: skip
        with pytest.raises(ValueError, match="axisymmetric problem does not turn"):
            kind(fem.Function(V), flat, contact=[method(pair())])
    in_time = pair(lambda t: (0.0, 0.0, t))
    problem = di.StaticProblem(fem.Function(V), law, contact=[di.Penalty(in_time)])
    with pytest.raises(ValueError, match="is a function of time"):
        problem.solve()
    late = di.ContactPair(tags, 1, di.RigidCylinder((0.5, 2.0), 0.5))
    problem = di.StaticProblem(fem.Function(V), law, contact=[di.Penalty(late)])
    late.master.angle = 0.1
    with pytest.raises(ValueError, match="give the rigid master its angle"):
        problem.solve()
    with pytest.raises(ValueError, match="steady rolling does not turn"):
        pair().refuse_angle("steady rolling does not turn a rigid master")
    running = di.ExplicitProblem(fem.Function(V), law, contact=[di.Penalty(in_time)])
    in_time.master.angle = lambda t: (0.0, 0.0, 2.0 * t)
    with pytest.raises(ValueError, match="the angle of the rigid master was changed"):
        running.advance(1e-3, progress=False)
    assert "angle=..." in repr(in_time.master) and in_time.master.turns_in(running)
    np.testing.assert_allclose(pair().master.rotation_at_start("a")[:2], (np.cos(0.1), -np.sin(0.1)))
