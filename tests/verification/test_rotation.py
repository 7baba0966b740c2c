# SPDX-License-Identifier: MIT
"""Finite-strain laws do not notice a rotation: by a quarter turn there is neither force nor energy."""

import numpy as np
import pytest
import ufl
from meshes_and_supports import block
from dolfinx import fem

from dolfinx_impact import LinearElastic, NeoHookean, StVenantKirchhoff
from dolfinx_impact.assembly import operators

# Round-off of F: entries of size 1 with errors of 1e-16 times the sum over a gradient's nodes.
FORCE, ENERGY = 1e-13, 1e-14


def turned(cell, degree, kind, hypothesis, extra=0.0):
    """(force, energy) of a block of E = 1 turned by a right angle about z, then stretched in x by `extra`."""
    domain = block(cell, 2)
    dim = domain.geometry.dim
    R = np.eye(dim)
    R[:2, :2] = [[0.0, -1.0], [1.0, 0.0]]
    R = np.diag([1 + extra] + [1.0] * (dim - 1)) @ R
    V = fem.functionspace(domain, ("Lagrange", degree, (dim,)))
    u = fem.Function(V, name="u")
    u.interpolate(lambda x: (R - np.eye(dim)) @ x[:dim])
    material = kind(1.0, 0.3, hypothesis=hypothesis)
    force = operators.InternalForce(operators.internal_force_form(u, ufl.TestFunction(V), material)).apply().array
    return np.abs(force).max(), operators.Energy(operators.strain_energy_form(u, material)).value()


@pytest.mark.parametrize("kind", [NeoHookean, StVenantKirchhoff])
@pytest.mark.parametrize(
    "cell, degree, hypothesis",
    [
        ("triangle", 1, "plane_strain"),
        ("quadrilateral", 1, "plane_stress"),
        ("tetrahedron", 2, "3d"),
        ("hexahedron", 1, "3d"),
    ],
)
def test_a_quarter_turn_costs_nothing(kind, cell, degree, hypothesis):
    force, energy = turned(cell, degree, kind, hypothesis)
    assert force < FORCE and abs(energy) < ENERGY


@pytest.mark.parametrize("kind", [NeoHookean, StVenantKirchhoff])
def test_a_small_stretch_after_the_turn_does(kind):
    """What the test above would see: a stretch of one thousandth."""
    force, energy = turned("hexahedron", 1, kind, "3d", 1e-3)
    assert force > 1e-5 and energy > 1e-7


def test_small_strain_elasticity_takes_the_turn_for_strain():
    force, energy = turned("triangle", 1, LinearElastic, "plane_strain")
    assert force > 0.1 and energy > 0.1
