# SPDX-License-Identifier: MIT
"""Explicit contact where it is awkward: edges, corners, thin and fast bodies, several pairs; bodies cut by ranks."""

import explicit_contact_checks
import numpy as np
import pytest
from on_ranks import rank_tests
from plane_bodies import Bodies, total_energy

import dolfinx_impact as di

test_one_rank, test_several_ranks = rank_tests(
    explicit_contact_checks,
    ranks=(2, 3, 4),
    timeout=300,
    in_make_test={
        "sliding_block_is_the_same_on_all_ranks": (2,),
        "free_bodies_keep_their_momentum": (2,),
        "quadratic_bodies_keep_their_momentum": (2,),
    },
)
METHODS = pytest.mark.parametrize("method", (di.Penalty, di.Kinematic))
FLOOR = di.RigidPlane((0.0, 0.0), (0.0, 1.0))


def run(bodies, contacts, until, **options):
    problem = bodies.problem(*contacts, **options)
    problem.advance(until, progress=False)
    return problem


def momentum(bodies, problem):
    return (problem.mass.array * problem.velocity.x.array).reshape(-1, 2).sum(axis=0)


@METHODS
def test_sliding_off_an_edge(method):
    """A block slides off the end of a table, falls freely from there, turning, and is not held back."""
    b = Bodies(((0, 0), (2, 0.5), (11, 3), (0, 0)), ((1.2, 0.501), (1.7, 0.9), (5, 4), (3.0, -0.2)))
    contact = method(b.pair((1, "bottom"), (0, "top"), friction=0.2))
    problem = run(b, [contact], 0.55, held=(0,), loads=[di.BodyForce((0, -5.0))])
    assert b.places(problem, 1)[:, 0].min() > 2.0 and problem.contact[0].area == 0.0
    before = b.mean_velocity(problem, 1)
    problem.advance(0.7, progress=False)
    np.testing.assert_allclose(b.mean_velocity(problem, 1) - before, [0.0, -0.15 * 5.0], atol=1e-9)
    assert abs(problem.energy["drift"]) < 0.01


@METHODS
def test_a_corner_on_a_face(method):
    """A square that falls on its corner: the corner's node alone touches, the square rebounds upright."""
    b = Bodies(
        ((0, 0), (2, 0.5), (11, 3), (0, 0)), ((1.03, 0.501), (1.33, 0.801), (4, 4), (0, -1.0), np.pi / 4)
    )  # fmt: skip
    problem = run(b, [method(b.pair((1, "bottom", "left"), (0, "top")))], 0.2, held=(0,))
    v = b.mean_velocity(problem, 1)
    assert v[1] > 0.95 and abs(v[0]) < 1e-12
    # Springs cut off in the middle of a step cost or bring a little.
    assert np.abs(total_energy(problem)).max() < 0.01


@METHODS
def test_a_face_on_a_vertex_of_the_master(method):
    """A plate falls on the corner of a free square, out of its middle: on the vertex the normal is that of the
    distance, and momentum is kept."""
    top = 0.3 * 2**0.5
    b = Bodies(
        ((0, 0), (0.3, 0.3), (4, 4), (0, 0), np.pi / 4), ((-0.52, top + 1e-3), (0.48, top + 0.301), (10, 3), (0, -1.0))
    )
    problem = run(b, [method(b.pair((1, "bottom"), (0, "top", "right")))], 0.2)
    assert b.mean_velocity(problem, 0)[1] < -1.0 and b.mean_velocity(problem, 1)[1] > -0.7
    # -1 times the area of the plate.
    np.testing.assert_allclose(momentum(b, problem), [0.0, -0.3], atol=1e-13)
    assert np.abs(total_energy(problem)).max() < 0.02 and abs(problem.energy["drift"]) < 0.01


def rebounds(kappa=0.5, places=400):
    """Kinetic energies after over before of a mass that meets a spring, k = kappa m/dt^2, at places of the first touch
    between two steps; with the mean overlap of a step, docs/explicit/accuracy.md."""
    g, v = np.linspace(0.0, 1.0, places, endpoint=False) + 2.0, np.full(places, -1.0)  # steps, m = 1
    for _ in range(40):  # a half period is pi/sqrt(kappa), 4.4 steps
        r = np.abs(v)
        inside = (r / 2 - g) ** 2 / (2 * np.maximum(r, 1e-300))
        v = v + kappa * np.where(g <= -r / 2, -g, np.where(g < r / 2, inside, 0.0))
        g = g + v
    return v**2


def test_rebound_of_a_mass():
    """What docs/explicit/accuracy.md says of it."""
    found = rebounds() - 1
    assert found.min() == pytest.approx(-0.012, abs=5e-4) and found.max() == pytest.approx(0.004, abs=5e-4)  # digits
    assert np.sqrt(np.mean(found**2)) == pytest.approx(0.008, abs=5e-4)
    assert rebounds(0.1).min() - 1 == pytest.approx(-0.0006, abs=5e-5)


@METHODS
def test_chatter(method):
    """A soft block bounces under gravity a dozen times. Kinematic contact takes energy or leaves it. Springs as stiff
    as the step allows, (omega dt)^2 = 0.5, are met in the middle of a step: every bounce gains or loses at random, no
    more than a mass that meets such a spring does."""
    b = Bodies(((0, 0.05), (0.6, 0.45), (4, 3), (0, 0)))
    problem = b.problem(method(b.pair((0, "bottom"), FLOOR)), loads=[di.BodyForce((0, -10.0))])
    highest, closed = [], []

    def look(p):
        highest.append(b.places(p, 0)[:, 1].mean())
        closed.append(p.contact[0].area > 0.0)

    # Steps that stay the same: where they change the kinetic energy does, by as much as is exchanged in one of them.
    dt = 0.8 * problem.stable_step() if method is di.Kinematic else "auto"
    problem.advance(3.0, dt=dt, callback=look, progress=False)
    bounces = np.count_nonzero(np.diff(np.array(closed, dtype=int)) > 0)
    assert bounces > 10
    loss, gain = (rebounds().min() ** bounces - 1, rebounds().max() ** bounces - 1) if method is di.Penalty else (0, 0)
    # In the half step between the last look below and the first above it the block rises by 1e-3.
    assert max(highest) < 0.25 + gain * 0.05 + 1e-3
    if method is di.Kinematic:
        # Before the next step is taken the last forces are not known, nor is their work: histories have it.
        assert np.abs(total_energy(problem)).max() < 1e-12 and problem.energy_history[:, 5].min() > -1e-12
    else:
        assert loss - 1e-4 < problem.energy["drift"] < gain + 1e-4


@METHODS
@pytest.mark.parametrize("slave", (0, 1))
def test_a_thin_plate_is_hit(method, slave):
    """A block on a free plate of one cell, a thirtieth of the block's height: nothing goes through, both ways round."""
    b = Bodies(((0, 0), (2, 0.02), (20, 1), (0, 0)), ((0.7, 0.021), (1.25, 0.4), (4, 3), (0, -1.0)))
    sides = (0, "top"), (1, "bottom")
    problem = run(b, [method(b.pair(sides[slave], sides[1 - slave]))], 0.2)
    over = b.places(problem, 0)
    over = over[(over[:, 0] > 0.75) & (over[:, 0] < 1.2), 1].max()
    assert b.places(problem, 1)[:, 1].min() > over - 5e-3
    np.testing.assert_allclose(momentum(b, problem), [0.0, -0.55 * 0.379], atol=1e-13)
    assert abs(problem.energy["drift"]) < 0.02


@METHODS
def test_a_slave_between_two_masters(method):
    """A block that two others press from below and above, at once: two pairs on one body."""
    b = Bodies(
        ((0, 0), (2, 0.3), (11, 3), (0, 0.5)), ((0.5, 0.31), (1.1, 0.6), (4, 3), (0, 0)),
        ((-0.1, 0.61), (1.9, 0.9), (12, 3), (0, -0.5)),
    )  # fmt: skip
    contacts = [method(b.pair((1, "bottom"), (0, "top"))), method(b.pair((1, "top"), (2, "bottom")))]
    problem, both = b.problem(*contacts), []
    problem.advance(1.0, callback=lambda p: both.append(all(c.area > 0 for c in p.contact)), progress=False)
    assert any(both)
    assert b.mean_velocity(problem, 0)[1] < -0.25 and b.mean_velocity(problem, 2)[1] > 0.25
    np.testing.assert_allclose(momentum(b, problem), [0.0, 0.5 * (0.6 - 0.58)], atol=1e-13)
    assert abs(problem.energy["drift"]) < 0.01


@METHODS
def test_many_pairs(method):
    """A row of six plates, each a little lower than the last: what the first has, the last gets most of."""
    plates = [((0.21 * i, 0.03 * i - 0.5), (0.21 * i + 0.2, 0.5 - 0.03 * i), (4, 5), (i == 0, 0)) for i in range(6)]
    b = Bodies(*plates)
    problem = b.problem(*(method(b.pair((i + 1, "left"), (i, "right"))) for i in range(5)))
    # Equal steps: where a step is shortened, works and kinetic energy differ by 1e-4.
    problem.advance(0.4, dt=0.8 * problem.stable_step(), progress=False)
    v = [b.mean_velocity(problem, i)[0] for i in range(6)]
    assert v[5] > 0.6 and max(v[:5]) < 0.2
    np.testing.assert_allclose(momentum(b, problem), [0.2, 0.0], atol=1e-13)
    assert problem.energy["drift"] < 1e-10


@METHODS
def test_a_body_that_would_go_through_in_a_step_is_caught(method):
    """A step carries the flyer by 0.36 of the plate's thickness; it begins just outside and is deep in after one."""
    b = Bodies(
        ((0, 0), (2, 0.1), (20, 1), (0, 0)), ((0.72, 0.1001), (1.22, 0.2001), (5, 1), (0, -4.0)), E=100.0,
        law=di.LinearElastic,
    )  # fmt: skip
    problem = run(b, [method(b.pair((1, "bottom"), (0, "top")))], 0.06)
    assert 4.0 * problem._stepper.nominal_step > 0.35 * 0.1
    over = b.places(problem, 0)
    assert b.places(problem, 1)[:, 1].mean() > over[(over[:, 0] > 0.7) & (over[:, 0] < 1.25), 1].mean()
    np.testing.assert_allclose(momentum(b, problem), [0.0, -4.0 * 0.05], atol=1e-13)


@METHODS
def test_overlap_at_the_start_is_refused(method):
    b = Bodies(((0, 0), (2, 0.5), (11, 3), (0, 0)), ((0.7, 0.38), (1.25, 0.8), (4, 3), (0, -1.0)))
    with pytest.raises(ValueError, match="overlap at the start"):
        b.problem(method(b.pair((1, "bottom"), (0, "top"))))


def test_balanced_contact_with_an_obstacle_is_refused():
    b = Bodies(((0.0, 0.1), (0.5, 0.5), (2, 2), (0, -1.0)))
    with pytest.raises(ValueError, match="rigid master has one direction, it cannot be balanced"):
        b.problem(di.Penalty(b.pair((0, "bottom"), FLOOR), balanced=True))


@METHODS
def test_flush_edges(method):
    """Equal faces, meshes that do not match, nu = 0: the nodes at the edges stay over the other body but for the slope
    of its facets, some 1e-4."""
    b = Bodies(((0, 0), (0.2, 3), (2, 30), (0, 1.0)), ((0, 3.001), (0.2, 6), (3, 30), (0, -1.0)))
    problem = run(b, [method(b.pair((1, "bottom"), (0, "top")))], 0.25)
    assert abs(problem.energy["drift"]) < 0.01
    assert np.abs(total_energy(problem)).max() < 0.01


@METHODS
def test_gaps_on_the_way(method):
    """A block flies at a table: gaps of all nodes at any time, in closed form."""
    b = Bodies(((0, 0), (2, 0.5), (11, 3), (0, 0)), ((0.5, 0.6), (1.0, 0.9), (5, 3), (0.3, -0.4)))
    problem = b.problem(method(b.pair((1, "bottom"), (0, "top"))))
    contact = problem.contact[0]
    assert np.all(np.isfinite(contact.gap))
    for t in (0.02, 0.1, 0.17, 0.23):
        problem.advance(t, progress=False)
        assert np.all(contact.status == 0)
        np.testing.assert_allclose(contact.gap, 0.1 - 0.4 * t, rtol=0, atol=1e-12)  # round-off of 2,000 steps
        np.testing.assert_allclose(contact.normal, [[0, 1]] * 6, rtol=0, atol=1e-12)


@METHODS
def test_velocity_of_a_node_in_contact_has_its_force_in_it(method):
    """A bar on the floor: its lower end is at rest while it is in contact, also as `velocity` tells."""
    b = Bodies(((0, 1e-4), (0.1, 3.0001), (1, 30), (0, -0.3)))
    problem = run(b, [method(b.pair((0, "bottom"), FLOOR))], 0.09)
    low = b.X[:, 1] < 1e-3
    assert problem.contact[0].area > 0.0
    assert np.abs(problem.velocity.x.array.reshape(-1, 2)[low, 1]).max() < 0.1 * 0.3
