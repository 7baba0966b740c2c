# SPDX-License-Identifier: MIT
"""Nodes that move through the master in few steps: contact stops them, or the run raises an error."""

import numpy as np
import pytest
import tunnelling_checks
from dolfinx import mesh
from on_ranks import rank_tests
from plane_bodies import Bodies

import dolfinx_impact as di

test_one_rank, test_several_ranks = rank_tests(
    tunnelling_checks,
    ranks=(2,),
    timeout=300,
    in_make_test={"up_to_a_facet_in_a_step_is_held_back": (2,), "beyond_a_facet_in_a_step_is_an_error": (2,)},
)
METHODS = pytest.mark.parametrize("method", (di.Penalty, di.Kinematic))


@METHODS
def test_the_first_of_two_thin_layers_holds(method):
    """A node that is past the first plate and nearer to the second one, both in one master surface, is held by the
    first: the second plate is never touched."""
    h = 0.25
    bodies = Bodies(
        ((0, 0), (2.0, h), (8, 1), (0, 0)),
        ((0, 1.02 * h), (2.0, 2.02 * h), (8, 1), (0, 0)),
        ((0.61, 2.1 * h), (1.36, 3.1 * h), (3, 1), (0, 0)),
        law=di.LinearElastic,
        E=1.0,
    )
    top, other_top, bottom = 4 * 0 + 3, 4 * 1 + 3, 4 * 2 + 1
    values = np.where(bodies.tags.values == top, other_top, bodies.tags.values)
    pair = di.ContactPair(mesh.meshtags(bodies.mesh, 1, bodies.tags.indices, values), bottom, other_top)
    dt = 0.9 * bodies.problem(held=(0, 1)).stable_step()
    bodies.velocity.x.array.reshape(-1, 2)[bodies.bodies[2][0]] = (0.0, -0.99 * h / dt)
    problem = bodies.problem(method(pair), held=(0, 1))
    low = []
    problem.advance(
        25 * dt, dt=dt, progress=False, callback=lambda p: low.append(bodies.places(p, 2)[:, 1].min() - 2.02 * h)
    )
    assert bodies.mean_velocity(problem, 2)[1] > 0.4 * 0.99 * h / dt
    assert low[-1] > 0.0
    if method is di.Kinematic:
        assert min(low) > -1e-12


@METHODS
def test_through_a_thin_rod(method):
    """A rigid rod of 0.6 of a facet: a node may be behind it at the step's end; the way through it counts."""
    h = 0.25
    bodies = Bodies(((0, 0.12), (4 * h, 0.12 + h), (4, 1), (0, 0)), law=di.LinearElastic, E=1.0)
    pair = bodies.pair((0, "bottom"), di.RigidCylinder((2 * h, 0.0), 0.3 * h))
    dt = 0.9 * bodies.problem().stable_step()
    bodies.velocity.x.array.reshape(-1, 2)[:] = (0.0, -0.8 * h / dt)
    problem = bodies.problem(method(pair))
    problem.advance(3 * dt, dt=dt, progress=False)
    assert problem.force_history[0][:, 1].max() > 0.0
    bodies.velocity.x.array.reshape(-1, 2)[:] = (0.0, -2.2 * h / dt)
    with pytest.raises(RuntimeError, match="went through the master"):
        bodies.problem(method(pair)).advance(3 * dt, dt=dt, progress=False)


def test_the_message_names_the_node():
    """Its number in the mesh's input and its place at rest."""
    h = 0.25
    bodies = Bodies(((0, 0.12), (4 * h, 0.12 + h), (4, 1), (0, 0)), law=di.LinearElastic, E=1.0)
    pair = bodies.pair((0, "bottom"), di.RigidCylinder((2 * h, 0.0), 0.3 * h))
    dt = 0.9 * bodies.problem().stable_step()
    bodies.velocity.x.array.reshape(-1, 2)[:] = (0.0, -2.2 * h / dt)
    problem = bodies.problem(di.Penalty(pair))
    with pytest.raises(RuntimeError, match=r"node 2 of cell \d .*at \[0\.5, 0\.12\].*came by 2\.\d"):
        problem.advance(3 * dt, dt=dt, progress=False)
    assert problem.time == 0.0 and not problem.u.x.array.any()
    np.testing.assert_allclose(problem.velocity.x.array.reshape(-1, 2)[:, 1], -2.2 * h / dt)


@METHODS
def test_who_begins_to_face_inside_the_master_is_not_pushed_out(method):
    """A little block lies inside the master, with its slave side, which faces sideways, under the surface by a quarter
    to a half of a facet; as it spins the side comes to face the surface. Nobody has come through that: no force, and no
    energy from nowhere."""
    h = 0.25
    bodies = Bodies(
        ((0, -1.0), (4 * h, 0.0), (4, 4), (0, 0)),
        ((2 * h, -0.11), (2 * h + 0.06, -0.05), (1, 1), (0, 0)),
    )
    nodes, _ = bodies.bodies[1]
    arm = bodies.X[nodes] - bodies.X[nodes].mean(axis=0)
    bodies.velocity.x.array.reshape(-1, 2)[nodes] = 0.5 * np.column_stack([-arm[:, 1], arm[:, 0]])
    pair = bodies.pair((1, "left"), (0, "top"))
    problem = bodies.problem(method(pair), held=(0,))
    gaps = []
    problem.advance(0.4, progress=False, callback=lambda p: gaps.append(p.contact[0].gap.copy()))
    assert np.all(gaps[0] == np.inf) and -0.5 * h < gaps[-1].min() and gaps[-1].max() < -0.1 * h  # seen, inside
    assert not np.any(problem.force_history[0])
    kinetic = problem.energy_history[:, 1]
    assert kinetic.max() < (1 + 1e-3) * kinetic[0]  # but for what the block stores as its spin stretches it
