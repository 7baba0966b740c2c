# SPDX-License-Identifier: MIT
"""When an implicit run is stopped because its residual gives energy without end."""

import pytest

from dolfinx_impact.dynamics.energy_gain import GROWTH
from dolfinx_impact.dynamics.implicit.growth_guard import GrowthGuard

LIMIT = 2.0  # energy that the residual may give


def energy(kinetic, internal=0.0, external=0.0):
    return {"kinetic": kinetic, "internal": internal, "external": external}


def test_energy_that_was_put_in_may_move_the_body():
    """External work, whatever its size; released energy up to the limit."""
    guard = GrowthGuard(LIMIT, kinetic=1.0)
    guard.check(energy(500.0 * LIMIT, internal=-LIMIT), 0.1)
    assert guard.reference == LIMIT
    guard.check(energy(1e6, external=1e6), 0.2)
    assert guard.reference == 1e6
    guard.check(energy(1.0), 0.3)
    assert guard.reference == 1e6  # what was put in once counts on


@pytest.mark.parametrize("start", (0.5, 10.0))
def test_more_than_a_thousand_times_that_is_stopped(start):
    """The reference is the larger of the start and of what the residual may give."""
    largest = GROWTH * max(start, LIMIT)
    guard = GrowthGuard(LIMIT, kinetic=start)
    released = -(LIMIT + 1.0)
    guard.check(energy(0.999 * largest, internal=released), 0.1)
    with pytest.raises(RuntimeError, match="The run was stopped at the time 0.2"):
        guard.check(energy(1.001 * largest, internal=released), 0.2)
    guard.check(energy(1.001 * largest, internal=released), 0.3)  # a further call goes on from there


def test_bodies_that_release_little_are_not_judged():
    """Their kinetic energy came from elsewhere: a load that the balance does not know yet."""
    GrowthGuard(LIMIT, kinetic=0.0).check(energy(1e9, internal=-0.99 * LIMIT), 0.1)
