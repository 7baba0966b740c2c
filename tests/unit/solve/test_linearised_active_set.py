# SPDX-License-Identifier: MIT
"""Active sets that are updated on the linearised problem: columns that stand over a plane, each with its own gap.

A column of height 1 without lateral contraction hangs on springs of the stiffness k. A pressure q on its top presses it
on the plane with (q - k g) / (1 + k/E) if that is positive, and not at all else. One linear solution, with the contact
of the last solve, must be enough: what closes and what opens follows from responses to unit forces and unit gaps.
"""

import numpy as np
import pytest
from dolfinx import fem
from lifted_columns import lifted_columns

import dolfinx_impact as di
from dolfinx_impact.contact.mortar.lagrange import LagrangeContact

E, K, GAPS = 1000.0, 200.0, np.array([0.01, 0.02, 0.03, 0.04, 0.05])
PER_COLUMN = 2  # nodes that a column may touch with


@pytest.fixture
def columns():
    """Contact problem of five squares side by side, each lifted by its gap; the load on their tops."""
    V, tags = lifted_columns(GAPS)
    guided = fem.dirichletbc(0.0, fem.locate_dofs_topological(V.sub(0), 1, tags.find(2)), V.sub(0))
    load = di.Traction(tags, 2, (0.0, 0.0))
    pair = di.ContactPair(tags, slave=1, master=di.RigidPlane((0.0, 0.0), (0.0, 1.0)))
    law = di.LinearElastic(E, 0.0, 1.0, "plane_strain")
    loads, contact = [load, di.Foundation(tags, 2, K)], [di.Lagrange(pair)]
    return di.StaticProblem(fem.Function(V), law, bcs=[guided], loads=loads, contact=contact), load.constant


@pytest.fixture
def responses(monkeypatch, contacts_in_python):
    """Number of responses that were asked for so far, in a list."""
    count, respond = [0], LagrangeContact.linearised_response

    def counted(*arguments):
        count[0] += 1
        return respond(*arguments)

    monkeypatch.setattr(LagrangeContact, "linearised_response", counted)
    return count


def pressures(problem):
    """By column, the mean of its nodes; both must be the same."""
    contact = problem.contact[0]
    column = ((contact.points[:, 0] + 0.5) // 2).astype(int)  # from 2 k to 2 k + 1, but for round-off
    found = np.array([contact.pressure[column == k] for k in range(len(GAPS))])
    np.testing.assert_allclose(found[:, 0], found[:, 1], atol=1e-9 * E)
    return found.mean(axis=1)


def test_columns_close_and_open_on_the_linearised_problem(responses, columns):
    problem, load = columns
    for depth, changed in ((0.025, 2), (0.055, 3), (0.035, 2), (0.005, 3)):  # where the springs alone would hold them
        before = responses[0]
        load.value[1] = -K * depth
        report = problem.solve(progress=False)
        expected = K * np.maximum(depth - GAPS, 0.0) / (1.0 + K / E)
        np.testing.assert_allclose(pressures(problem), expected, atol=1e-9 * E)
        assert problem.contact[0].force[1] == pytest.approx(expected.sum(), abs=1e-9 * E)
        assert responses[0] - before == PER_COLUMN * changed  # one for each node that differs, and no more
        assert sum(report.contact_changes[0]) == PER_COLUMN * changed
