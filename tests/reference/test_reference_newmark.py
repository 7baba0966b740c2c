# SPDX-License-Identifier: MIT
"""The implicit loop of the hand-written solver, without contact: closed forms, orders, invariants, masses."""

import impact_reference as ir
import numpy as np
import pytest
from reference_meshes import box, dofs, nodes_where

Scheme = ir.NewmarkScheme


def oscillator():
    """A model with one free dof: (model, the other dofs, the free one, omega, unit displacement)."""
    points, cells = box("quadrilateral", (1, 1))
    model = ir.Model(points, cells, "quadrilateral", ir.Material(3.0, 0.2, 2.0, "plane_strain"))
    free = 2 * int(nodes_where(points, lambda x: x.sum() == 2)[0])
    omega = np.sqrt(model.stiffness().diagonal()[free] / model.mass().diagonal()[free])
    return model, np.delete(np.arange(model.num_dofs), free), free, omega, np.eye(model.num_dofs)[free]


def body(law="linear_elastic", cell="triangle", **options):
    d = 2 if cell in ("triangle", "quadrilateral") else 3
    points, cells = box(cell, (3, 2, 2)[:d], distort=0.2)
    law = ir.Material(2.0, 0.3, 1.5, "plane_strain" if d == 2 else "3d", law=law)
    return ir.Model(points, cells, cell, law, **options)


@pytest.mark.parametrize("step, error", [(0.1, -8.32086e-4), (0.5, -2.00853e-2), (1.0, -7.27048e-2)])
def test_period_of_the_trapezoidal_rule(step, error):
    """T-4 of BENCHMARKS: tan(omega' h / 2) = omega h / 2; round-off of 200 steps."""
    model, fixed, free, omega, u0 = oscillator()
    run = model.run_newmark(step / omega, 200, u0=u0, fixed_dofs=fixed)
    slowed = 2 * np.arctan(step / 2) / step
    assert abs(slowed - 1 - error) < 1e-6
    assert np.abs(run.u[:, free] - np.cos(slowed * omega * run.time)).max() < 1e-11
    energy = run.energies["total"]
    assert np.ptp(energy) < 1e-12 * energy[0] and max(run.iterations) <= 2


def amplification(scheme, step):
    """Amplification matrix of (u, h v) of an oscillator with A = a, from two runs of one step."""
    model, fixed, free, omega, unit = oscillator()
    h, columns = step / omega, []
    for u0, v0 in ((unit, None), (np.zeros_like(unit), unit / h)):
        run = model.run_newmark(h, 1, scheme=scheme, u0=u0, v0=v0, fixed_dofs=fixed)
        columns.append([run.u[1, free], h * run.v[1, free]])
    return np.array(columns).T


@pytest.mark.parametrize("beta, gamma, radius", [(0.25, 0.5, 1.0), (0.3025, 0.6, 0.818182), (0.49, 0.9, 0.428571)])
def test_spectral_radius_of_newmark(beta, gamma, radius):
    """T-5, at omega h = 1e4, where the radius is that of infinity to 1e-3: the two roots coincide there, so that they
    differ by 1/(omega h) at least."""
    found = np.abs(np.linalg.eigvals(amplification(Scheme(beta, gamma), 1e4))).max()
    assert abs(found - radius) < 1e-3


def test_stability_limit_of_linear_acceleration():
    """T-5: beta = 1/6 is stable up to omega h = 3.464102."""
    for factor, stable in ((0.999, True), (1.001, False)):
        found = np.abs(np.linalg.eigvals(amplification(Scheme(1 / 6, 0.5), factor * 3.464102))).max()
        assert (found < 1 + 1e-9) == stable


@pytest.mark.parametrize("rho", (0.0, 0.5, 0.8, 1.0))
def test_spectral_radius_of_generalised_alpha(rho):
    """Amplitudes at omega h = 1e6 fall as n^2 rho^n: the three roots coincide there (Chung and Hulbert 1993), to the
    cube root of 1/(omega h)^2, 1e-4."""
    model, fixed, free, omega, u0 = oscillator()
    n = 3 if rho == 0.0 else 300
    run = model.run_newmark(1e6 / omega, 2 * n, scheme=Scheme.chung_hulbert(rho), u0=u0, fixed_dofs=fixed)
    sizes = np.abs(run.u[:, free])
    if rho == 0.0:
        assert sizes[n:].max() < 1e-3
    else:
        grown = sizes / rho ** np.arange(2 * n + 1)
        power = 0 if rho == 1.0 else 2
        assert abs(grown[2 * n] / grown[n] - 2**power) < 0.05 and grown[n] > 0.5


@pytest.mark.parametrize(
    "scheme, order",
    [
        (Scheme(), 2),
        (Scheme(0.3025, 0.6), 1),
        (Scheme.chung_hulbert(0.8), 2),
        (Scheme.chung_hulbert(0.0), 2),
        (Scheme.hht(-0.2), 2),
    ],
)
def test_order(scheme, order):
    """T-5: order 2 only for gamma = 1/2 - alpha_m + alpha_f; limits of a tenth, with steps of 1/40 and 1/80 omega."""
    model, fixed, free, omega, u0 = oscillator()
    errors = []
    for steps in (160, 320):
        run = model.run_newmark(4 / omega / steps, steps, scheme=scheme, u0=u0, fixed_dofs=fixed)
        errors.append(abs(run.u[-1, free] - np.cos(4)))
    assert abs(np.log2(errors[0] / errors[1]) - order) < 0.1


@pytest.mark.parametrize("factor", ("mass", "stiffness"))
def test_rayleigh_damping(factor):
    """Amplitude and period of a damped oscillator, of second order; the energy lost is the work of damping."""
    model, fixed, free, omega, u0 = oscillator()
    xi = 0.1
    damping = (2 * xi * omega, 0.0) if factor == "mass" else (0.0, 2 * xi / omega)
    errors = []
    for steps in (200, 400):
        run = model.run_newmark(6 / omega / steps, steps, u0=u0, fixed_dofs=fixed, damping=damping)
        t, w = omega * run.time, np.sqrt(1 - xi**2)
        exact = np.exp(-xi * t) * (np.cos(w * t) + xi / w * np.sin(w * t))
        errors.append(np.abs(run.u[:, free] - exact).max())
    assert errors[1] < 2e-4 and abs(np.log2(errors[0] / errors[1]) - 2) < 0.1
    assert np.ptp(run.energies["total"]) < 1e-12 * run.energies["total"][0] and run.energies["damping"][-1] > 0


@pytest.mark.parametrize("cell", ("triangle", "hexahedron"))
@pytest.mark.parametrize("lumping", ("consistent", "auto"))
def test_free_flight(cell, lumping):
    """A body that flies and spins keeps its momentum and its moment of momentum."""
    model = body("st_venant_kirchhoff", cell)
    x, d = model.field_points, model.field_points.shape[1]
    v = np.zeros_like(x)
    v[:, 0], v[:, -1] = 0.3 - 0.5 * x[:, -1], -0.2 + 0.5 * x[:, 0]
    run = model.run_newmark(0.02, 50, v0=v.ravel(), lumping=lumping)
    mass = model.mass() if lumping == "consistent" else ir.Csr(*diagonal(model.mass(lumped=True)))
    momenta = np.array([mass.dot(row).reshape(-1, d) for row in run.v])
    linear = momenta.sum(axis=1)
    assert np.abs(linear - linear[0]).max() < 1e-12 * np.abs(linear[0]).max()
    places = x + run.u.reshape(len(run.u), -1, d)
    moment = (places[..., 0] * momenta[..., -1] - places[..., -1] * momenta[..., 0]).sum(axis=1)
    # The trapezoidal rule keeps it to second order in the step: 1e-3 of it here.
    assert np.abs(moment - moment[0]).max() < 1e-3 * abs(moment[0])
    assert np.abs(run.u[-1].reshape(-1, d)).max() > 0.1


def diagonal(values):
    n = len(values)
    return np.arange(n + 1), np.arange(n), values


def test_static_limit():
    """Under a constant load, heavily damped, the body comes to the static solution."""
    model = body()
    fixed = dofs(nodes_where(model.field_points, lambda p: p[0] < 1e-9), (0, 1), 2)
    load = model.body_force([0.0, -0.05])
    u, reactions = model.solve_static(fixed, load=load)
    run = model.run_newmark(
        2.0, 200, fixed_dofs=fixed, loads=[load], damping=(0.5, 0.5), scheme=Scheme.chung_hulbert(0.5)
    )
    assert np.abs(run.u[-1] - u).max() < 1e-9 * np.abs(u).max()
    assert np.abs(run.support[-1] - reactions).max() < 1e-9 * np.abs(reactions).max()


def test_prescribed_motion_carries_a_body():
    """All nodes of one side follow a parabola; supports give the energy."""
    model = body()
    fixed = dofs(nodes_where(model.field_points, lambda p: p[0] < 1e-9), (0, 1), 2)
    t = 0.05 * np.arange(101)[:, None]
    shake = 0.1 * np.ones(fixed.size)
    run = model.run_newmark(0.05, 100, fixed_dofs=fixed, motion=(t**2 * shake, 2 * t * shake, 2 * shake + 0 * t))
    assert np.array_equal(run.u[:, fixed], t**2 * shake) and np.allclose(run.a[0, fixed], 0.2)
    energies = run.energies
    work = energies["external"][-1]
    assert work > 0 and abs(energies["total"][-1]) < 1e-10 * work
    # Mass times acceleration of all is what the supports exert.
    total = model.mass().dot(run.a[50]).reshape(-1, 2).sum(axis=0)
    assert np.allclose(run.support[50].reshape(-1, 2).sum(axis=0), total, rtol=1e-9)


def test_neo_hookean_energy_stays_near_its_start():
    """Large strain with generalised-alpha: energy is lost at most, by less than a tenth."""
    model = body("neo_hookean", "quadrilateral")
    v = np.zeros_like(model.field_points)
    v[:, 0] = 0.4 * model.field_points[:, 0]
    run = model.run_newmark(0.05, 100, v0=v.ravel(), scheme=Scheme.chung_hulbert(0.8))
    total = run.energies["total"]
    assert np.abs(run.u).max() > 0.2 and 0.9 * total[0] < total[-1] <= total.max() < 1.01 * total[0]


def test_plastic_body():
    """A body that yields: without yield it is the elastic one; with it, energy becomes plastic work."""
    model = body("linear_elastic", "quadrilateral")
    fixed = dofs(nodes_where(model.field_points, lambda p: p[0] < 1e-9), (0, 1), 2)
    v = np.zeros_like(model.field_points)
    v[:, 0] = 0.1 * model.field_points[:, 0]
    options = {"v0": v.ravel(), "fixed_dofs": fixed, "scheme": Scheme.chung_hulbert(0.9)}
    elastic = model.run_newmark(0.05, 60, **options)
    hard = ir.PlasticBody(model, ir.J2Parameters(2.0, 0.3, 1e3)).run_newmark(0.05, 60, **options)
    assert np.abs(hard.u - elastic.u).max() < 1e-11 * np.abs(elastic.u).max()
    soft = ir.PlasticBody(model, ir.J2Parameters(2.0, 0.3, 0.03, hardening=0.1)).run_newmark(0.05, 60, **options)
    strain = soft.plastic_strain
    assert np.all(np.diff(strain, axis=0) >= 0) and strain[-1].max() > 0.01
    assert soft.energies["plastic"][-1] > 0.3 * soft.energies["kinetic"][0]
    energy = soft.energies["total"]
    assert np.abs(energy - energy[0]).max() < 0.02 * energy[0]


def test_redistributed_mass():
    """By hand on a triangle and by sums: nodes of the surface pass their mass on, none is lost."""
    model = body("linear_elastic", "triangle")
    surface = model.field_points[:, 1] < 1e-9
    for lumping in ("consistent", "auto"):
        mass = ir.newmark._reference.inertia_matrix(model._model, *model._rule("mass"), lumping, surface.tolist())
        mass = ir.Csr(*mass.arrays).toarray()
        rigid = np.tile([1.0, 0.0], len(model.field_points))
        full = model.mass().toarray()
        assert np.isclose(rigid @ mass @ rigid, rigid @ full @ rigid, rtol=1e-13)
        assert not np.any(mass[np.repeat(surface, 2)]) and np.allclose(mass, mass.T, rtol=0, atol=1e-15)
        assert np.linalg.eigvalsh(mass[np.repeat(~surface, 2)][:, np.repeat(~surface, 2)]).min() > 0
    points = np.array([[0.0, 0.0], [3.0, 0.0], [0.0, 4.0]])
    one = ir.Model(points, [[0, 1, 2]], "triangle", ir.Material(1.0, 0.3, 2.0, "plane_strain"))
    lumped = ir.newmark._reference.inertia_matrix(one._model, *one._rule("mass"), "auto", [True, False, False])
    w = np.array([1 / 9, 1 / 16]) / (1 / 9 + 1 / 16)
    assert np.allclose(ir.Csr(*lumped.arrays).toarray()[::2, ::2], np.diag([0, 4 + 4 * w[0], 4 + 4 * w[1]]))
    both = ir.newmark._reference.inertia_matrix(one._model, *one._rule("mass"), "consistent", [True, False, False])
    m = np.array([[2, 1, 1], [1, 2, 1], [1, 1, 2]]) * 12 / 12.0  # density times area over 12
    T = np.array([[w[0], w[1]], [1, 0], [0, 1]])
    assert np.allclose(ir.Csr(*both.arrays).toarray()[::2, ::2][1:, 1:], T.T @ m @ T)
    whole = ir.newmark._reference.inertia_matrix(one._model, *one._rule("mass"), "consistent", [True] * 3)
    assert np.allclose(ir.Csr(*whole.arrays).toarray()[::2, ::2], m)


def test_what_does_not_fit_is_refused():
    model, fixed, _, _, u0 = oscillator()
    with pytest.raises(ValueError, match="beta"):
        Scheme(beta=0.0)
    with pytest.raises(ValueError, match="positive"):
        model.run_newmark([0.1, -0.1])
    with pytest.raises(ValueError, match="steps"):
        model.run_newmark([0.1, 0.1], 3)
    with pytest.raises(ValueError, match="damping"):
        model.run_newmark(0.1, 2, damping=(-1.0, 0.0), u0=u0, fixed_dofs=fixed)
    empty = ir.Model(model.points, model.cells, "quadrilateral", ir.Material(3.0, 0.2, 0.0, "plane_strain"))
    with pytest.raises(ValueError, match="density"):
        empty.run_newmark(0.1, 2, fixed_dofs=fixed)
    large = body("neo_hookean")
    with pytest.raises(ValueError, match="inside out"):
        large.run_newmark(5.0, 3, v0=np.random.default_rng(1).uniform(-5, 5, large.num_dofs))
