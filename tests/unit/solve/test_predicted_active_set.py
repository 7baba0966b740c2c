# SPDX-License-Identifier: MIT
"""Active sets that are predicted before the first factorisation: bodies that follow their supports would overlap.

Columns of height 1 without lateral contraction stand side by side over a plane, each with its own gap. Their tops are
moved down by a depth, so that a column is pressed with E (depth - gap).
"""

import numpy as np
import predicted_active_set_checks
import pytest
from dolfinx import fem
from lifted_columns import lifted_columns
from on_ranks import rank_tests

import dolfinx_impact as di

test_one_rank, test_several_ranks = rank_tests(predicted_active_set_checks)

E, GAPS = 1000.0, np.array([0.01, 0.02, 0.03, 0.04, 0.05])
PER_COLUMN = 2  # nodes that a column may touch with
ROUND_OFF = 1e-9


def pressed_columns(depth: float, friction: float = 0.0):
    """Problem of five squares side by side, each lifted by its gap, and the displacement of their tops."""
    V, tags = lifted_columns(GAPS)
    down = fem.Constant(V.mesh, -depth)
    bcs = [fem.dirichletbc(value, fem.locate_dofs_topological(V.sub(c), 1, tags.find(2)), V.sub(c))
           for c, value in ((0, fem.Constant(V.mesh, 0.0)), (1, down))]  # fmt: skip
    plane = di.RigidPlane((0.0, 0.0), (0.0, 1.0))
    pair = di.ContactPair(tags, slave=1, master=plane, friction=friction)
    law = di.LinearElastic(E, 0.0, 1.0, "plane_strain")
    return di.StaticProblem(fem.Function(V), law, bcs=bcs, contact=[di.Lagrange(pair)]), down


def check_pressures(problem, depth):
    contact = problem.contact[0]
    column = ((contact.points[:, 0] + 0.5) // 2).astype(int)  # from 2 k to 2 k + 1, but for round-off
    np.testing.assert_allclose(contact.pressure, E * np.maximum(depth - GAPS[column], 0.0), atol=ROUND_OFF * E)


@pytest.mark.parametrize(
    "depth, predicted, closed",
    [
        # All but the last overlap by more than 0.8 of the largest overlap, which is 0.19.
        (0.20, 4, 5),
        (0.05, 1, 4),
        (0.005, 0, 0),
    ],
)
def test_what_is_predicted_need_not_change(depth, predicted, closed):
    problem, _ = pressed_columns(depth)
    report = problem.solve(progress=False)
    check_pressures(problem, depth)
    assert report.active_set_sizes[0][0] == 0  # gaps alone close nothing
    assert sum(report.contact_changes[0]) == PER_COLUMN * (closed - predicted)


def test_what_is_predicted_too_much_opens():
    problem, down = pressed_columns(0.20)
    problem.solve(progress=False)
    down.value = -0.025  # nodes in contact stay so in a prediction
    report = problem.solve(progress=False)
    check_pressures(problem, 0.025)
    assert sum(report.contact_changes[0]) == PER_COLUMN * 3


def test_friction_is_not_predicted():
    problem, _ = pressed_columns(0.20, friction=0.3)
    report = problem.solve(progress=False)
    check_pressures(problem, 0.20)
    assert sum(report.contact_changes[0]) >= PER_COLUMN * 5
