# SPDX-License-Identifier: MIT
"""Finite strain laws: derivatives, invariance, closed forms; follower pressure."""

import impact_reference as ir
import numpy as np
import pytest
from reference_meshes import box, boundary, dofs, nodes_where

PLANE = ["plane_strain", "plane_stress", "axisymmetric"]
LAWS = ["linear_elastic", "st_venant_kirchhoff", "neo_hookean"]
CASES = [
    (cell, degree, geometry, hypothesis)
    for cell in ["triangle", "quadrilateral", "tetrahedron", "hexahedron"]
    for degree, geometry in [(1, 1), (2, 1), (1, 2), (2, 2)]
    for hypothesis in (PLANE if cell in ("triangle", "quadrilateral") else ["3d"])
]


def element(cell, degree, geometry, hypothesis, seed=0):
    """One distorted cell and a displacement with strains of about 0.1."""
    random = np.random.default_rng(seed)
    X = ir.reference_nodes(cell, geometry)
    X = X + random.uniform(-0.05, 0.05, X.shape) + (1.5 if hypothesis == "axisymmetric" else 0)
    nodes = ir.reference_nodes(cell, degree)
    u = 0.1 * nodes @ random.uniform(-1, 1, (nodes.shape[1],) * 2) + random.uniform(-0.02, 0.02, nodes.shape)
    return X, u.reshape(-1), random.uniform(-1, 1, u.size)


def rates(remainder, steps):
    """Observed orders of a Taylor remainder."""
    values = [remainder(h) for h in steps]
    return np.log(np.array(values[:-1]) / values[1:]) / np.log(np.array(steps[:-1]) / steps[1:])


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("cell, degree, geometry, hypothesis", CASES)
def test_force_is_the_derivative_of_energy_and_tangent_of_force(cell, degree, geometry, hypothesis, law):
    material = ir.Material(10.0, 0.3, hypothesis=hypothesis, law=law)
    X, u, du = element(cell, degree, geometry, hypothesis)
    arguments = (degree, geometry)
    energy = ir.element_energy(cell, X, material, u, *arguments)
    force = ir.element_internal_force(cell, X, material, u, *arguments)
    K = ir.element_tangent(cell, X, material, u, *arguments)
    assert np.abs(K - K.T).max() < 1e-13 * np.abs(K).max()

    def of_energy(h):
        return abs(ir.element_energy(cell, X, material, u + h * du, *arguments) - energy - h * force @ du)

    def of_force(h):
        remainder = ir.element_internal_force(cell, X, material, u + h * du, *arguments) - force - h * K @ du
        return np.linalg.norm(remainder)

    steps = [4e-3, 2e-3, 1e-3]
    assert np.allclose(rates(of_energy, steps), 2, atol=0.2)  # quadratic remainder; the cubic term is at most a tenth
    if law == "linear_elastic":
        assert of_force(1e-2) < 1e-13 * np.linalg.norm(K @ du)
    else:
        assert np.allclose(rates(of_force, steps), 2, atol=0.2)


@pytest.mark.parametrize("law", LAWS[1:])
@pytest.mark.parametrize("cell, degree, geometry, hypothesis", [c for c in CASES if c[1] >= c[2]])
def test_rigid_motion_costs_nothing(cell, degree, geometry, hypothesis, law):
    material = ir.Material(10.0, 0.3, hypothesis=hypothesis, law=law)
    X, _, _ = element(cell, degree, geometry, hypothesis)
    N, _ = ir.shape_functions(cell, geometry, ir.reference_nodes(cell, degree))
    x = N @ X
    if hypothesis == "axisymmetric":
        u = np.tile([0, 3.0], (len(x), 1))
    else:
        angle = 2.2
        R = np.eye(x.shape[1])
        R[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        if len(R) == 3:
            R = R @ np.array([[1, 0, 0], [0, np.cos(0.7), -np.sin(0.7)], [0, np.sin(0.7), np.cos(0.7)]])
        u = x @ R.T - x + 5.0
    # stresses of rounding: modulus 10 times cancellation in F of 1e-15 times displacement 10
    assert np.abs(ir.element_internal_force(cell, X, material, u, degree, geometry)).max() < 1e-12
    assert abs(ir.element_energy(cell, X, material, u, degree, geometry)) < 1e-12
    tangent = ir.element_tangent(cell, X, material, u, degree, geometry)
    values = np.linalg.eigvalsh(tangent)
    assert np.sum(np.abs(values) < 1e-11 * values[-1]) == {"3d": 6, "axisymmetric": 1}.get(hypothesis, 3)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("cell, degree, geometry, hypothesis", CASES)
def test_tangent_at_rest_is_the_linear_stiffness(cell, degree, geometry, hypothesis, law):
    X, u, _ = element(cell, degree, geometry, hypothesis)
    material = ir.Material(10.0, 0.3, hypothesis=hypothesis, law=law)
    rule = "gauss_jacobi:4"
    K = ir.element_stiffness(cell, X, material, degree, geometry, rule)
    tangent = ir.element_tangent(cell, X, material, 0 * u, degree, geometry, rule)
    assert np.abs(K - tangent).max() < 1e-13 * np.abs(K).max()


F_SAMPLE = np.array([[1.15, 0.2, 0], [-0.1, 0.9, 0], [0, 0, 1]])


def test_plane_stress_neo_hookean_has_no_thickness_stress():
    """In-plane answer equals the solid law at the C33 that makes S33 vanish, found here by bisection."""
    plane = ir.Material(10.0, 0.35, hypothesis="plane_stress", law="neo_hookean")
    solid = ir.Material(10.0, 0.35, law="neo_hookean")

    def full(stretch):
        F = F_SAMPLE.copy()
        F[2, 2] = stretch
        return ir.second_piola(solid, F)

    low, high = 0.3, 3.0
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if full(middle)[0][2] < 0 else (low, middle)
    S, C, energy = full(middle)
    s, c, e = ir.second_piola(plane, F_SAMPLE)
    keep = [0, 1, 3]
    assert np.allclose(s, S[keep], atol=1e-13) and abs(e - energy) < 1e-14  # bisection to rounding
    assert np.allclose(c, C[np.ix_(keep, keep)] - np.outer(C[keep, 2], C[2, keep]) / C[2, 2], atol=1e-12)


def test_plane_strain_and_axisymmetric_are_the_solid_law():
    F = np.diag([1, 1, 1.2]) @ F_SAMPLE
    S, C, energy = ir.second_piola(ir.Material(10.0, 0.35, law="neo_hookean"), F)
    s, c, e = ir.second_piola(ir.Material(10.0, 0.35, hypothesis="axisymmetric", law="neo_hookean"), F)
    assert np.array_equal(s, S[:4]) and np.array_equal(c, C[:4, :4]) and e == energy
    s, c, e = ir.second_piola(ir.Material(10.0, 0.35, hypothesis="plane_strain", law="neo_hookean"), F_SAMPLE)
    S, C, energy = ir.second_piola(ir.Material(10.0, 0.35, law="neo_hookean"), F_SAMPLE)
    assert np.array_equal(s, S[[0, 1, 3]]) and e == energy


def test_textbook_stress():
    """S of both laws from their tensor formulas."""
    E, nu = 10.0, 0.3
    lam, mu = E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))
    F = np.array([[1.1, 0.2, 0.05], [-0.1, 0.95, 0.1], [0.02, -0.07, 1.05]])
    C = F.T @ F
    G = (C - np.eye(3)) / 2
    J, inverse = np.linalg.det(F), np.linalg.inv(C)
    expected = {
        "st_venant_kirchhoff": (
            lam * np.trace(G) * np.eye(3) + 2 * mu * G,
            lam / 2 * np.trace(G) ** 2 + mu * np.trace(G @ G),
        ),
        "neo_hookean": (
            mu * (np.eye(3) - inverse) + lam * np.log(J) * inverse,
            mu / 2 * (np.trace(C) - 3) - mu * np.log(J) + lam / 2 * np.log(J) ** 2,
        ),
    }
    for law, (stress, energy) in expected.items():
        S, _, e = ir.second_piola(ir.Material(E, nu, law=law), F)
        assert np.allclose(S, stress[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]], rtol=1e-12)
        assert np.isclose(e, energy, rtol=1e-12)


@pytest.mark.parametrize("law", LAWS[1:])
def test_tension_of_a_block(law):
    """Uniaxial tension: the axial 1st Piola stress of the stretched block against the scalar equations."""
    E, nu, stretch = 10.0, 0.3, 1.4
    points, cells = box("hexahedron", (2, 2, 2))
    model = ir.Model(points, cells, "hexahedron", ir.Material(E, nu, law=law))
    fixed, values = [], []
    for axis in range(3):
        nodes = nodes_where(points, lambda x: x[axis] < 1e-9)
        fixed.append(dofs(nodes, axis, 3))
        values.append(np.zeros(len(nodes)))
    pulled = dofs(nodes_where(points, lambda x: x[0] > 1 - 1e-9), 0, 3)
    fixed.append(pulled)
    values.append(np.full(len(pulled), stretch - 1))
    result = model.solve_static(np.concatenate(fixed), np.concatenate(values), steps=2)
    assert len(result.iterations) == 2 and max(result.iterations) < 10
    lam, mu = E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))
    if law == "st_venant_kirchhoff":
        force = stretch * E * (stretch**2 - 1) / 2
    else:
        low, high = 0.5, 1.5  # side stretch b with mu (b^2 - 1) + lambda ln(a b^2) = 0
        for _ in range(100):
            b = (low + high) / 2
            low, high = (b, high) if mu * (b * b - 1) + lam * np.log(stretch * b * b) < 0 else (low, b)
        force = stretch * (mu * (1 - stretch**-2) + lam * np.log(stretch * b * b) * stretch**-2)
    assert np.isclose(result.reactions[pulled].sum(), force, rtol=1e-9)  # Newton tolerance 1e-10


def test_newton_converges_quadratically_and_halves_failing_steps():
    points, cells = box("quadrilateral", (8, 2), 2, lambda x: np.array([4 * x[0], 0.4 * x[1]]))
    material = ir.Material(1000.0, 0.3, hypothesis="plane_strain", law="neo_hookean")
    model = ir.Model(points, cells, "quadrilateral", material, geometry_degree=2)
    fixed = dofs(nodes_where(points, lambda x: x[0] < 1e-9), (0, 1), 2)
    tip = nodes_where(points, lambda x: x[0] > 4 - 1e-9)
    load = np.zeros(model.num_dofs)
    load[2 * tip + 1] = 0.5 / len(tip)
    result = model.solve_static(fixed, 0.0, load, steps=1)
    assert result.u[2 * tip + 1].mean() > 1.0  # a large deflection
    residual = model.internal_force(result.u) - load
    assert np.abs(np.delete(residual, fixed)).max() < 1e-8
    assert np.allclose(result.reactions.reshape(-1, 2).sum(axis=0), [0, -0.5], atol=1e-7)
    assert max(result.residuals) < 1e-10 and sum(result.iterations) < 60
    with pytest.raises(RuntimeError, match="did not converge beyond"):
        model.solve_static(fixed, 0.0, load, max_iterations=1)


@pytest.mark.parametrize("cell, degree, geometry, hypothesis", CASES)
def test_follower_pressure(cell, degree, geometry, hypothesis):
    """Against - int p N J F^-T n0 dA0 with F taken from the cell, and its tangent by Taylor expansion."""
    X, u, du = element(cell, degree, geometry, hypothesis)
    p, solid, axisymmetric = 3.0, hypothesis == "3d", hypothesis == "axisymmetric"
    facet_type = ir.facet_type(cell)
    s, w = ir.quadrature(facet_type, "gauss_jacobi:8")
    for number, facet in enumerate(ir.facets(cell)):
        force, tangent = ir.element_follower_pressure(
            cell, X, u, number, p, hypothesis, degree, geometry, rule="gauss_jacobi:8"
        )
        corner = ir.reference_nodes(cell, 1)[facet]
        L, dL = ir.shape_functions(facet_type, 1, s)
        reference = L @ corner
        N, dN = ir.shape_functions(cell, degree, reference)
        G, dG = ir.shape_functions(cell, geometry, reference)
        expected = 0
        for q in range(len(w)):
            J = X.T @ dG[q]
            tangents = J @ (corner.T @ dL[q])
            if solid:
                area = np.cross(tangents[:, 0], tangents[:, 1])
            else:
                area = np.array([tangents[1, 0], -tangents[0, 0]])
            F = np.eye(len(J)) + u.reshape(N.shape[1], -1).T @ dN[q] @ np.linalg.inv(J)
            area = np.linalg.det(F) * np.linalg.inv(F).T @ area * w[q]
            if axisymmetric:
                area = area * 2 * np.pi * (G[q] @ X[:, 0] + N[q] @ u.reshape(-1, 2)[:, 0])
            expected = expected - p * np.outer(N[q], area)
        assert np.abs(force - expected.reshape(-1)).max() < 1e-12 * p * 10  # two routes of rounding
        local = ir.facet_nodes(cell, degree, number)
        arguments = (p, hypothesis, degree, geometry, "gauss_jacobi:8")
        assert np.array_equal(force, ir.element_follower_pressure(cell, X, u, local, *arguments)[0])

        def remainder(h):
            there = ir.element_follower_pressure(cell, X, u + h * du, number, *arguments)[0]
            return np.linalg.norm(there - force - h * tangent @ du)

        if solid or axisymmetric:
            assert np.allclose(rates(remainder, [4e-2, 2e-2, 1e-2]), 2, atol=0.2)
        else:
            assert remainder(1.0) < 1e-12 * 10  # linear in u in the plane


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral", "tetrahedron", "hexahedron"])
def test_pressure_on_a_closed_surface_is_self_balanced(cell):
    solid = cell in ("tetrahedron", "hexahedron")
    points, cells = box(cell, (2, 2, 2) if solid else (3, 2), distort=0.2)
    material = ir.Material(10.0, 0.3, hypothesis="3d" if solid else "plane_strain", law="neo_hookean")
    model = ir.Model(points, cells, cell, material, degree=2)
    u = np.random.default_rng(5).uniform(-0.03, 0.03, model.num_dofs)
    force, tangent = model.follower_pressure(u, boundary(cells, cell), 2.0)
    d = points.shape[1]
    # no resultant force and no resultant moment about the deformed positions
    moved = (model.field_points + u.reshape(-1, d)).reshape(-1, d)
    assert np.abs(force.reshape(-1, d).sum(axis=0)).max() < 1e-13
    x, f = np.pad(moved, ((0, 0), (0, 3 - d))), np.pad(force.reshape(-1, d), ((0, 0), (0, 3 - d)))
    assert np.abs(np.cross(x, f).sum(axis=0)).max() < 1e-12
    # the tangent of a closed surface is symmetric: the load is the gradient of p times the volume
    K = tangent.toarray()
    assert np.abs(K - K.T).max() < 1e-12
    # it also blows the body up: f . x = - d p V at u = 0
    force, _ = model.follower_pressure(0 * u, boundary(cells, cell), 2.0)
    assert np.isclose(force @ model.field_points.reshape(-1), -d * 2.0, rtol=1e-12)


@pytest.mark.parametrize("hypothesis", PLANE)
def test_inside_out_is_refused(hypothesis):
    """A mirrored cell has C = I and no stress, but it is not a deformation of a body."""
    material = ir.Material(10.0, 0.3, hypothesis=hypothesis, law="neo_hookean")
    X = ir.reference_nodes("triangle", 1) + [1, 0]
    for u in ([0, 0] - X, np.column_stack([0 * X[:, 0], -2 * X[:, 1]])):  # all nodes into one; mirrored at y = 0
        with pytest.raises(ValueError, match="inside out: det F"):
            ir.element_internal_force("triangle", X, material, u)
