# SPDX-License-Identifier: MIT
"""Polar decomposition of the finite strain law with back stress, against that by singular values."""

import numpy as np
import pytest
import ufl

from dolfinx_impact.forms import plasticity as law


def values(expression):
    """Numbers of a 3 x 3 tensor of constants."""
    return np.array([[expression[i, j](()) for j in range(3)] for i in range(3)])


def gradients(planar):
    """Deformation gradients with det F = 1, turned by any angle, from equal stretches to stretches of 5."""
    rng = np.random.default_rng(1)
    for size in (0.0, 1e-9, 1e-3, 0.3, 1.6):
        A = size * rng.uniform(-1, 1, (3, 3))
        Q = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        if planar:
            angle = rng.uniform(-3, 3)
            A[2, :2] = A[:2, 2] = 0.0
            Q = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1.0]])
        V, N = np.linalg.eigh(A + A.T)
        F = np.sign(np.linalg.det(Q)) * Q @ N @ np.diag(np.exp(V / 2)) @ N.T
        yield F / np.cbrt(np.linalg.det(F))


def right_stretch(F):
    _, s, W = np.linalg.svd(F)
    return W.T @ np.diag(s) @ W


@pytest.mark.parametrize("F", gradients(False), ids=lambda F: f"{np.linalg.norm(F):.2f}")
def test_stretch_in_space(F):
    U = right_stretch(F)
    C = ufl.as_matrix((F.T @ F).tolist())
    bound = law.next_trace(C)(())
    assert bound >= np.trace(U) * (1 - 1e-14)
    x = bound
    for _ in range(20):  # a contraction by 1/9 at least
        before, x = x, law.next_trace(C, ufl.as_ufl(float(x)))(())
        assert abs(x - np.trace(U)) <= abs(before - np.trace(U)) / 5 + 1e-14 * np.trace(U)
    found, inverse = law.stretch(C, ufl.as_ufl(float(x)))
    # Round-off of products of stretches up to the fourth power, over their least sum.
    tolerance = 1e-14 * np.linalg.norm(U) ** 4
    assert np.abs(values(found) - U).max() < tolerance
    assert np.abs(values(inverse) - np.linalg.inv(U)).max() < tolerance


@pytest.mark.parametrize("F", gradients(True), ids=lambda F: f"{np.linalg.norm(F):.2f}")
def test_stretch_in_the_plane(F):
    U = right_stretch(F)
    assert np.abs(values(law.plane_stretch(ufl.as_matrix(F.tolist()))) - U).max() < 1e-14 * np.linalg.norm(U)


@pytest.mark.parametrize("size", [0.0, 1e-8, 1e-3, 0.0446, 0.0448, 0.3])
def test_mean_of_an_elastic_strain_that_keeps_the_volume(size):
    """To round-off on both sides of the deviator (0.0447) from which on the series is not taken."""
    A = np.random.default_rng(4).uniform(-1, 1, (3, 3))
    d = A + A.T - 2 * np.trace(A) / 3 * np.eye(3)
    d *= size / np.linalg.norm(d)
    x = law.unimodular_mean(ufl.as_matrix(d.tolist()))(())
    second, determinant = np.sum(d * d) / 2, np.linalg.det(d)
    assert abs(x**3 - second * x + determinant - 1) < 1e-15  # of terms of 1, each rounded by 1e-16
