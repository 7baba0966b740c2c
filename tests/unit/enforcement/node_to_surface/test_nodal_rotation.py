# SPDX-License-Identifier: MIT
"""A pair of bodies that turns rigidly while its nodes stick: no slip, no friction, no energy."""

import numpy as np
import pytest
from nodal_model import two_bodies

from dolfinx_impact import _cpp

CELLS = [("quadrilateral", 1), ("triangle", 2), ("hexahedron", 1), ("tetrahedron", 2)]
ANGLE = 1e-3  # per step [rad]
STEPS = 40
# Increments of finite rotations are rotations to first order: what is left per step is half of its angle squared.
LEFT = 0.5 * ANGLE


def turned(x, angle):
    """Displacements of a rotation about a point beside the bodies, in space about an oblique axis."""
    d = x - 0.3
    if x.shape[1] == 2:
        c, s = np.cos(angle), np.sin(angle)
        return d @ np.array([[c, s], [-s, c]]) - d
    a = np.array([2.0, -1.0, 2.0]) / 3.0
    cross = np.cross(a, d)
    return np.sin(angle) * cross + (1 - np.cos(angle)) * np.cross(a, cross)


def across(f, n):
    return np.linalg.norm(f - np.sum(f * n, axis=1)[:, None] * n, axis=1)


@pytest.mark.parametrize("cell,degree", CELLS)
def test_springs_turn_with_the_bodies(cell, degree):
    """The forces of penalty turn as they are: counted as slip, the rotation of the gap would give a friction of the
    normal force times the angle."""
    model = two_bodies(cell, degree, friction=10.0, penalty=1e4)
    zero = np.zeros_like(model.x)
    first = model.forces(zero, zero)
    nodes = model.contact.nodes
    stored = model.contact.energy()["stored"]
    assert stored > 0.0
    before = zero
    for step in range(1, STEPS + 1):
        u = turned(model.x, step * ANGLE)
        f = model.forces(u, u - before)
        before = u
    results = model.contact.results()
    normal = results["pressure"] * model.contact.areas
    turn = STEPS * ANGLE
    friction = across(f[nodes], results["normal"])
    assert np.all(friction <= LEFT * turn * normal.max())  # that of rotations counted as slip is turn * normal
    assert np.linalg.norm(f[nodes], axis=1) == pytest.approx(
        np.linalg.norm(first[nodes], axis=1), abs=LEFT * turn * normal.max()
    )
    assert model.contact.energy()["stored"] == pytest.approx(stored, rel=LEFT * turn)
    assert abs(model.contact.energy()["friction"]) < LEFT * turn * stored


@pytest.mark.parametrize("cell,degree", CELLS)
def test_nodes_between_layers_turn_with_the_bodies(cell, degree):
    """Kinematic contact at a distance, of layers between the surfaces: what turns rigidly sticks without a force."""
    layers = 0.05
    found = []
    for angle in (0.0, ANGLE):
        adjustment = _cpp.gap.GapAdjustment(offset=layers)
        model = two_bodies(cell, degree, kinematic=True, friction=10.0, gap=0.9 * layers, adjustment=adjustment)
        u = turned(model.x, angle)
        _, f = model.correct(u, u)
        found.append(across(f[model.contact.nodes], model.contact.results()["normal"]))
        normal = (model.contact.results()["pressure"] * model.contact.areas).max()
    # Counted as slip, the rotation would be stopped by a force of the layers times the angle over the overlap, a tenth
    # of the layers, in normal forces. On bent surfaces the sweeps have not ended: the same without a rotation.
    assert normal > 0.0 and np.abs(found[1] - found[0]).max() < 0.02 * (ANGLE / 0.1) * normal
