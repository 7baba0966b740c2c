# SPDX-License-Identifier: MIT
"""Blocks that have been dropped on each other come to rest and stay so: contact does not pump them."""

import numpy as np
import pytest
from dolfinx import fem
from plane_bodies import Bodies

import dolfinx_impact as di

SEED = 5  # the same stacks in every run: each was looked at
# The upper blocks of these come to an edge, as they hop down a slope, and fall, with half of the steps as well: their
# weight does work.
TOPPLES = {6, 14}
FALLS = 100.0  # of the kinetic energy at the start: a block that falls, and soon turns more than its law can bear
DEBT = 0.05  # of the kinetic energy at the start: what springs may owe, docs/explicit/penalty.md, "Bound"


def stack(number):
    """One to three blocks at random, on a rigid plane or on one that is held; they fall a little and slide."""
    rng = np.random.default_rng([SEED, number])
    friction, weight = rng.uniform(0.1, 1.0), 10.0
    lean = 0.3 * friction * rng.uniform(-1, 1)  # of gravity: friction holds them
    rigid, balanced = rng.random() < 0.4, rng.random() < 0.4
    speed = (rng.uniform(-0.2, 0.2), -rng.uniform(0.2, 0.6))
    rectangles, top, width = [], 0.0, 3.0
    if not rigid:
        rectangles.append(((0.0, -0.5), (3.0, 0.0), (int(rng.integers(3, 10)), int(rng.integers(1, 3))), (0.0, 0.0)))
    for _ in range(int(rng.integers(1, 4))):
        width *= rng.uniform(0.4, 0.7)
        height = width * rng.uniform(0.3, 0.7)
        low = (1.5 - width / 2, top + rng.uniform(5e-4, 3e-3))
        cells = (int(rng.integers(1, 6)), int(rng.integers(1, 3)))
        rectangles.append((low, (low[0] + width, low[1] + height), cells, speed))
        top = low[1] + height
    stiffness = 10 ** rng.uniform(4.0, 5.5)
    bodies = Bodies(*rectangles, E=stiffness, nu=0.3, law=di.LinearElastic)
    plane = di.RigidPlane((0.0, 0.0), (0.0, 1.0))
    contact = [di.Penalty(bodies.pair((0, "bottom"), plane, friction=friction))] if rigid else []
    for b in range(1, len(rectangles)):
        pair = bodies.pair((b, "bottom"), (b - 1, "top"), friction=friction)
        contact.append(di.Penalty(pair, balanced=balanced))
    foot = np.flatnonzero(np.isclose(bodies.X[:, 1], -0.5)).astype(np.int32)  # none over the rigid plane
    return di.ExplicitProblem(
        fem.Function(bodies.V),
        bodies.law,
        velocity=bodies.velocity,
        bcs=[fem.dirichletbc(np.zeros(2), foot, bodies.V)] if len(foot) else [],
        loads=[di.BodyForce((weight * lean, -weight))],
        contact=contact,
    )


def check(number, steps):
    problem = stack(number)
    problem.advance(steps * 0.9 * problem.stable_step(), progress=False)
    kinetic, internal, *_, external = energies = problem.energy_history[:, 1:].T
    begin = kinetic[0]
    assert abs(len(kinetic) - steps) <= 1
    if number in TOPPLES and np.any(kinetic > FALLS * begin):
        energies = energies[:, : np.argmax(kinetic > FALLS * begin)]
        kinetic, internal, *_, external = energies
    # Never more than there was, and what the load has done: `contact` has what springs store and what they have lost.
    assert np.max(kinetic + internal - external) < (1 + DEBT) * begin
    tenths = np.array([part.mean() for part in np.array_split(kinetic, 10)]) / begin
    if number not in TOPPLES:
        # Vibrations that contact does not damp stay, and wander between the blocks: they do not grow.
        assert np.mean(tenths[8:]) < max(1.5 * np.mean(tenths[3:5]), 1e-3), (number, tenths)
    total = energies[:-1].sum(axis=0) - external
    return tenths, (total[-1] - total[0]) / begin


@pytest.mark.parametrize("number", (0, 4, 5, 8))  # the first and the last grew without the account of energies
def test_stack_rests(number):
    check(number, 20_000)


@pytest.mark.slow
@pytest.mark.parametrize("number", range(20))
def test_stack_rests_for_long(number):
    tenths, drift = check(number, 200_000)
    print(f"stack {number}: mean kinetic energy by tenths {tenths.round(5)}, drift {drift:.1e}")
