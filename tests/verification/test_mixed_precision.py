# SPDX-License-Identifier: MIT
"""Energy and momentum of a body that vibrates freely, with element forces in float."""

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.assembly import operators

# 40 roundings of float in a force, 6e-8 each; errors of different steps are independent, so that their sum grows as the
# square root of the number of steps.
ROUND_OFF = 40 * 2.0**-24
# In double all forces of a step are wrong by less than this, and all errors of steps may have the same sign.
OF_DOUBLE = 40 * 2.0**-53
SAMPLES = 10


def histories(precision, steps):
    """Relative changes of energy and momentum over a run, shapes (SAMPLES,) and (SAMPLES, 3).

    Central differences of linear forces conserve kinetic energy + stored energy - dt^2/8 a M a, with velocity and
    acceleration a of one time level. The stored energy is that of the displacement, in double.
    """
    domain = mesh.create_unit_cube(MPI.COMM_SELF, 2, 2, 2, mesh.CellType.hexahedron)
    V = fem.functionspace(domain, ("Lagrange", 1, (3,)))
    u, v = fem.Function(V, name="u"), fem.Function(V)
    v.interpolate(lambda x: 0.01 * np.sin(3.0 * x))  # turns nowhere
    problem = di.ExplicitProblem(u, di.LinearElastic(1.0, 0.3, 1.0), velocity=v, precision=precision)
    stored = operators.Energy(operators.strain_energy_form(u, problem.material))
    dt, mass = 0.5 * problem.stable_step(), problem.mass.array
    energy, momentum = [], []
    for k in range(SAMPLES + 1):
        problem.advance(k * (steps // SAMPLES) * dt, dt=dt, progress=False)
        a, velocity = problem.acceleration.x.array, problem.velocity.x.array
        correction = dt**2 / 8 * np.sum(mass * a**2)
        energy.append(0.5 * np.sum(mass * velocity**2) + stored.value() - correction)
        momentum.append((mass * velocity).reshape(-1, 3).sum(axis=0))
    momentum = np.array(momentum)
    return np.array(energy[1:]) / energy[0] - 1.0, (momentum[1:] - momentum[0]) / np.linalg.norm(momentum[0])


@pytest.mark.parametrize("steps", [2000, pytest.param(1_000_000, marks=pytest.mark.slow)])
def test_energy_does_not_drift(steps):
    in_double, momentum_in_double = histories("double", steps)
    in_mixed, momentum = histories("mixed", steps)
    print(f"{steps} steps: energy {np.abs(in_double).max():.1e} {np.abs(in_mixed).max():.1e}", in_mixed)
    print(f"momentum {np.abs(momentum_in_double).max():.1e} {np.abs(momentum).max():.1e}")
    assert np.abs(in_double).max() < steps * OF_DOUBLE
    assert 0.0 < np.abs(in_mixed).max() < np.sqrt(steps) * ROUND_OFF
    for change in (momentum_in_double, momentum):
        assert np.abs(change).max() < steps * OF_DOUBLE
