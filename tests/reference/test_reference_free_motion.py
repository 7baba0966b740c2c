# SPDX-License-Identifier: MIT
"""Central differences of free bodies against closed forms."""

import numpy as np
import pytest

import impact_reference as ref


def test_two_masses_on_a_spring():
    """Displacements of central differences are v sin(n a)/sin(a) dt, with sin(a/2) = omega dt/2 of the relative motion;
    the centre of mass moves evenly."""
    mass, stiffness, dt, steps = np.array([[2.0], [3.0]]), 7.0, 0.1, 40

    def forces(u):
        stretch = u[1, 0] - u[0, 0]
        energy = 0.5 * stiffness * stretch**2
        return ref.BodyForces(np.array([[-stiffness * stretch], [stiffness * stretch]]), energy, 0.25 * energy)

    end = ref.move_freely(mass, np.array([[1.0], [-0.5]]), forces, dt, steps)
    omega = np.sqrt(stiffness * (1 / 2.0 + 1 / 3.0))
    a = 2 * np.arcsin(0.5 * omega * dt)
    stretch = -1.5 * dt * np.sin(steps * a) / np.sin(a)
    u = end.displacement[:, 0]
    assert u[1] - u[0] == pytest.approx(stretch, rel=1e-12)
    assert mass[:, 0] @ u == pytest.approx(0.5 * steps * dt, rel=1e-12)
    assert end.internal == pytest.approx(0.5 * stiffness * stretch**2, rel=1e-12)
    assert end.hourglass == 0.25 * end.internal


def test_mass_of_a_body():
    points = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [0.0, 1.0], [1.0, 1.0], [2.0, 1.0]])
    cells = [[0, 1, 4, 3], [1, 2, 5, 4]]
    material = ref.Material(E=1.0, nu=0.3, density=4.0, hypothesis="plane_strain")
    mass = ref.lumped_mass(points, cells, "quadrilateral", material)
    assert np.allclose(mass[:, 0], [1.0, 2.0, 1.0, 1.0, 2.0, 1.0])
    assert np.array_equal(mass[:, 0], mass[:, 1])
