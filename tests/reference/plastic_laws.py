# SPDX-License-Identifier: MIT
"""Laws, random strain paths and the equations of J2 plasticity, for the tests of the hand-written solver."""

import impact_reference as ir
import numpy as np

E, NU, Y0 = 210e3, 0.3, 250.0
G, K = E / (2 * (1 + NU)), E / (3 * (1 - 2 * NU))
EYE = np.eye(3)

TABLE = [[0.0, 0.002, 0.01, 0.05], [250.0, 300.0, 340.0, 360.0]]
ISOTROPIC = {
    "perfect": dict(yield_stress=Y0),
    "linear": dict(yield_stress=Y0, hardening=5e3),
    "voce": dict(yield_stress=Y0, hardening=500.0, saturation_stress=400.0, saturation_rate=60.0),
    "table": dict(table=TABLE),
    "softening": dict(yield_stress=Y0, hardening=-300.0),
}
KINEMATIC = {
    "prager": dict(yield_stress=Y0, kinematic=2e4),
    "armstrong": dict(yield_stress=Y0, kinematic=4e4, recall=200.0),
    "both": dict(table=TABLE, kinematic=4e4, recall=200.0),
}
LAWS = ISOTROPIC | KINEMATIC


def law(name):
    return ir.J2Parameters(E, NU, **LAWS[name])


def dev(a):
    return a - np.trace(a, axis1=-2, axis2=-1)[..., None, None] / 3 * EYE


def norm(a):
    return np.sqrt(np.sum(a * a, axis=(-2, -1)))


def inner(a, b):
    return np.sum(a * b, axis=(-2, -1))


def mises(a):
    return np.sqrt(1.5) * norm(dev(a))


def random_strains(rng, steps, points, size=4 * Y0 / E):
    """Strains of random walks, symmetric, shape (steps, points, 3, 3)."""
    walk = rng.standard_normal((steps, points, 3, 3)) * size
    return np.cumsum(walk + walk.swapaxes(-1, -2), axis=0) / 2


def random_rotations(rng, *shape):
    q, r = np.linalg.qr(rng.standard_normal((*shape, 3, 3)))
    q = q * np.sign(np.diagonal(r, axis1=-2, axis2=-1))[..., None, :]
    return q * np.linalg.det(q)[..., None, None]  # -q is a rotation where q is not, in three dimensions


def residuals(parameters, keys, strain, before, answer):
    """Largest violation of each equation of backward Euler in small strain, over stress or strain at yield.

    Args:
        parameters: the law; keys: what it was made of.
        strain: at the end of the step; before: history at its start; answer: of the solver.
    """
    C, gamma = keys.get("kinematic", 0.0), keys.get("recall", 0.0)
    after = answer.history
    flow = after.plastic_strain_tensor - before.plastic_strain_tensor
    da = after.plastic_strain - before.plastic_strain
    elastic = strain - after.plastic_strain_tensor
    hooke = K * np.trace(elastic, axis1=-2, axis2=-1)[:, None, None] * EYE + 2 * G * dev(elastic)
    xi = dev(answer.stress) - after.back_stress
    f = np.sqrt(1.5) * norm(xi) - parameters.yield_stress(after.plastic_strain)
    back = after.back_stress - before.back_stress - 2 / 3 * C * flow + gamma * da[:, None, None] * after.back_stress
    n = xi / np.maximum(norm(xi), 1e-300)[:, None, None]
    bad = {
        "hooke": norm(answer.stress - hooke) / Y0,
        "admissible": np.maximum(f, 0) / Y0,
        "loading": np.maximum(-da, 0) * E / Y0,
        "complementary": np.where(da > 0, np.abs(f), 0) / Y0,
        "flow": norm(flow - np.sqrt(1.5) * da[:, None, None] * n) * E / Y0,
        "equivalent": np.abs(da - np.sqrt(2 / 3) * norm(flow)) * E / Y0,
        "back stress": norm(back) / Y0,
    }
    return {name: values.max() for name, values in bad.items()}
