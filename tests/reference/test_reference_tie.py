# SPDX-License-Identifier: MIT
"""Ties of the hand-written solver alone: linear fields pass, forces balance, momentum stays."""

import impact_reference
import numpy as np
import pytest


def blocks(master=2, slave=3):
    """Two unit squares on each other, the upper one with the slave."""
    points, cells, first = [], [], 0
    for y0, n in ((0.0, master), (1.0, slave)):
        x, y = np.meshgrid(np.linspace(0.0, 1.0, n + 1), y0 + np.linspace(0.0, 1.0, n + 1))
        points.append(np.column_stack([x.ravel(), y.ravel()]))
        i = first + (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
        cells.append(np.column_stack([i, i + 1, i + n + 2, i + n + 1]))
        first += len(points[-1])
    material = impact_reference.Material(1.0, 0.3, 1.0, "plane_strain", "linear_elastic")
    model = impact_reference.Model(np.vstack(points), np.vstack(cells), "quadrilateral", material)
    low = (master + 1) * master + np.arange(master + 1)  # upper row of the lower square
    high = (master + 1) ** 2 + np.arange(slave + 1)
    rows = [np.column_stack([row[:-1], row[1:]]) for row in (high, low)]
    return model, impact_reference.Tie(model, *rows)


def test_a_uniform_state_passes():
    """Plane strain with free sides; the tie holds the upper square along the joint."""
    model, tie = blocks()
    x = model.field_points
    field = x * np.array([-0.3 * 1.3, 1.0 - 0.3**2])
    ends = np.flatnonzero((x[:, 1] < 1e-9) | (x[:, 1] > 2.0 - 1e-9))
    fixed = np.append(2 * ends + 1, 0)  # and the first node along the joint
    found = tie.solve_static(fixed, field.ravel()[fixed])
    assert np.abs(found.u - field.ravel()).max() < 1e-12
    forces = found.force.reshape(-1, 2)
    assert np.abs(forces.sum(axis=0)).max() < 1e-13
    assert abs((x[:, 0] * forces[:, 1] - x[:, 1] * forces[:, 0]).sum()) < 1e-13
    assert found.multipliers[tie.nodes] == pytest.approx(np.tile([0.0, -1.0], (len(tie.nodes), 1)), abs=1e-11)


def test_momentum_stays():
    model, tie = blocks()
    x, mass = model.field_points, model.mass(lumped=True).reshape(-1, 2)
    v = np.column_stack([1.0 - x[:, 1], x[:, 0]])  # rigid: no step may change it but by rotation
    v[:, 0] += 0.1 * x[:, 0]
    found = tie.run_explicit(v.ravel(), 0.01, 50)
    moved = [(mass * (b.u - a.u).reshape(-1, 2)).sum(axis=0) / 0.01 for a, b in zip(found, found[1:])]
    assert np.abs(np.array(moved) - (mass * v).sum(axis=0)).max() < 1e-12
    assert max(np.abs(tie.conditions @ s.u).max() for s in found) < 1e-13
    assert max(np.abs(s.multipliers).max() for s in found) > 1e-3
    assert found[0].u == pytest.approx(0.01 * v.ravel(), abs=1e-3)
