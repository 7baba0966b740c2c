# SPDX-License-Identifier: MIT
"""Energy of explicit runs whose steps change."""

import numpy as np
import pytest
from dolfinx import fem
from plane_bodies import Bodies, total_energy

import dolfinx_impact as di


@pytest.mark.parametrize("change", (0.0, 0.5))
def test_the_balance_does_not_jump_where_steps_change(change):
    """A bar in its lowest longitudinal mode, with steps that change at random in every one: the energy of the scheme
    is that of the motion to (omega dt)^2/8 of the kinetic energy, and no row has a jump of omega times the change."""
    bar = Bodies(((0.0, 0.0), (4.0, 1.0), (16, 4), (0.0, 0.0)), E=1.0, law=di.LinearElastic)
    bar.velocity.interpolate(lambda x: np.vstack([np.sin(np.pi * (x[0] - 2.0) / 4.0), 0.0 * x[0]]))
    problem = di.ExplicitProblem(fem.Function(bar.V), bar.law, velocity=bar.velocity)
    omega, dt = np.pi / 4.0, 0.05  # of a bar of length 4, wave speed 1
    assert dt * (1 + change) < problem.stable_step()
    rng = np.random.default_rng(1)
    for _ in range(200):
        problem.advance(until=problem.time + dt * (1 + change * rng.uniform(-1, 1)), dt=2 * dt, progress=False)
    error = np.abs(total_energy(problem)).max()
    limit = (omega * dt * (1 + change)) ** 2 / 8
    assert error < (limit if change else 1e-12), error
    # What the balance had without the step's change: omega dt change/4 and more.
    assert limit < 0.1 * omega * dt * 0.5 / 4 * 2
