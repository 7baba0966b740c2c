# SPDX-License-Identifier: MIT
"""Laws in UFL at one displacement gradient: stresses are derivatives of energies, Cauchy's stress is symmetric."""

import itertools

import basix.ufl
import numpy as np
import pytest
import ufl
from ufl.algorithms import expand_derivatives
from ufl.algorithms.apply_algebra_lowering import apply_algebra_lowering

from dolfinx_impact.forms.materials import HYPOTHESES, LAWS, Law, plane_stress_lambda

POINT = (0.7, 0.4, 0.2)  # where all is evaluated: the gradients are the same everywhere but the hoop's
E, NU = 10.0, 0.3
# Newton's steps of a neo-Hookean sheet are written out, and UFL's own evaluation shares no parts: it would take
# minutes. Its kernels are compared in tests/unit/materials.
CASES = [c for c in itertools.product(LAWS, HYPOTHESES) if c != ("neo_hookean", "plane_stress")]


def linear(hypothesis, gradient):
    """Displacement with a gradient, as an expression of the place."""
    dim = 3 if hypothesis == "3d" else 2
    domain = ufl.Mesh(basix.ufl.element("Lagrange", "tetrahedron" if dim == 3 else "triangle", 1, shape=(dim,)))
    return ufl.dot(ufl.as_matrix(gradient[:dim, :dim].tolist()), ufl.SpatialCoordinate(domain))


def value(expression):
    """Array of the values of an expression."""
    e = expand_derivatives(apply_algebra_lowering(ufl.as_ufl(expression)))
    at = [float(e[i](POINT)) if i else float(e(POINT)) for i in np.ndindex(e.ufl_shape)]
    return np.reshape(at, e.ufl_shape)


def test_the_table_of_laws_is_that_of_the_classes():
    assert set(LAWS.values()) == set(Law.__subclasses__()) and all(law.name == name for name, law in LAWS.items())


@pytest.mark.parametrize("name, hypothesis", CASES)
def test_stress_and_tangent_are_derivatives(name, hypothesis, rng):
    law, h = LAWS[name](E, NU, hypothesis), 1e-5
    A, B = rng.uniform(-0.1, 0.1, (2, 3, 3))
    u, du = linear(hypothesis, A), linear(hypothesis, B)
    ends = [linear(hypothesis, A + s * h * B) for s in (1, -1)]
    energies = [float(value(law.energy_density(w))) for w in ends]
    power = np.sum(value(law.stress(u)) * value(law.gradient(du)))
    # Central differences: round-off 1e-16/h, and the next term h^2.
    assert power == pytest.approx((energies[0] - energies[1]) / (2 * h), rel=1e-7, abs=1e-9)
    stresses = [value(law.stress(w)) for w in ends]
    found = value(law.stress_derivative(u, du))
    np.testing.assert_allclose(found, (stresses[0] - stresses[1]) / (2 * h), atol=1e-8)


@pytest.mark.parametrize("name, hypothesis", CASES)
def test_cauchy_stress_of_a_stretch_that_is_turned(name, hypothesis, rng):
    """Symmetric; of finite strain it turns with the body, and is the force per present area."""
    law = LAWS[name](E, NU, hypothesis)
    A = 0.1 * rng.uniform(-1, 1, (3, 3))
    sigma = value(law.cauchy_stress(linear(hypothesis, A)))
    assert sigma.shape == (3, 3)
    np.testing.assert_allclose(sigma, sigma.T, atol=1e-13)
    if hypothesis == "plane_stress":
        assert not sigma[2].any() and not sigma[:, 2].any()
    if not law.linear and hypothesis != "axisymmetric":  # there a turn in the plane is none of the body
        c, s = np.cos(0.6), np.sin(0.6)
        R = np.array([(c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)])
        turned = value(law.cauchy_stress(linear(hypothesis, R @ (np.eye(3) + A) - np.eye(3))))
        np.testing.assert_allclose(turned, R @ sigma @ R.T, atol=1e-12)


@pytest.mark.parametrize("name", [name for name, hypothesis in CASES if hypothesis == "plane_stress"])
def test_small_stretch_of_a_sheet(name):
    """Uniaxial: sigma = E strain, across it -nu, to the square of the strain."""
    law, strain = LAWS[name](E, NU, "plane_stress"), 1e-6
    sigma = value(law.cauchy_stress(linear("plane_stress", np.diag([strain, -NU * strain, 0.0]))))
    assert sigma[0, 0] == pytest.approx(E * strain, rel=1e-5) and abs(sigma[1, 1]) < 1e-5 * E * strain
    assert law.lmbda_plane == plane_stress_lambda(law.lmbda, law.mu) == pytest.approx(E * NU / (1 - NU**2), rel=1e-14)
    if not law.linear:
        u = linear("plane_stress", np.diag([strain, -NU * strain, 0.0]))
        assert float(value(law.thickness_stretch(u))) == pytest.approx(1 - NU * strain, abs=1e-11)


def test_the_base_knows_no_law():
    law = Law(E, NU)
    for method in (law.energy_density, law.stress, law.thickness_stretch):
        with pytest.raises(NotImplementedError):
            method(None)
    with pytest.raises(NotImplementedError):
        law.stress_derivative(None, None)
