# SPDX-License-Identifier: MIT
"""Cells of the hand-written solver whose hourglass modes flow, against closed forms."""

import impact_reference as ref
import numpy as np
import pytest

E, NU, YIELD, SLOPE = 2.0, 0.3, 0.01, 0.05


def cube(strain="small", slope=SLOPE):
    X = (np.array(ref.reference_nodes("hexahedron", 1)) + 1) / 2
    law = ref.J2Parameters(E, NU, YIELD, slope)
    return X, ref.OnePointPlastic("hexahedron", X, law, slope, "3d", strain)


def bending(X):
    """u = z_1 z_3 along the first axis: strain z_3 along it."""
    u = np.zeros_like(X)
    u[:, 0] = (X[:, 0] - 0.5) * (X[:, 2] - 0.5)
    return u


def test_a_moment_is_elastic_then_the_full_plastic_one():
    X, cell = cube(slope=0.0)
    u = bending(X)
    small = cell.evaluate(1e-3 * u)
    assert isinstance(small, ref.FlowingCell)
    assert small.force @ u.ravel() == pytest.approx(1e-3 * E / (1 - NU**2) / 12, rel=1e-12)
    assert small.hourglass == pytest.approx(1e-6 * E / (1 - NU**2) / 24, rel=1e-12)
    large = cell.evaluate(u)
    # With the moment nu m of the other axis, von Mises' equivalent is Y/4.
    assert large.force @ u.ravel() == pytest.approx(YIELD / 4 / np.sqrt(1 - NU + NU**2), rel=1e-12)
    assert large.answer.history.plastic_strain[0] == 0.0


def test_a_twist_ends_at_a_sixteenth():
    X, cell = cube(slope=0.0)
    u = np.zeros_like(X)
    u[:, 0] = np.prod(X - 0.5, axis=1)
    assert cell.evaluate(1e-3 * u).force @ u.ravel() == pytest.approx(1e-3 * E / 144, rel=1e-12)
    assert cell.evaluate(u).force @ u.ravel() == pytest.approx(YIELD / 16, rel=1e-12)


def test_unloading_is_elastic_and_hardening_goes_on():
    X, cell = cube()
    u = bending(X)
    loaded = cell.evaluate(u)
    cell.commit(loaded)
    first, second = (cell.evaluate(f * u).force @ u.ravel() for f in (1.0, 1.0 - 1e-4))
    assert (first - second) / 1e-4 == pytest.approx(E / (1 - NU**2) / 12, rel=1e-9)
    further = cell.evaluate(2.0 * u).force @ u.ravel() - first
    H, stiff = SLOPE / E, E / (1 - NU**2) / 12
    assert further == pytest.approx(stiff * H / (1 + H), rel=1e-9)


def test_bending_along_the_flow_has_no_moment():
    """While the mean flows, faces do, too, if the bending of a step is twice the mean's strain at most."""
    X, cell = cube(slope=0.0)
    stretch = (X - 0.5) * np.array([1.0, -0.5, -0.5])
    cell.commit(cell.evaluate(0.05 * stretch))  # flows
    u = bending(X)
    u[:, 1] = -0.5 * (X[:, 1] - 0.5) * (X[:, 2] - 0.5)  # in the ratio of the flow
    part = cell.evaluate(0.06 * stretch + 0.019 * u)
    assert abs(part.force @ u.ravel()) < 1e-6 * YIELD
    beyond = cell.evaluate(0.06 * stretch + 0.1 * u)
    assert beyond.force @ u.ravel() > 0.1 * YIELD


def test_a_rotation_turns_forces():
    X, cell = cube("simo")
    turn, _ = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))
    turn[:, 0] *= np.sign(np.linalg.det(turn))
    bend = 0.03 * np.random.default_rng(1).uniform(-1, 1, X.shape)
    own = cell.evaluate(bend).force.reshape(-1, 3)
    turned = cell.evaluate((X + bend) @ turn.T - X).force.reshape(-1, 3)
    np.testing.assert_allclose(turned, own @ turn.T, atol=1e-13)


def test_a_body_moves_on():
    X, _ = cube()
    material = ref.Material(E, NU, 1.0, "3d", "linear_elastic")
    velocity = 0.1 * bending(X)
    run = ref.run_one_point_plastic(
        X, np.arange(8)[None], "hexahedron", material, ref.J2Parameters(E, NU, YIELD, SLOPE), SLOPE, "small", velocity,
        0.05, 10,
    )  # fmt: skip
    assert isinstance(run, ref.FlowingRun)
    assert np.abs(run.displacement).max() > 0.0 and 0.0 < run.hourglass <= run.internal
    assert run.plastic_strain.shape == (1,)
