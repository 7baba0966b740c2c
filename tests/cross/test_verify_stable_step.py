# SPDX-License-Identifier: MIT
"""The limit of a step with springs of given stiffness is the same on both sides."""

import impact_reference
import numpy as np
import pytest
from dolfinx import fem

import dolfinx_impact as di
from impact_verify.contact_bodies import SLAVE
from impact_verify.scenarios import explicit_runs

PENALTY = 300.0  # of E/h some 30: the springs make the highest frequency
NAMES = [
    (explicit_runs.bars, "triangle", 1, "two bars, 3 rows, penalty"),
    (explicit_runs.bars, "quadrilateral", 2, "two bars, 1 rows, penalty"),
    (explicit_runs.disc, "quadrilateral", 1, "disc on a block, penalty"),
    (explicit_runs.disc, "quadrilateral", 1, "disc on a block, balanced penalty"),
    (explicit_runs.blocks, "tetrahedron", 1, "block on a block, neo-hookean, penalty"),
    (explicit_runs.rigid, "quadrilateral", 1, "ring on a rigid plane, penalty"),
    (explicit_runs.rigid, "quadrilateral", 1, "block under a rigid cylinder that moves, penalty"),
]


def both(case):
    """Limits by our side and the hand-written one, at rest."""
    body = case.body
    held = np.asarray(case.fixed_nodes, dtype=np.int32)
    bcs = [fem.dirichletbc(np.zeros(body.gdim), held, body.V)] if len(held) else []
    u = fem.Function(body.V)
    problem = di.ExplicitProblem(
        u, body.material, velocity=fem.Function(body.V), bcs=bcs,
        contact=[di.Penalty(body.pair(everywhere=False), penalty=PENALTY, **case.options)],
    )  # fmt: skip
    slave = body.their_facets(body.tags, SLAVE)
    master = body.rigid[1] if body.rigid else body.their_facets(body.tags, 2)
    contact = impact_reference.NodalPenalty(slave, master, body.friction, penalty=PENALTY, **case.options)
    fixed = body.order[(held.astype(int)[:, None] * body.gdim + np.arange(body.gdim)).ravel()]
    theirs = body.model.stable_step("eigenvalue", fixed_dofs=fixed, contacts=[contact])
    free = body.model.stable_step("eigenvalue", fixed_dofs=fixed)
    return problem, theirs, free


@pytest.mark.parametrize("make,cell,degree,name", NAMES, ids=[f"{n}, {c}" for _, c, _, n in NAMES])
def test_limit_with_springs(make, cell, degree, name):
    problem, theirs, free = both(next(case for case in make(cell, degree) if case.name == name))
    assert theirs < 0.9 * free
    assert problem.stable_step("eigenvalue") == pytest.approx(theirs, rel=1e-8)  # both sides' tolerance
    assert problem.stable_step() < theirs
