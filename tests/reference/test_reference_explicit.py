# SPDX-License-Identifier: MIT
"""The explicit loop of the hand-written solver, without contact: recurrences, limits, dispersion, invariants."""

import impact_reference as ir
import numpy as np
import pytest
from reference_meshes import box, dofs, nodes_where

LAWS = ["linear_elastic", "st_venant_kirchhoff", "neo_hookean"]


def bar(cells=16, length=1.0, height=10.0, nu=0.0, **law):
    """One row of quadrilaterals with E = density = c = 1; no motion along y."""
    law = ir.Material(1.0, nu, 1.0, "plane_strain", **law)
    points, c = box("quadrilateral", (cells, 1), mapping=lambda x: x * [length, height])
    model = ir.Model(points, c, "quadrilateral", law)
    return model, 2 * np.arange(len(points)) + 1


def body(law="linear_elastic", cell="triangle", **options):
    d = 2 if cell in ("triangle", "quadrilateral") else 3
    points, cells = box(cell, (3, 2, 2)[:d], distort=0.2)
    law = ir.Material(2.0, 0.3, 1.5, "plane_strain" if d == 2 else "3d", law=law)
    return ir.Model(points, cells, cell, law, **options)


def oscillator():
    """A model with one free dof: (model, the other dofs, the free one, omega)."""
    points, cells = box("quadrilateral", (1, 1))
    model = ir.Model(points, cells, "quadrilateral", ir.Material(3.0, 0.2, 2.0, "plane_strain"))
    free = 2 * int(nodes_where(points, lambda x: x.sum() == 2)[0])
    omega = np.sqrt(model.stiffness().diagonal()[free] / model.mass(lumped=True)[free])
    return model, np.delete(np.arange(model.num_dofs), free), free, omega


@pytest.mark.parametrize("xi, limit", [(0, 2), (0.05, 1.902498), (0.1, 1.809975), (0.2, 1.639608), (0.5, 1.236068)])
@pytest.mark.parametrize("scheme, damping", [("half_step", "alpha"), ("half_step", "beta"), ("classical", "alpha")])
def test_stability_limit_of_one_degree_of_freedom(xi, limit, scheme, damping):
    """T-1 of BENCHMARKS: one per cent on either side."""
    limit = 2.0 if scheme == "classical" else limit
    model, fixed, free, omega = oscillator()
    options = {damping: 2 * xi * omega if damping == "alpha" else 2 * xi / omega, "scheme": scheme}
    u0 = np.zeros(model.num_dofs)
    u0[free] = 1.0
    for factor in (0.99, 1.01):
        dt = factor * limit / omega
        run = model.run_explicit(dt, 1500, u0=u0, fixed_dofs=fixed, **options)
        grown = np.abs(run.u[-1, free])
        assert grown < 8 if factor < 1 else grown > 1e3
    step = model.stable_step("eigenvalue", fixed_dofs=fixed, **options)
    assert np.isclose(step * omega, limit, rtol=1e-6)


def test_scheme_that_does_not_fit_is_refused():
    model, fixed, free, omega = oscillator()
    with pytest.raises(ValueError, match="diagonal"):
        model.run_explicit(0.1, 2, scheme="classical", beta=0.1)
    with pytest.raises(ValueError, match="equal steps"):
        model.run_explicit([0.1, 0.2], scheme="classical")
    with pytest.raises(ValueError, match="scheme"):
        model.run_explicit(0.1, 2, scheme="trapezoid")
    with pytest.raises(ValueError, match="positive"):
        model.run_explicit([0.1, -0.2])
    with pytest.raises(RuntimeError, match="overflow"):
        model.run_explicit(100 / omega, 1000, v0=np.ones(8), fixed_dofs=fixed)


@pytest.mark.parametrize("scheme", ["half_step", "classical"])
@pytest.mark.parametrize(
    "cfl, speeds", [(0.5, (0.9951693, 0.9805418, 0.9202138)), (0.9, (0.9987642, 0.9948689, 0.9758916)), (1, (1, 1, 1))]
)
def test_dispersion_of_a_bar(scheme, cfl, speeds):
    """T-2: a mode of the mesh swings as cos(omega t), sin(omega dt / 2) = (c dt / h) sin(k h / 2)."""
    model, across = bar(16)
    h = 1 / 16
    x = model.field_points[:, 0]
    ends = dofs(nodes_where(model.field_points, lambda p: p[0] in (0, 1)), 0, 2)
    for m, speed in zip((2, 4, 8), speeds):
        omega = 2 / (cfl * h) * np.arcsin(cfl * np.sin(m * np.pi / 32))
        u0 = np.zeros(model.num_dofs)
        u0[::2] = np.sin(m * np.pi * x)
        run = model.run_explicit(cfl * h, 100, u0=u0, fixed_dofs=np.append(across, ends), scheme=scheme)
        # Round-off grows linearly at the limit of stability, where the highest mode has a double root.
        assert np.abs(run.u - np.cos(omega * run.time)[:, None] * u0).max() < 1e-10
        assert np.isclose(omega / (m * np.pi), speed, atol=2e-7)


def test_invariant_of_the_linear_scheme():
    """T-3: (1/2) v M v at half steps + (1/2) u_n K u_(n+1), and T + (1/2) u K u at time levels."""
    model = body()
    rng = np.random.default_rng(0)
    u0, v0 = 0.01 * rng.standard_normal((2, model.num_dofs))
    run = model.run_explicit(0.9 * model.stable_step("eigenvalue"), 500, u0=u0, v0=v0)
    M, K = model.mass(lumped=True), model.stiffness().toarray()
    invariant = np.sum(run.v_half[:-1] ** 2 * M, 1) / 2 + np.einsum("ni,ij,nj->n", run.u[:-1], K, run.u[1:]) / 2
    assert np.ptp(invariant) < 1e-12 * invariant[0]
    assert np.ptp(run.energies["total"]) < 1e-12 * run.energies["total"][0]
    assert np.abs(run.energies["drift"]).max() < 1e-12
    strain = [model.energy(u) for u in run.u[::100]]
    assert np.allclose(run.energies["internal"][::100], strain, rtol=1e-12, atol=0)


def everything(model, steps, rng):
    """Options with loads, prescribed motion and tables."""
    d = model.points.shape[1]
    n, end = model.num_dofs, steps.sum()
    fixed = dofs(nodes_where(model.field_points, lambda x: x[0] < 1e-9), range(d), d)
    directions = 0.02 * rng.standard_normal(fixed.size)
    u0 = 0.01 * rng.standard_normal(n)
    u0[fixed] = 0
    return dict(
        u0=u0,
        v0=0.01 * rng.standard_normal(n),
        fixed_dofs=fixed,
        values=lambda t: directions * np.sin(3 * t / end),
        loads=[
            0.01 * rng.standard_normal(n),
            (0.01 * rng.standard_normal(n), ([0, 0.3 * end, 2 * end], [0, 1, -1])),
            (0.01 * rng.standard_normal(n), lambda t: np.cos(5 * t / end)),
        ],
    )


@pytest.mark.parametrize("law", LAWS)
def test_loop_is_the_recurrence(law):
    """Variable steps, Rayleigh damping, loads, prescribed motion: (3.72)-(3.77) written once more in NumPy."""
    model, rng = body(law), np.random.default_rng(1)
    steps = 0.3 * model.stable_step() * rng.uniform(0.5, 1.0, 30)
    given = everything(model, steps, rng)
    alpha, beta = 0.3, 0.02
    run = model.run_explicit(steps, alpha=alpha, beta=beta, **given)
    M, fixed = model.mass(lumped=True), given["fixed_dofs"]
    t = np.concatenate([[0], np.cumsum(steps)])
    end = steps.sum()
    assert np.allclose(run.time, t)
    u, v = given["u0"], given["v0"]
    fa, (fb, _), (fc, _) = given["loads"]
    for n, dt in enumerate(steps):
        assert np.allclose(run.u[n], u, rtol=0, atol=1e-14)
        load = fa + np.interp(t[n], [0, 0.3 * end, 2 * end], [0, 1, -1]) * fb + np.cos(5 * t[n] / end) * fc
        damping = alpha * M * v + beta * (model.tangent(u) @ v)
        a = (load - model.internal_force(u) - damping) / M
        v = v + (dt / 2 if n == 0 else (steps[n - 1] + dt) / 2) * a
        v[fixed] = (given["values"](t[n + 1]) - u[fixed]) / dt
        u = u + dt * v
    assert np.allclose(run.u[-1], u, rtol=0, atol=1e-14)
    # Equilibrium of the whole body: supports, loads, inertia.
    balance = (M * run.a).reshape(len(t), -1, 2).sum(1)
    load = np.outer(np.ones(len(t)), fa) + np.outer(np.cos(5 * t / end), fc)
    load += np.outer(np.interp(t, [0, 0.3 * end, 2 * end], [0, 1, -1]), fb)
    damping = np.array([alpha * M * w for w in np.vstack([given["v0"], run.v_half[:-1]])])
    # Stiffness damping has no resultant: linear laws, and any law's tangent, do not feel translations.
    applied = (run.support + load - damping).reshape(len(t), -1, 2).sum(1)
    assert np.allclose(balance, applied, rtol=0, atol=1e-12 * np.abs(M * run.a).max())
    assert np.abs(np.delete(run.support, fixed, 1)).max() == 0


def test_both_schemes_are_the_same_without_damping():
    model, rng = body(), np.random.default_rng(2)
    steps = np.full(500, 0.9 * model.stable_step())
    given = everything(model, steps, rng)
    one, two = (model.run_explicit(steps, scheme=s, **given) for s in ("half_step", "classical"))
    for name in ("u", "v", "a", "support"):
        x, y = getattr(one, name), getattr(two, name)
        # Differences of displacements lose digits: round-off over dt, and over dt^2.
        assert np.abs(x - y).max() < (1e-11 if name in "uv" else 1e-9) * np.abs(x).max()
    for name in ir.explicit.ENERGIES[:-1]:
        assert np.allclose(one.energies[name], two.energies[name], rtol=0, atol=1e-10)


def test_classical_scheme_is_its_recurrence():
    """(3.68)-(3.71) with damping, in NumPy with u_(n-1)."""
    model, rng = body(), np.random.default_rng(3)
    dt, alpha = 0.5 * model.stable_step(), 0.4
    u0, v0 = 0.01 * rng.standard_normal((2, model.num_dofs))
    run = model.run_explicit(dt, 50, u0=u0, v0=v0, alpha=alpha, scheme="classical")
    M, K = model.mass(lumped=True), model.stiffness()
    C = alpha * M
    last, now = u0 - dt * v0 + dt**2 / 2 * (-C * v0 - K @ u0) / M, u0
    for n in range(50):
        assert np.allclose(run.u[n], now, rtol=0, atol=1e-13)
        following = (-(dt**2) * (K @ now) + dt / 2 * C * last + M * (2 * now - last)) / (M + dt / 2 * C)
        assert np.allclose(run.v[n], (following - last) / (2 * dt), rtol=0, atol=1e-12)
        last, now = now, following


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("scheme", ["half_step", "classical"])
def test_energies_add_up_to_round_off(law, scheme):
    """Equal steps, everything at once: the work of all forces is what the kinetic energy changes by."""
    model, rng = body(law), np.random.default_rng(4)
    steps = np.full(300, 0.4 * model.stable_step())
    damping = dict(alpha=0.3, beta=0.0 if scheme == "classical" else 0.02)
    given = everything(model, steps, rng)
    run = model.run_explicit(steps, viscosity=(0.06, 1.2), scheme=scheme, **damping, **given)
    assert np.abs(run.energies["drift"]).max() < 1e-12
    assert run.energies["damping"][-1] > 0 < run.energies["viscosity"][-1]
    assert np.abs(run.energies["external"]).max() > 0.1 * run.energies["kinetic"].max()
    if law != "linear_elastic":  # the work of the internal force against the strain energy: a trapezoidal rule
        strain = np.array([model.energy(u) - model.energy(run.u[0]) for u in run.u])
        assert np.allclose(run.energies["internal"], strain, rtol=0, atol=5e-3 * np.abs(strain).max())


def test_kept_states_are_those_of_the_whole_run():
    model, rng = body(), np.random.default_rng(5)
    v0 = rng.standard_normal(model.num_dofs)
    whole, part = (model.run_explicit(0.01, 25, v0=v0, every=k) for k in (1, 10))
    rows = [0, 10, 20, 25]
    assert np.array_equal(part.time, whole.time[rows]) and np.array_equal(part.u, whole.u[rows])
    assert np.array_equal(part.energies["total"], whole.energies["total"][rows])


def test_free_flight_and_momentum():
    """A finite-strain body that turns: linear and angular momentum stay to round-off."""
    model = body("st_venant_kirchhoff")
    x0 = model.field_points
    rng = np.random.default_rng(6)
    v0 = (np.array([[-1.0, 0.5]]) + 0.5 * x0[:, ::-1] * [-1, 1] + 0.1 * rng.standard_normal(x0.shape)).reshape(-1)
    run = model.run_explicit(0.5 * model.stable_step(), 500, v0=v0)
    M = model.mass(lumped=True)
    p = (M * run.v_half).reshape(len(run.time), -1, 2)
    x = x0 + run.u.reshape(p.shape)
    spin = np.sum(x[:, :, 0] * p[:, :, 1] - x[:, :, 1] * p[:, :, 0], 1)
    assert np.ptp(p.sum(1), axis=0).max() < 1e-12 * np.abs(p).sum(2).sum(1).max()
    assert np.ptp(spin) < 1e-12 * np.abs(spin).max()
