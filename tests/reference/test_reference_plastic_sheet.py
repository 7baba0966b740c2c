# SPDX-License-Identifier: MIT
"""J2 plasticity of finite strain in plane stress at points: closed forms, the solid law, tangents, rotations."""

import impact_reference as ir
import numpy as np
import pytest
from plastic_laws import EYE, NU, Y0, E, K, law
from test_reference_plasticity import ELASTIC, FINITE_CASES, PLASTIC, orders

# The stiffness times round-off of the stretch across the sheet and of b_e, some 1e-15, over Y0: 3e5/250 1e-15.
ROUND = 1e-11


@pytest.fixture
def rng():
    return np.random.default_rng(14)


def gradients(rng, steps, points, size):
    """Random walks of deformation gradients of the plane, turned at random in every step."""
    walk = np.cumsum(rng.standard_normal((steps, points, 3, 3)) * size, axis=0) + EYE
    angle = rng.uniform(-np.pi, np.pi, (steps, points))
    R = np.zeros((steps, points, 3, 3))
    R[..., 0, 0] = R[..., 1, 1] = np.cos(angle)
    R[..., 1, 0], R[..., 0, 1] = np.sin(angle), -np.sin(angle)
    R[..., 2, 2] = 1
    walk[..., 2, :2] = walk[..., :2, 2] = 0
    walk[..., 2, 2] = 1
    return R @ walk, R


def sizes(name):
    """Increments of the random walks; what softens must not do so to nothing."""
    return Y0 / E if name == "softening" else 0.02


@pytest.mark.parametrize("strain, name", FINITE_CASES)
def test_a_sheet_is_a_solid_without_stress_across(strain, name, rng):
    """F_33 that is given is not read; the solid law at the F_33 that was found has the same stress, none across."""
    n = 60
    sheet = ir.J2Point(law(name), n, strain, "plane_stress")
    solid = ir.J2Point(law(name), n, strain)
    for F in gradients(rng, 6, n, sizes(name))[0]:
        solid.history = before = sheet.history
        answer = sheet.evaluate(F)
        assert np.abs(answer.stress[:, 2]).max() < ROUND * Y0
        other = F.copy()
        other[:, 2, 2] = 7.0
        assert np.array_equal(sheet.evaluate(other).stress, answer.stress)
        full = F.copy()
        full[:, 2, 2] = answer.history.thickness
        there = solid.evaluate(full)
        assert np.abs(there.stress - answer.stress).max() < ROUND * Y0
        assert np.array_equal(there.history.plastic_strain, answer.history.plastic_strain)
        assert np.array_equal(before.thickness, sheet.history.thickness), "a trial"
        sheet.commit(answer)
    assert np.ptp(sheet.history.thickness) > sizes(name)


@pytest.mark.parametrize("strain, name", FINITE_CASES)
def test_condensed_tangent(strain, name, rng):
    """Remainders of order 2 where points yield, after a history."""
    n, size = 60, sizes(name)
    sheet = ir.J2Point(law(name), n, strain, "plane_stress")
    path, _ = gradients(rng, 3, n, size)
    for F in path[:-1]:
        sheet.commit(sheet.evaluate(F))
    F = path[-1]
    direction = rng.standard_normal((n, 3, 3)) * size
    direction[:, 2] = direction[:, :, 2] = 0
    answer = sheet.evaluate(F)
    yields = answer.history.plastic_strain > sheet.history.plastic_strain
    found = orders(lambda x: sheet.evaluate(x).stress, answer.tangent, F, direction, [1e-2, 5e-3, 2.5e-3])
    assert yields.sum() > 15 and np.allclose(np.median(found[:, yields], axis=1), 2, atol=0.1)
    assert np.all(answer.tangent[:, 2, 2] == 0) and np.all(answer.tangent[:, :, :, 2, 2] == 0)


@pytest.mark.parametrize("strain, name", FINITE_CASES)
def test_a_sheet_that_turns(strain, name, rng):
    """Thickness, plastic strain and the stress turned back are the same in frames that turn."""
    n = 60
    still, turned = (ir.J2Point(law(name), n, strain, "plane_stress") for _ in range(2))
    for F, R in zip(*gradients(rng, 6, n, sizes(name))):
        one, two = still.evaluate(R.swapaxes(-1, -2) @ F), turned.evaluate(F)
        assert np.abs(R @ one.stress - two.stress).max() < 10 * ROUND * Y0  # six steps
        assert np.abs(one.history.thickness - two.history.thickness).max() < 1e-13
        assert np.abs(one.history.plastic_strain - two.history.plastic_strain).max() < 1e-13
        still.commit(one)
        turned.commit(two)


def test_hencky_sheet_in_tension():
    """Kirchhoff's stress over logarithmic strain is the small strain law, whatever the step; width as thickness."""
    sheet = ir.J2Point(law("linear"), strain="hencky", hypothesis="plane_stress")
    for e_p, total in ((0.4, 0.4), (0.9, 0.9), (0.2, 1.6)):
        tau = (Y0 + 5e3 * total) * (-1 if e_p == 0.2 else 1)
        logarithms = np.diag(tau / E * ELASTIC + e_p * PLASTIC)
        F = np.diag(np.exp([logarithms[0], logarithms[1], 0.0]))
        answer = sheet.evaluate(F)
        sheet.commit(answer)
        assert np.abs(answer.stress[0] @ F.T - np.diag([tau, 0, 0])).max() < 1e-9 * Y0  # as of the solid law
        assert np.isclose(answer.history.thickness[0], np.exp(logarithms[2]), rtol=1e-12)
    assert np.isclose(sheet.history.plastic_strain[0], 1.6, rtol=1e-9)


@pytest.mark.parametrize("scale", (0.05, 0.4))
def test_elastic_sheet_in_equal_tension(scale):
    """Simo's law below yield, stretched alike in both directions: K/2 (J^2 - 1) = G J^(-2/3) (s^2 - t^2)/3."""
    sheet = ir.J2Point(ir.J2Parameters(E, NU, 1e12), 1, "simo", "plane_stress")
    s = 1 + scale
    answer = sheet.evaluate(np.diag([s, s, 1.0]))
    t = answer.history.thickness[0]
    J, G = s * s * t, E / (2 * (1 + NU))
    left, right = K / 2 * (J**2 - 1), 2 * G / 3 * J ** (-2 / 3) * (s**2 - t**2)
    assert t < 1 and np.isclose(left, right, rtol=1e-11)
    assert np.isclose(answer.stress[0, 0, 0] * s, 1.5 * left, rtol=1e-11)  # tau = left + right/2
