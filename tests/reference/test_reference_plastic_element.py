# SPDX-License-Identifier: MIT
"""Cells with J2 plasticity: tangents, patches, mean dilatation, rotation."""

import impact_reference as ir
import numpy as np
import pytest
from plastic_laws import EYE, E, G, K, NU, Y0, law, norm, random_rotations
from test_reference_finite_strain import CASES as CELLS
from test_reference_finite_strain import rates

STRAINS = ["small", "simo", "hencky"]
CASES = [
    (cell, degree, geometry, hypothesis, strain, mean)
    for cell, degree, geometry, hypothesis in CELLS
    for strain in STRAINS
    for mean in (False, True, "linear")
    if hypothesis != "plane_stress" or not mean
    if mean != "linear" or (degree == 2 and cell in ("quadrilateral", "hexahedron"))
]
ELASTIC = ir.J2Parameters(E, NU, 1e12)


def element(cell, degree, geometry, hypothesis, size=4 * Y0 / E, seed=7):
    """One distorted cell, displacements with strains of about `size` and a direction."""
    random = np.random.default_rng(seed)
    X = ir.reference_nodes(cell, geometry)
    X = X + random.uniform(-0.1, 0.1, X.shape) / geometry + (1.7 if hypothesis == "axisymmetric" else 0)
    nodes = ir.reference_nodes(cell, degree)
    u = size * (nodes @ random.uniform(-1, 1, (nodes.shape[1],) * 2) + random.uniform(-0.3, 0.3, nodes.shape))
    return X, u.reshape(-1), size * random.uniform(-1, 1, u.size)


def law_of(strain):
    return law("voce" if strain == "simo" else "armstrong")


@pytest.mark.parametrize("cell, degree, geometry, hypothesis, strain, mean", CASES)
def test_tangent_is_the_derivative_of_the_force(cell, degree, geometry, hypothesis, strain, mean):
    """At points that yield, after a history; remainders of order 2."""
    X, u, du = element(cell, degree, geometry, hypothesis)
    keys = dict(hypothesis=hypothesis, strain=strain, mean_dilatation=mean, degree=degree, geometry_degree=geometry)
    parameters = law_of(strain)
    before = ir.element_plastic(cell, X, parameters, 0.7 * u, **keys).history
    answer = ir.element_plastic(cell, X, parameters, u, before, **keys)
    assert np.all(answer.history.plastic_strain > before.plastic_strain)

    def remainder(h):
        there = ir.element_plastic(cell, X, parameters, u + h * du, before, **keys, with_tangent=False).force
        return np.linalg.norm(there - answer.force - h * answer.tangent @ du)

    # steps that keep all points yielding; what is beyond order 2 is a tenth
    assert np.allclose(rates(remainder, [4e-3, 2e-3, 1e-3]), 2, atol=0.2)


@pytest.mark.parametrize("cell, degree, geometry, hypothesis, strain, mean", CASES)
def test_elastic_force_is_the_derivative_of_the_energy(cell, degree, geometry, hypothesis, strain, mean):
    """Below yield the strain that the law sees and the strain that the force works on belong together."""
    X, u, du = element(cell, degree, geometry, hypothesis, 0.02)
    keys = dict(hypothesis=hypothesis, strain=strain, mean_dilatation=mean, degree=degree, geometry_degree=geometry)
    answer = ir.element_plastic(cell, X, ELASTIC, u, **keys)
    assert np.abs(answer.tangent - answer.tangent.T).max() < 1e-12 * np.abs(answer.tangent).max()
    h = 1e-3
    plus, minus = (ir.element_plastic(cell, X, ELASTIC, u + s * h * du, **keys).energy for s in (1, -1))
    # central differences: steps of 2e-5 against strains of 2e-2, the third derivative adds a millionth
    assert np.isclose((plus - minus) / (2 * h), answer.force @ du, rtol=1e-5, atol=1e-8 * np.abs(answer.force).max())


@pytest.mark.parametrize("cell, degree, geometry, hypothesis", CELLS)
def test_small_strain_below_yield_is_hooke(cell, degree, geometry, hypothesis):
    """Against the elastic elements of this package, which are made of Voigt's matrices."""
    X, u, _ = element(cell, degree, geometry, hypothesis)
    material = ir.Material(E, NU, hypothesis=hypothesis)
    keys = dict(degree=degree, geometry_degree=geometry)
    answer = ir.element_plastic(cell, X, ELASTIC, u, hypothesis=hypothesis, **keys)
    stiffness = ir.element_stiffness(cell, X, material, **keys)
    assert np.abs(answer.tangent - stiffness).max() < 1e-12 * np.abs(stiffness).max()
    assert np.abs(answer.force - stiffness @ u).max() < 1e-11 * np.abs(answer.force).max()
    assert np.isclose(answer.energy, u @ stiffness @ u / 2, rtol=1e-12)


@pytest.mark.parametrize("strain", STRAINS)
@pytest.mark.parametrize("mean", [False, True])
@pytest.mark.parametrize("cell, degree, geometry, hypothesis", [c for c in CELLS if c[2] == 1 and c[3] == "3d"])
def test_homogeneous_deformation_is_that_of_a_point(cell, degree, geometry, hypothesis, strain, mean):
    """Two steps of u = H X in a distorted cell: the answer of a point, with and without mean dilatation."""
    X, _, _ = element(cell, degree, geometry, hypothesis)
    N, _ = ir.shape_functions(cell, geometry, ir.reference_nodes(cell, degree))
    parameters, point, history = law_of(strain), None, None
    point = ir.J2Point(parameters, 1, strain)
    for H in np.random.default_rng(3).uniform(-1, 1, (2, 3, 3)) * 0.01:
        keys = dict(strain=strain, mean_dilatation=mean, degree=degree, geometry_degree=geometry)
        answer = ir.element_plastic(cell, X, parameters, (N @ X) @ H.T, history, **keys)
        expected = point.evaluate((H + H.T) / 2 if strain == "small" else EYE + H)
        assert np.abs(answer.stress - expected.stress).max() < 1e-9 * Y0
        assert np.allclose(answer.history.plastic_strain, expected.history.plastic_strain, rtol=1e-9)
        point.commit(expected)
        history = answer.history
    assert point.history.plastic_strain[0] > 5e-3


@pytest.mark.parametrize("cell, hypothesis", [("quadrilateral", "plane_strain"), ("quadrilateral", "axisymmetric")])
@pytest.mark.parametrize("strain", STRAINS)
def test_mean_dilatation_in_the_plane(cell, hypothesis, strain):
    """One pressure in the whole cell, that of the change of its volume; it differs from point to point without."""
    X, u, _ = element(cell, 1, 1, hypothesis, 0.01)
    u *= 3
    keys = dict(hypothesis=hypothesis, strain=strain)
    parameters = ir.J2Parameters(E, NU, Y0)
    with_mean = ir.element_plastic(cell, X, parameters, u, mean_dilatation=True, **keys)
    without = ir.element_plastic(cell, X, parameters, u, **keys)
    assert np.all(with_mean.history.plastic_strain > 0)

    def pressures(answer):
        if strain == "small":
            return np.trace(answer.stress, axis1=1, axis2=2) / 3
        b_e = answer.history.plastic_strain_tensor  # det F^2 = det b_e / det C_p^-1
        assert np.allclose(np.linalg.det(b_e), 1, rtol=1e-12)
        return np.trace(answer.history.stress, axis1=1, axis2=2) / 3  # Kirchhoff's: a function of J alone

    assert np.ptp(pressures(with_mean)) < 1e-9 * Y0 < 1e-3 * np.ptp(pressures(without))
    # Change of volume by the points of the rule, as the mean is defined.
    points, weights = ir.quadrature(cell, "table:3")
    N, dN = ir.shape_functions(cell, 1, points)
    volume = change = 0.0
    for q in range(len(weights)):
        J = X.T @ dN[q]
        gradient = EYE * 0
        gradient[:2, :2] = u.reshape(-1, 2).T @ dN[q] @ np.linalg.inv(J)
        w = weights[q] * np.linalg.det(J)
        if hypothesis == "axisymmetric":
            radius = N[q] @ X[:, 0]
            gradient[2, 2] = N[q] @ u[::2] / radius
            w *= 2 * np.pi * radius
        volume += w
        change += w * (np.trace(gradient) if strain == "small" else np.linalg.det(EYE + gradient))
    theta = change / volume
    expected = {"small": K * theta, "simo": K / 2 * (theta**2 - 1), "hencky": K * np.log(theta)}[strain]
    assert np.allclose(pressures(with_mean), expected, rtol=1e-9)


@pytest.mark.parametrize("strain", STRAINS)
def test_mean_dilatation_of_a_hexahedron(strain):
    X, u, _ = element("hexahedron", 1, 1, "3d", 0.01)
    parameters = ir.J2Parameters(E, NU, Y0)
    answer = ir.element_plastic("hexahedron", X, parameters, u, strain=strain, mean_dilatation=True)
    pressure = np.trace(answer.stress if strain == "small" else answer.history.stress, axis1=1, axis2=2) / 3
    assert np.ptp(pressure) < 1e-9 * Y0 and np.all(answer.history.plastic_strain > 0)
    # Sabotage: the plain strain gives each point its own.
    plain = ir.element_plastic("hexahedron", X, parameters, u, strain=strain)
    other = np.trace(plain.stress if strain == "small" else plain.history.stress, axis1=1, axis2=2) / 3
    assert np.ptp(other) > 0.1 * Y0


@pytest.mark.parametrize("strain", ["simo", "hencky"])
@pytest.mark.parametrize("mean", [False, True])
def test_rotation_turns_the_force(strain, mean):
    """Two steps, the second with a rotation of 100 degrees and more."""
    X, u, du = element("hexahedron", 1, 1, "3d", 0.02)
    N, _ = ir.shape_functions("hexahedron", 1, ir.reference_nodes("hexahedron", 1))
    Q = random_rotations(np.random.default_rng(5))
    parameters = law_of(strain)
    keys = dict(strain=strain, mean_dilatation=mean)
    before = ir.element_plastic("hexahedron", X, parameters, u, **keys).history
    x = X + u.reshape(-1, 3) + du.reshape(-1, 3)
    one = ir.element_plastic("hexahedron", X, parameters, x - X, before, **keys)
    two = ir.element_plastic("hexahedron", X, parameters, x @ Q.T - X, before, **keys)
    size = np.abs(one.force).max()
    assert np.abs(two.force.reshape(-1, 3) - one.force.reshape(-1, 3) @ Q.T).max() < 1e-10 * size
    assert np.allclose(two.history.plastic_strain, one.history.plastic_strain, rtol=1e-9)
    # Small strain is not objective: it sees strains in a rotation.
    turned = ir.element_plastic("hexahedron", X, parameters, (X @ Q.T - X))
    assert norm(turned.stress).max() > G


def test_linear_dilatation_of_a_quadrilateral():
    """The mean stress of an elastic cell of degree 2 is the linear function that fits that of the points best."""
    X, u, _ = element("quadrilateral", 2, 1, "plane_strain", 0.02)
    points, weights = ir.quadrature("quadrilateral", "gauss_jacobi:4")
    keys = dict(hypothesis="plane_strain", degree=2, rule=(points, weights))
    p, q = (
        np.trace(ir.element_plastic("quadrilateral", X, ELASTIC, u, **keys, mean_dilatation=m).stress, axis1=1, axis2=2)
        for m in ("linear", False)
    )
    N, dN = ir.shape_functions("quadrilateral", 1, points)
    root = np.sqrt(weights * np.abs([np.linalg.det(X.T @ d) for d in dN]))
    basis = np.column_stack([np.ones(len(N)), N @ X])
    best = basis @ np.linalg.lstsq(root[:, None] * basis, root * q, rcond=None)[0]
    assert np.abs(p - best).max() < 1e-12 * np.abs(q).max() and np.abs(q - best).max() > 1e-3 * np.abs(q).max()


def test_refusals():
    X = ir.reference_nodes("quadrilateral", 1)
    keys = dict(hypothesis="plane_strain", rule="gauss_jacobi:1")
    with pytest.raises(ValueError, match="linear dilatation needs more points"):
        ir.element_plastic("quadrilateral", X, law("linear"), np.zeros(8), mean_dilatation="linear", **keys)
    with pytest.raises(ValueError, match="dilatation 'cubic' is unknown: use pointwise, mean or linear"):
        ir.element_plastic("quadrilateral", X, law("linear"), np.zeros(8), mean_dilatation="cubic", **keys)
    X = ir.reference_nodes("quadrilateral", 1)
    u, parameters = np.zeros(8), law("linear")
    for strain in STRAINS:
        with pytest.raises(ValueError, match="plane stress goes without mean dilatation"):
            keys = dict(hypothesis="plane_stress", mean_dilatation=True, strain=strain)
            ir.element_plastic("quadrilateral", X, parameters, u, **keys)
    with pytest.raises(ValueError, match="3 histories"):
        history = ir.J2History.virgin(3)
        ir.element_plastic("quadrilateral", X, parameters, u, history, hypothesis="plane_strain")
    with pytest.raises(ValueError, match="hypothesis does not go"):
        ir.element_plastic("quadrilateral", X, parameters, u)
    with pytest.raises(ValueError, match="8 finite displacements"):
        ir.element_plastic("quadrilateral", X, parameters, u[:6], hypothesis="plane_strain")
    with pytest.raises(ValueError, match="inside out"):
        keys = dict(hypothesis="plane_strain", strain="simo")
        ir.element_plastic("quadrilateral", X, parameters, X * [0, -2], **keys)
    history = ir.J2History.virgin(4, "simo")
    history.thickness[0] = 0.0
    with pytest.raises(ValueError, match="stretches across the plane that are positive"):
        keys = dict(hypothesis="plane_stress", strain="simo")
        ir.element_plastic("quadrilateral", X, parameters, u, history, **keys)
    history = ir.J2History.virgin(4)
    history.plastic_strain[0] = -1.0
    with pytest.raises(ValueError, match="not negative"):
        ir.element_plastic("quadrilateral", X, parameters, u, history, hypothesis="plane_strain")
