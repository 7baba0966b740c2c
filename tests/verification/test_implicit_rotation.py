# SPDX-License-Identifier: MIT
"""Bodies that turn far: free flight with spin, and an elastic pendulum; momenta and energy."""

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di

SOFT = di.NeoHookean(E=1000.0, nu=0.3, density=1.0, hypothesis="plane_strain")


def space(lengths, cells):
    domain = mesh.create_rectangle(MPI.COMM_SELF, [[0.0, 0.0], lengths], cells, mesh.CellType.quadrilateral)
    return fem.functionspace(domain, ("Lagrange", 1, (2,)))


def momenta(problem):
    """Linear momentum, (2), and angular momentum about the origin [M L/T, M L^2/T]."""
    momentum = problem.inertia.times(problem.velocity.x.array).reshape(-1, 2)
    x = problem.space.tabulate_dof_coordinates()[:, :2] + problem.u.x.array.reshape(-1, 2)
    return momentum.sum(axis=0), float(np.sum(x[:, 0] * momentum[:, 1] - x[:, 1] * momentum[:, 0]))


def thrown(step, turns=0.5, **options):
    """A block that flies and spins; momenta at the start and largest changes of them and of the energy, relative."""
    V = space([1.0, 0.5], [4, 2])
    u, v = fem.Function(V), fem.Function(V)
    spin = 2.0
    v.interpolate(lambda x: np.vstack([1.0 - spin * (x[1] - 0.25), 2.0 + spin * (x[0] - 0.5)]))
    problem = di.NewmarkProblem(u, SOFT, velocity=v, **options)
    linear, angular = momenta(problem)
    rows = []

    def keep(p):
        now = momenta(p)
        rows.append((np.abs(now[0] - linear).max() / np.abs(linear).max(), abs(now[1] / angular - 1.0),
                     abs(p.energy["total"] / p.energy_history[0, 1] - 1.0)))  # fmt: skip

    problem.advance(2 * np.pi * turns / spin, step, callback=keep, progress=False)
    return np.max(rows, axis=0)


def test_free_flight_keeps_momenta():
    """Linear momentum is exact, to the tolerance of Newton's method in each of some hundred steps."""
    linear, angular, energy = thrown(0.01)
    assert linear < 1e-9
    # Finite rotations: errors of second order in the angle of a step, 0.02.
    assert angular < 2e-3 and energy < 2e-3


def test_errors_of_finite_rotations_are_of_second_order():
    coarse, fine = thrown(0.02, 0.25)[1], thrown(0.01, 0.25)[1]
    assert np.log2(coarse / fine) > 1.7


def pendulum(steps, step, **options):
    """A rod that swings from the horizontal, held at the middle of one end; problem, and rows of time, angular
    momentum about the pivot, torque of gravity and total energy."""
    gravity = 1.0
    V = space([1.0, 0.125], [8, 2])
    u, v = fem.Function(V), fem.Function(V)
    pivot = fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[0], 0.0) & np.isclose(x[1], 0.0625))
    assert len(pivot) == 1
    held = fem.dirichletbc(np.zeros(2), pivot, V)
    load = di.BodyForce((0.0, -gravity))
    problem = di.NewmarkProblem(u, SOFT, velocity=v, bcs=[held], loads=[load], **options)
    weights = problem.inertia.times(np.tile([0.0, 1.0], len(u.x.array) // 2)).reshape(-1, 2)[:, 1] * gravity
    rows = []

    def keep(p):
        x = V.tabulate_dof_coordinates()[:, :2] + u.x.array.reshape(-1, 2) - [0.0, 0.0625]
        momentum = p.inertia.times(p.velocity.x.array).reshape(-1, 2)
        angular = np.sum(x[:, 0] * momentum[:, 1] - x[:, 1] * momentum[:, 0])
        rows.append((p.time, angular, -float(weights @ x[:, 0]), p.energy["total"]))

    problem.advance(steps * step, step, callback=keep, progress=False)
    return problem, np.array(rows)


def check_pendulum(steps, step, **options):
    problem, rows = pendulum(steps, step, **options)
    time, angular, torque, energy = rows.T
    turned = np.concatenate([[0.0], np.cumsum(np.diff(time) * 0.5 * (torque[1:] + torque[:-1]))])
    scale = np.abs(angular).max()
    fallen = 0.5 * 1.0 * 0.125  # kinetic energy at the lowest point, about
    return np.abs(angular - turned).max() / scale, np.abs(energy).max() / fallen


def test_pendulum_swings():
    """A swing and a half by the trapezoidal rule: its angular momentum is the integral of the torque, its energy stays,
    to the errors of second order in the angle of a step, 0.02, which add up over it."""
    angular, energy = check_pendulum(500, 0.02)
    assert angular < 5e-3 and energy < 5e-3


@pytest.mark.slow
@pytest.mark.parametrize("options", [{}, {"rho_inf": 0.9}])
def test_pendulum_over_ten_thousand_steps(options):
    """Some 30 swings: nothing grows. Numerical damping takes the vibration of the rod and leaves the swing."""
    angular, energy = check_pendulum(10_000, 0.01, **options)
    assert angular < 2e-2 and energy < 2e-2
