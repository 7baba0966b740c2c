# SPDX-License-Identifier: MIT
"""A RigidBall of the hand-written solver alone: it falls freely, and exchanges momentum with a block."""

import numpy as np
import pytest

from impact_reference import Material, Model, NodalPenalty, RigidBall

N = 4  # cells along a side


def block():
    """Unit square; the model and the facets of its upper side."""
    x = np.linspace(0.0, 1.0, N + 1)
    points = np.array([(a, b) for b in x for a in x])
    cells = np.array([[j * (N + 1) + i + k for k in (0, 1, N + 2, N + 1)] for j in range(N) for i in range(N)])
    top = np.array([[N * (N + 1) + i, N * (N + 1) + i + 1] for i in range(N)])
    return Model(points, cells, "quadrilateral", Material(100.0, 0.3, 1.0, "plane_strain")), top


def test_it_falls_freely():
    """Kinetic energy is the work of the force; no contact."""
    model, top = block()
    ball = RigidBall((0.5, 5.0), 0.5, mass=2.0, inertia=0.3, velocity=(0.1, 0.0), spin=(0.0, 0.0, 1.0), force=(0, -4.0))
    result = model.run_explicit(1e-3, 200, contacts=[NodalPenalty(top, ball, friction=0.3)])
    kinetic, external = result.energies["kinetic"], result.energies["external"]
    fallen = 0.5 * 2.0 * result.time**2
    np.testing.assert_allclose(external, 4.0 * fallen, rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(kinetic - kinetic[0], external, rtol=1e-9, atol=1e-14)
    assert np.abs(result.energies["drift"]).max() < 1e-12


def test_the_energy_balance_of_an_impact():
    """What the ball loses the block has, springs store and friction takes."""
    model, top = block()
    ball = RigidBall((0.45, 1.501), 0.5, mass=0.5, inertia=0.06, velocity=(0.2, -0.5), spin=(0.0, 0.0, -1.0))
    result = model.run_explicit(2e-3, 200, contacts=[NodalPenalty(top, ball, friction=0.3)])
    assert np.abs(result.contacts[0].total[:, 1]).max() > 0.1 and result.energies["friction"][-1] > 0.0
    assert np.abs(result.energies["drift"]).max() < 5e-3  # central differences at a third of the stable step


def test_what_is_refused():
    model, top = block()
    with pytest.raises(ValueError, match="moves by forces"):
        NodalPenalty(top, RigidBall((0.5, 2.0), 0.5, 1.0, 1.0), motion=0.0)
    with pytest.raises(ValueError, match="positive mass"):
        model.run_explicit(1e-3, 1, contacts=[NodalPenalty(top, RigidBall((0.5, 2.0), 0.5, 0.0, 1.0))])
