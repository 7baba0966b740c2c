# SPDX-License-Identifier: MIT
"""Totals of explicit contacts are those of their nodes, of pairs and of contact that finds itself alike."""

import numpy as np
import pytest
from plane_bodies import Bodies

import dolfinx_impact as di
from dolfinx_impact.contact.explicit.nodal_output import NodalOutput


@pytest.mark.parametrize("general", (False, True))
def test_totals_are_sums_over_nodes(general):
    """Two blocks that overlap a little and slide: force, moment, area and stored energy."""
    low, high = ((0.0, 0.0), (2.0, 1.0), (6, 3), (0.0, 0.0)), ((0.3, 0.999), (1.7, 1.6), (4, 2), (0.5, -0.1))
    bodies = Bodies(low, high)
    contact = di.GeneralContact(bodies.tags, friction=0.3)
    if not general:
        contact = di.Penalty(bodies.pair((1, "bottom"), (0, "top"), friction=0.3))
    problem = bodies.problem(contact)
    problem.advance(until=5 * 1e-3, dt=1e-3, progress=False, energy_limits=None)
    found = problem.contact[0]
    assert isinstance(found, NodalOutput) and found.stored > 0.0
    forces = found.traction * found.weight[:, None]
    size = np.abs(forces).sum()
    assert size > 0.0
    np.testing.assert_allclose(found.force, forces.sum(axis=0), atol=1e-13 * size)  # sums of some ten numbers
    moment = np.sum(found.points[:, 0] * forces[:, 1] - found.points[:, 1] * forces[:, 0])
    assert found.moment[0] == pytest.approx(moment, abs=1e-13 * size)
    touched = np.any(forces != 0.0, axis=1)
    assert found.area == pytest.approx(found.weight[touched].sum(), rel=1e-14)
    if general:  # forces and reactions are all on the same nodes
        assert np.abs(found.force).max() < 1e-13 * size
