# SPDX-License-Identifier: MIT
"""Stable steps and bulk viscosity of the hand-written solver against closed forms."""

import impact_reference as ir
import numpy as np
import pytest
from reference_meshes import CELLS, box, facets_where

NU = 0.3


# The six tetrahedra that T-6 of BENCHMARKS cuts a cube into.
SIX = [(0, 1, 3, 7), (0, 1, 7, 5), (0, 5, 7, 4), (1, 2, 3, 7), (1, 2, 7, 6), (1, 6, 7, 5)]


def cube(cell, n, **options):
    points, cells = box("hexahedron", (n, n, n))
    if cell == "tetrahedron":
        cells = cells[:, SIX].reshape(-1, 4)
    law = ir.Material(1.0, NU, 1.0, "3d")
    return ir.Model(points, cells, cell, law, **options)


def wave_speed(law):
    return np.sqrt(law.E * (1 - law.nu) / (law.density * (1 + law.nu) * (1 - 2 * law.nu)))


C = wave_speed(ir.Material(1.0, NU, 1.0, "3d"))


@pytest.mark.parametrize(
    "cell, n, method, rule, value",
    [
        ("hexahedron", 1, "element", None, 0.733799),
        ("hexahedron", 1, "eigenvalue", None, 0.733799),
        ("hexahedron", 6, "element", None, 0.733799),
        ("hexahedron", 6, "eigenvalue", None, 0.962431),
        ("hexahedron", 6, "eigenvalue", "table:1", 0.978489),
        ("tetrahedron", 5, "element", None, 0.385847),
        ("tetrahedron", 5, "eigenvalue", None, 0.531326),
    ],
)
def test_steps_of_cubes(cell, n, method, rule, value):
    """T-6 of BENCHMARKS: dt c_d / L with the edge L of the cube."""
    model = cube(cell, n)
    if rule is not None:  # of the stiffness only: one point would lump the mass differently
        model._rule = lambda purpose, whole=model._rule: (
            ir.quadrature(cell, rule) if purpose == "stiffness" else whole(purpose)
        )
    assert np.isclose(model.stable_step(method) * C * n, value, atol=1e-6)


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("degree", [1, 2])
def test_element_bound_is_below_the_limit_and_length_is_an_edge(cell, degree):
    d = 2 if cell in ("triangle", "quadrilateral") else 3
    points, cells = box(cell, (4, 3, 2)[:d], distort=0.2)
    law = ir.Material(2.0, NU, 3.0, "plane_strain" if d == 2 else "3d")
    model = ir.Model(points, cells, cell, law, degree=degree)
    element, true = model.stable_step(), model.stable_step("eigenvalue")
    assert 0.5 * true < element <= true * (1 + 1e-12)
    # Against the dense eigenvalues of NumPy.
    root = 1 / np.sqrt(model.mass(lumped=True))
    omega = np.sqrt(np.linalg.eigvalsh(root[:, None] * model.stiffness().toarray() * root)[-1])
    assert np.isclose(true * omega, 2, rtol=1e-10)
    edges = []
    for cell_nodes in model.cells:
        pairs = [(a, b) for f in ir.facets(cell) for a, b in zip(f, np.roll(f, -1))]
        edges += [np.linalg.norm(points[cell_nodes[a]] - points[cell_nodes[b]]) for a, b in pairs]
    assert np.isclose(model.stable_step("length"), min(edges) / degree / wave_speed(law))


def test_steps_of_several_materials_and_damping():
    points, cells = box("triangle", (4, 4))
    laws = {1: ir.Material(1.0, 0.3, 1.0, "plane_strain"), 2: ir.Material(9.0, 0.3, 1.0, "plane_strain")}
    tags = np.where(points[cells].mean(1)[:, 0] < 0.5, 1, 2)
    mixed = ir.Model(points, cells, "triangle", cell_tags=tags, materials=laws)
    soft = ir.Model(points, cells, "triangle", laws[1])
    for method in ("element", "length"):
        assert np.isclose(mixed.stable_step(method), soft.stable_step(method) / 3)
    omega, alpha, beta = 2 / mixed.stable_step(), 1.7, 0.004
    xi = (alpha / omega + beta * omega) / 2
    step = 2 / omega * (np.sqrt(1 + xi**2) - xi)
    assert np.isclose(mixed.stable_step(alpha=alpha, beta=beta), step)
    assert np.isclose(mixed.stable_step(alpha=alpha, scheme="classical"), 2 / omega)
    with pytest.raises(ValueError, match="unknown method"):
        mixed.stable_step("guess")


def viscous(model, v, b1=0.06, b2=1.2, u=None):
    u = np.zeros(model.num_dofs) if u is None else u
    rule = model._strain_rule()
    return ir._reference.viscous_force(model._model, *rule, u.reshape(-1), np.asarray(v).reshape(-1), b1, b2)


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("rate", [-0.7, 0.7])
def test_pressure_of_a_uniform_rate(cell, degree, rate):
    """A uniform rate along every axis: the force is that of the pressure on the surface; L is a leg or an edge."""
    d = 2 if cell in ("triangle", "quadrilateral") else 3
    n, law = 2, ir.Material(2.0, NU, 3.0, "plane_strain" if d == 2 else "3d")
    points, cells = box(cell, (n,) * d)
    model = ir.Model(points, cells, cell, law, degree=degree)
    e, size = d * rate, 1 / n
    q = 0.06 * law.density * wave_speed(law) * size * e + 1.44 * law.density * size**2 * abs(e) * min(0, e)
    total = np.zeros(model.num_dofs)
    for axis in range(d):
        for end, sign in ((0, -1), (1, 1)):
            facets = facets_where(points, cells, cell, lambda x: x[axis] == end)
            total += model.traction(facets, q * sign * np.eye(d)[axis])
    assert np.allclose(viscous(model, rate * model.field_points), total, rtol=0, atol=1e-12 * abs(q))
    assert viscous(model, rate * model.field_points) @ (rate * model.field_points).reshape(-1) > 0


def test_pressure_of_a_ring():
    """Axisymmetric: the hoop's rate counts, L does not know 2 pi r."""
    points, cells = box("quadrilateral", (2, 2), mapping=lambda x: x + [1, 0])
    law = ir.Material(2.0, NU, 3.0, "axisymmetric")
    model = ir.Model(points, cells, "quadrilateral", law)
    v = points * [0.5, 0.0]  # v_r / r = dv_r / dr = 0.5
    q = 0.06 * law.density * wave_speed(law) * 0.5
    power = viscous(model, v, b2=0.0) @ v.reshape(-1)
    assert np.isclose(power, q * 1.0 * np.pi * 3)


@pytest.mark.parametrize("law", ["linear_elastic", "st_venant_kirchhoff", "neo_hookean"])
def test_no_viscosity_in_rigid_motion(law):
    """Translations and turning; laws of finite strain also from a body that has turned by an angle."""
    for cell, d in (("triangle", 2), ("hexahedron", 3)):
        points, cells = box(cell, (2,) * d, distort=0.2)
        model = ir.Model(points, cells, cell, ir.Material(2.0, NU, 3.0, ["plane_strain", "3d"][d - 2], law))
        u = np.zeros_like(points)
        if law != "linear_elastic":
            c, s = np.cos(1.0), np.sin(1.0)
            turn = np.eye(d)
            turn[:2, :2] = [[c, -s], [s, c]]
            u = points @ turn.T - points
        spin = np.zeros((d, d))
        spin[0, 1], spin[1, 0] = -1, 1
        v = (points + u) @ spin.T + 1.0
        assert np.abs(viscous(model, v, u=u)).max() < 1e-13
        assert np.abs(viscous(model, points + u, u=u)).max() > 1e-2


def test_viscosity_takes_energy():
    points, cells = box("triangle", (3, 3), distort=0.2)
    model = ir.Model(points, cells, "triangle", ir.Material(2.0, NU, 3.0, "plane_strain"))
    v0 = np.random.default_rng(0).standard_normal(model.num_dofs)
    run = model.run_explicit(0.3 * model.stable_step(), 400, v0=v0, viscosity=(0.06, 1.2))
    lost = run.energies["viscosity"]
    # Lagging by half a step, the pressure may give a little back where its rate changes sign.
    assert lost[-1] > 0.05 * run.energies["kinetic"][0] and np.diff(lost).min() > -1e-3 * lost[-1]
    assert np.abs(run.energies["drift"]).max() < 1e-12
