# SPDX-License-Identifier: MIT
"""Closed-form solutions: the hand-written solver is judged alone, not only against the generated kernels."""

import impact_reference as ir
import numpy as np
import pytest
from reference_meshes import box, dofs, edge_traction, facets_where, join, nodes_where
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import spsolve
from scipy.special import jv, jvp

E, NU = 200.0, 0.3


def sector(a, b):
    """Quarter ring: first direction radial, second circumferential."""
    return lambda x: (a + (b - a) * x[0]) * np.array([np.cos(np.pi / 2 * x[1]), np.sin(np.pi / 2 * x[1])])


def lame_cylinder(r, a, b, p, nu=NU):
    """Plane strain thick cylinder under inner pressure p (Timoshenko & Goodier art. 28): u_r, s_rr, s_tt."""
    A, B = p * a**2 / (b**2 - a**2), p * a**2 * b**2 / (b**2 - a**2)
    u = (1 + nu) / E * ((1 - 2 * nu) * A * r + B / r)
    return u, A - B / r**2, A + B / r**2


def order(errors):
    return np.log2(errors[-2] / errors[-1])


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
@pytest.mark.parametrize("degree", [1, 2])
def test_thick_cylinder_in_plane_strain(cell, degree):
    a, b, p, errors = 1.0, 2.0, 3.0, []
    material = ir.Material(E, NU, hypothesis="plane_strain")
    for n in (4, 8, 16):
        points, cells = box(cell, (n, n), degree, sector(a, b))
        model = ir.Model(points, cells, cell, material, geometry_degree=degree)
        inner = facets_where(points, cells, cell, lambda x: np.hypot(*x) < a + 1e-9)
        load, _ = model.follower_pressure(np.zeros(model.num_dofs), inner, p)
        fixed = [dofs(nodes_where(points, lambda x: x[k] < 1e-9), k, 2) for k in (0, 1)]
        u = model.solve_static(np.concatenate(fixed), 0.0, load).u.reshape(-1, 2)
        r = np.hypot(*points.T)
        exact = lame_cylinder(r, a, b, p)[0][:, None] * points / r[:, None]
        errors.append(np.abs(u - exact).max() / np.abs(exact).max())
    # order degree + 1 in the displacement, less a little before the asymptotic range
    assert order(errors) > degree + 0.7
    assert errors[-1] < (5e-3, 3e-5)[degree - 1]


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
@pytest.mark.parametrize("degree", [1, 2])
def test_thick_cylinder_axisymmetric(cell, degree):
    a, b, p, errors, stress_errors = 1.0, 2.0, 3.0, [], []
    material = ir.Material(E, NU, hypothesis="axisymmetric")
    for n in (4, 8, 16):
        points, cells = box(cell, (n, n // 2), degree, lambda x: np.array([a + (b - a) * x[0], 0.3 * x[1]]))
        model = ir.Model(points, cells, cell, material, geometry_degree=degree)
        inner = facets_where(points, cells, cell, lambda x: x[0] < a + 1e-9)
        ends = nodes_where(points, lambda x: x[1] < 1e-9 or x[1] > 0.3 - 1e-9)
        u, reactions = model.solve_static(dofs(ends, 1, 2), 0.0, model.traction(inner, [p, 0]))
        exact = lame_cylinder(points[:, 0], a, b, p)[0]
        errors.append(np.abs(u[0::2] - exact).max() / exact.max())
        stress, x = model.stress(u)
        _, s_rr, s_tt = lame_cylinder(x[..., 0], a, b, p)
        stress_errors.append(max(np.abs(stress[..., 0] - s_rr).max(), np.abs(stress[..., 2] - s_tt).max()) / s_tt.max())
        assert abs(reactions[1::2].sum()) < 1e-10  # the two ends pull alike
    assert order(errors) > degree + 0.7
    assert order(stress_errors) > degree - 0.3
    assert errors[-1] < (2e-3, 2e-5)[degree - 1]


def kirsch_stress(x, s=1.0, a=1.0):
    """Infinite plate, hole of radius a, tension s along x (Timoshenko & Goodier art. 35), as a 2 x 2 matrix."""
    r, t = np.hypot(*x), np.arctan2(x[1], x[0])
    q, c2, c4, s2, s4 = (a / r) ** 2, np.cos(2 * t), np.cos(4 * t), np.sin(2 * t), np.sin(4 * t)
    xx = s * (1 - q * (1.5 * c2 + c4) + 1.5 * q**2 * c4)
    yy = s * (-q * (0.5 * c2 - c4) - 1.5 * q**2 * c4)
    xy = s * (-q * (0.5 * s2 + s4) + 1.5 * q**2 * s4)
    return np.array([[xx, xy], [xy, yy]])


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
def test_kirsch_hole(cell):
    """Quarter of a plate cut out of the infinite one by a circle, with the exact tractions there."""
    material, errors = ir.Material(E, NU, hypothesis="plane_stress"), []
    for n in (12, 24):
        points, cells = box(cell, (n, n), 2, sector(1.0, 3.0))
        model = ir.Model(points, cells, cell, material, geometry_degree=2)
        outer = facets_where(points, cells, cell, lambda x: np.hypot(*x) > 3 - 1e-9)
        load = edge_traction(model, outer, kirsch_stress)
        fixed = [dofs(nodes_where(points, lambda x: x[k] < 1e-9), k, 2) for k in (0, 1)]
        u, _ = model.solve_static(np.concatenate(fixed), 0.0, load)
        stress, x = model.stress(u)
        exact = np.array([kirsch_stress(y)[[0, 1, 0], [0, 1, 1]] for y in x.reshape(-1, 2)]).reshape(stress.shape)
        errors.append(np.abs(stress - exact).max())
    # stress of quadratic elements: order 2; the peak is 3
    assert order(errors) > 1.5
    assert errors[-1] < 0.07
    # the concentration factor, from the points next to the crown of the hole
    near = np.argmin(np.hypot(x[..., 0], x[..., 1] - 1))
    assert np.isclose(stress.reshape(-1, 3)[near, 0], exact.reshape(-1, 3)[near, 0], rtol=0.02)
    assert exact.reshape(-1, 3)[near, 0] > 2.7


def test_the_sampled_kirsch_field_is_in_equilibrium():
    """The closed form used above: free hole, remote tension, factor 3."""
    assert np.allclose(kirsch_stress([0, 1.0]), [[3, 0], [0, 0]], atol=1e-12)
    assert np.allclose(kirsch_stress([1.0, 0]), [[0, 0], [0, -1]], atol=1e-12)
    assert np.allclose(kirsch_stress([1e5, 2e5]), [[1, 0], [0, 0]], atol=1e-9)


@pytest.mark.parametrize("cell, degree", [("quadrilateral", 2), ("triangle", 2), ("quadrilateral", 1)])
def test_cantilever_with_end_shear(cell, degree):
    """Timoshenko & Goodier art. 21: the exact displacement at the clamped end, parabolic shear at the other."""
    L, c, P = 8.0, 1.0, 1.0
    inertia = 2 * c**3 / 3
    shear = E / (2 * (1 + NU))
    material = ir.Material(E, NU, hypothesis="plane_stress")

    def exact(x, y):
        """Load P downwards at x = 0, fixed point at (L, 0)."""
        u = -P * x**2 * y / (2 * E * inertia) - NU * P * y**3 / (6 * E * inertia) + P * y**3 / (6 * inertia * shear)
        u = u + (P * L**2 / (2 * E * inertia) - P * c**2 / (2 * inertia * shear)) * y
        v = NU * P * x * y**2 / (2 * E * inertia) + P * x**3 / (6 * E * inertia)
        return u, v - P * L**2 * x / (2 * E * inertia) + P * L**3 / (3 * E * inertia)

    def stress(x):
        xy = -P * (c**2 - x[1] ** 2) / (2 * inertia)
        return np.array([[-P * x[0] * x[1] / inertia, xy], [xy, 0]])

    errors = []
    for n in (2, 4):
        points, cells = box(cell, (4 * n, n), degree, lambda x: np.array([L * x[0], c * (2 * x[1] - 1)]), distort=0.1)
        model = ir.Model(points, cells, cell, material, geometry_degree=degree)
        free_end = facets_where(points, cells, cell, lambda x: x[0] < 1e-9)
        load = edge_traction(model, free_end, stress)
        assert np.isclose(load[1::2].sum(), P, rtol=1e-12)  # v of the book points down with P
        clamped = nodes_where(points, lambda x: x[0] > L - 1e-9)
        values = np.column_stack(exact(*points[clamped].T)).reshape(-1)
        u, reactions = model.solve_static(dofs(clamped, (0, 1), 2), values, load)
        assert np.isclose(reactions[1::2].sum(), -P, rtol=1e-9)
        errors.append(np.abs(u - np.column_stack(exact(*points.T)).reshape(-1)).max() / (P * L**3 / (3 * E * inertia)))
    assert errors[1] < {(1, "quadrilateral"): 0.12, (2, "quadrilateral"): 2e-4, (2, "triangle"): 2e-3}[degree, cell]
    assert order(errors) > (1.4 if degree == 1 else 2.5)  # locking of bilinear cells delays their second order


def disc(radius, n, layers):
    """Disc of nine-node cells: a square core blended into four sectors."""
    core = 0.5 * radius / np.sqrt(2)

    def middle(x):
        return core * (2 * np.array(x) - 1)

    def quarter(k):
        turn = np.array([[0, -1], [1, 0]])

        def mapping(x):
            angle = np.pi / 2 * (x[1] - 0.5)
            inner = core * np.array([1, 2 * x[1] - 1])
            outer = radius * np.array([np.cos(angle), np.sin(angle)])
            return np.linalg.matrix_power(turn, k) @ (inner + x[0] * (outer - inner))

        return mapping

    parts = [box("quadrilateral", (n, n), 2, middle)]
    return join(*parts, *[box("quadrilateral", (layers, n), 2, quarter(k)) for k in range(4)])


def rotating_disc(spin, R, E, nu, rho, plane_strain=False):
    """BENCHMARKS R-1: (u(R) with the load at r, u(R) with the load at r + u)."""
    if plane_strain:
        E, nu = E / (1 - nu**2), nu / (1 - nu)
    k = np.sqrt(rho * spin**2 * (1 - nu**2) / E)
    C = (1 + nu) / (k * jvp(1, k * R) + nu * jv(1, k * R) / R)
    return (1 - nu) * rho * spin**2 * R**3 / (4 * E), C * jv(1, k * R) - R


def disc_growth(hypothesis, spin, n, R, modulus, rho):
    """Mean radial displacement of the rim without and with the matrix W."""
    points, cells = disc(R, n, n)
    material = ir.Material(modulus, NU, rho, hypothesis)
    model = ir.Model(points, cells, "quadrilateral", material, geometry_degree=2)
    rim = nodes_where(points, lambda x: np.hypot(*x) > R - 1e-9)
    centre = nodes_where(points, lambda x: np.hypot(*x) < 1e-9)
    right = rim[np.argmax(points[rim, 0])]
    fixed = np.concatenate([dofs(centre, (0, 1), 2), [2 * right + 1]])
    load = model.ale_load(spin, [0, 0])
    off, reactions = model.solve_static(fixed, 0.0, load)
    assert np.abs(reactions).max() < 1e-6 * np.abs(load).max()  # a self-balanced load: the supports carry rounding
    K, W = model.stiffness(), model.ale_inertia(spin, [0, 0])
    free = np.setdiff1d(np.arange(model.num_dofs), fixed)
    system = csr_matrix((K.data - W.data, K.indices, K.indptr))[free][:, free]
    on = np.zeros(model.num_dofs)
    on[free] = spsolve(system.tocsc(), load[free])
    outer = facets_where(points, cells, "quadrilateral", lambda x: np.hypot(*x) > R - 1e-9)
    normal, _ = model.follower_pressure(np.zeros(model.num_dofs), outer, -1.0)  # int N n ds
    return normal @ np.column_stack([off, on]) / (2 * np.pi * R)


@pytest.mark.parametrize(
    "hypothesis, spin, published, n, tolerance",
    [
        # the mean growth converges with order 4: 6e-6 with n = 8, 4e-7 with n = 16; W makes 8.9e-6 at the lowest speed
        ("plane_stress", 120 / 3.6 / 0.46, (3.370370, 3.370400), 16, 6e-7),
        ("plane_stress", 500.0, (160.4633, 160.5315), 8, 1e-5),
        ("plane_stress", 2000.0, (2567.413, 2584.969), 8, 1e-5),
        ("plane_strain", 2000.0, (1907.221, 1917.063), 8, 1e-5),
    ],
)
def test_rotating_disc(hypothesis, spin, published, n, tolerance):
    R, modulus, rho = 0.46, 207e9, 7800.0
    closed = np.array(rotating_disc(spin, R, modulus, NU, rho, hypothesis == "plane_strain"))
    assert np.allclose(closed * 1e6, published, rtol=3e-7)  # BENCHMARKS R-1 in micrometres, seven digits printed
    growth = disc_growth(hypothesis, spin, n, R, modulus, rho)
    assert np.abs(growth / closed - 1).max() < tolerance
    assert np.isclose(growth[1] / growth[0] - 1, closed[1] / closed[0] - 1, rtol=1e-3)  # what W adds


def test_frequencies_of_a_bar():
    """Two-node bars in disguise: linear cells with nu = 0 and u_y held have Hughes's discrete spectrum (ch. 9.1)."""
    n, L, rho = 20, 2.0, 8.0
    points, cells = box("quadrilateral", (n, 1), 1, lambda x: np.array([L * x[0], 0.1 * x[1]]))
    model = ir.Model(points, cells, "quadrilateral", ir.Material(E, 0.0, rho, "plane_stress"))
    held = dofs(np.arange(len(points)), 1, 2)
    h, c = L / n, np.sqrt(E / rho)
    kh = np.arange(6) * np.pi / n
    consistent = c / h * np.sqrt(6 * (1 - np.cos(kh)) / (2 + np.cos(kh)))
    lumped = c / h * np.sqrt(2 * (1 - np.cos(kh)))
    for expected, kind in ((consistent, False), (lumped, True)):
        omega, modes = model.frequencies(6, held, lumped=kind)
        assert omega[0] < 1e-4 * omega[1]  # free bar: one rigid mode, zero up to sqrt(rounding)
        assert np.allclose(omega[1:], expected[1:], rtol=1e-9)  # subspace tolerance
        M = np.diag(model.mass(lumped=True)) if kind else model.mass().toarray()
        assert np.allclose(modes.T @ M @ modes, np.eye(6), atol=1e-9)
        assert np.abs(modes[held]).max() == 0
    assert np.allclose(consistent[1:3], np.arange(1, 3) * np.pi * c / L, rtol=5e-3)  # and so the continuous one


def test_frequencies_of_beams():
    """Bernoulli: (beta L)^2 = 1.8751^2, 4.6941^2 clamped, 4.7300^2 free (Timoshenko, Young & Weaver)."""
    L, h, rho = 40.0, 1.0, 8.0
    points, cells = box("quadrilateral", (40, 1), 2, lambda x: np.array([L * x[0], h * x[1]]))
    model = ir.Model(points, cells, "quadrilateral", ir.Material(E, NU, rho, "plane_stress"), geometry_degree=2)
    unit = np.sqrt(E * h**2 / 12 / rho) / L**2
    clamped = dofs(nodes_where(points, lambda x: x[0] < 1e-9), (0, 1), 2)
    omega, _ = model.frequencies(2, clamped)
    # shear and rotary inertia lower the n-th mode by about (beta h)^2 / 12 * 4: 0.1 % and 0.5 %
    assert np.allclose(omega / unit, [1.8751041**2, 4.6940911**2], rtol=[2e-3, 8e-3])
    assert np.all(omega / unit < np.array([1.8751041, 4.6940911]) ** 2 * 1.001)
    omega, _ = model.frequencies(4)
    assert np.all(omega[:3] < 1e-3 * omega[3])
    assert np.isclose(omega[3] / unit, 4.7300407**2, rtol=8e-3)


def test_frequencies_against_a_dense_solver_and_rigid_modes_in_space():
    from scipy.linalg import eigh

    points, cells = box("tetrahedron", (3, 2, 2), 1, lambda x: np.array([3 * x[0], x[1], 0.8 * x[2]]), distort=0.1)
    model = ir.Model(points, cells, "tetrahedron", ir.Material(E, NU, 5.0), degree=2)
    omega, modes = model.frequencies(10)
    K, M = model.stiffness().toarray(), model.mass().toarray()
    exact = np.sqrt(np.abs(eigh(K, M, eigvals_only=True)[:10]))
    assert np.all(omega[:6] < 1e-3 * omega[6])
    assert np.allclose(omega[6:], exact[6:], rtol=1e-8)
    # the six lowest are the rigid motions
    rigid = model.rigid_modes()
    rest = rigid - modes[:, :6] @ (modes[:, :6].T @ M @ rigid)
    assert np.abs(rest).max() < 1e-6
    lumped, _ = model.frequencies(8, lumped=True)
    exact = np.sqrt(np.abs(eigh(K, np.diag(model.mass(lumped=True)), eigvals_only=True)[:8]))
    assert np.allclose(lumped[6:], exact[6:], rtol=1e-8)
