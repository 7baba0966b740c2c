# SPDX-License-Identifier: MIT
"""The explicit integrator against what is known of central differences; T-1 to T-7 of the benchmarks."""

import math

import explicit_checks
import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from explicit_checks import shaken
from mpi4py import MPI
from on_ranks import rank_tests

import dolfinx_impact as di

test_one_rank, test_several_ranks = rank_tests(explicit_checks, ranks=(2, 3, 4), timeout=300)
COMM = MPI.COMM_SELF


def square(n=1, length=1.0, height=1.0, rows=1):
    """Displacement space on a strip of squares of degree 1."""
    kind = mesh.CellType.quadrilateral
    domain = mesh.create_rectangle(COMM, [[0.0, 0.0], [length, height]], [n, rows], kind)
    return fem.functionspace(domain, ("Lagrange", 1, (2,)))


def oscillator(alpha=0.0, scheme="half_step"):
    """One degree of freedom: a square of which one corner may move along x; angular frequency 1.37."""
    V = square()
    u, v = fem.Function(V), fem.Function(V)
    x = V.tabulate_dof_coordinates()
    free = int(np.flatnonzero((x[:, 0] > 0.5) & (x[:, 1] > 0.5))[0])
    v.x.array[2 * free] = 1.0
    bcs = []
    for c in range(2):
        W, _ = V.sub(c).collapse()
        places = fem.locate_dofs_geometrical((V.sub(c), W), lambda x: (x[0] < 0.5) | (x[1] < 0.5) | (c == 1))
        bcs.append(fem.dirichletbc(fem.Function(W), places, V.sub(c)))
    steel = di.LinearElastic(1.0, 0.0, 1.0, "plane_strain")
    damping = di.Rayleigh(alpha, 0.0) if alpha else None
    return di.ExplicitProblem(u, steel, velocity=v, bcs=bcs, damping=damping, scheme=scheme), 2 * free


@pytest.mark.parametrize("scheme", ("half_step", "classical"))
@pytest.mark.parametrize("xi", (0.0, 0.05, 0.1, 0.2, 0.5))
@pytest.mark.filterwarnings("ignore:dt =")
def test_stability_limit_of_one_degree_of_freedom(scheme, xi):
    """T-1: steps of 99 % of the limit run on, steps of 101 % do not; lagged damping lowers the limit, seed (3.78)."""
    problem, _ = oscillator()
    omega = 2.0 / problem.stable_step("eigenvalue")
    problem, free = oscillator(2 * xi * omega, scheme)
    limit = 2.0 / omega * (1.0 if scheme == "classical" else math.sqrt(1 + xi**2) - xi)
    assert problem.stable_step("eigenvalue") == pytest.approx(limit, rel=1e-12)
    # Lagged damping so near the limit lets the energy go up and down by a fifth.
    problem.advance(2000 * 0.99 * limit, dt=0.99 * limit, progress=False, unsafe=True, energy_limits=None)
    assert abs(problem.u.x.array[free]) < 10.0 / omega
    problem, _ = oscillator(2 * xi * omega, scheme)
    with pytest.raises(RuntimeError, match="went unstable"):
        problem.advance(2000 * 1.01 * limit, dt=1.01 * limit, progress=False, unsafe=True)


def test_an_unsafe_step_is_refused_unless_asked_for():
    problem, _ = oscillator()
    dt = 1.01 * problem.stable_step()
    with pytest.raises(ValueError, match="beyond the stable step"):
        problem.advance(1.0, dt=dt)
    with pytest.warns(UserWarning, match="beyond the stable step"):
        problem.advance(3 * dt, dt=dt, progress=False, unsafe=True)


def bar(n=64, cfl=0.5, mode=8, **arguments):
    """Standing wave on a bar of squares with E = rho = 1, nu = 0, sides on rollers; problem, step, wave number."""
    V = square(n, length=float(n), height=1.0)
    u, v = fem.Function(V), fem.Function(V)
    k = math.pi * mode / n
    u.interpolate(lambda x: np.array([np.cos(k * x[0]), 0.0 * x[0]]))
    problem = di.ExplicitProblem(u, di.LinearElastic(1.0, 0.0, 1.0, "plane_strain"), velocity=v, **arguments)
    return problem, cfl, k


@pytest.mark.parametrize("cfl", (0.5, 0.9))
@pytest.mark.parametrize("mode", (8, 16, 32))
def test_dispersion(cfl, mode):
    """T-2: sin(omega dt/2) = (c dt/h) sin(k h/2); the mode stays itself, so that u_n = cos(n omega dt) u_0."""
    problem, dt, k = bar(cfl=cfl, mode=mode)
    start = problem.u.x.array.copy()
    omega = 2.0 / dt * math.asin(dt * math.sin(k / 2))
    problem.advance(200 * dt, dt=dt, progress=False)
    assert problem.step == 200
    # Round-off of 200 steps.
    np.testing.assert_allclose(problem.u.x.array, math.cos(200 * omega * dt) * start, rtol=0, atol=1e-11)


def test_invariant_and_energies():
    """T-3: kinetic and internal energy as defined are constant to round-off, at every step."""
    problem = shaken(COMM)
    history = problem.energy_history
    assert history.shape == (1000, 10) and np.all(np.diff(history[:, 0]) > 0)
    total = history[:, 1:-1].sum(axis=1) - history[:, -1]
    assert np.abs(total - total[0]).max() < 1e-12 * total[0]
    assert abs(problem.energy["drift"]) < 1e-12
    assert np.ptp(history[:, 1]) > 0.1 * total[0], "energy goes to and fro"


def test_both_schemes_are_the_same_without_damping():
    one, other = shaken(COMM, scheme="half_step"), shaken(COMM, scheme="classical")
    np.testing.assert_allclose(one.u.x.array, other.u.x.array, rtol=0, atol=1e-13 * np.abs(one.u.x.array).max())


def test_a_residual_of_your_own_is_the_same_motion():
    one, other = shaken(COMM, law=di.NeoHookean), shaken(COMM, law=di.NeoHookean, residual=True)
    np.testing.assert_allclose(other.u.x.array, one.u.x.array, rtol=0, atol=1e-12 * np.abs(one.u.x.array).max())
    assert other.energy["internal"] == pytest.approx(one.energy["internal"], rel=1e-9)


@pytest.mark.parametrize("damping", (di.Rayleigh(2.0, 0.0), di.Rayleigh(0.0, 2e-4), di.Rayleigh(1.0, 1e-4)))
def test_damping_takes_what_is_lost(damping):
    problem = shaken(COMM, damping=damping)
    assert problem.energy["damping"] > 0.2 * problem.energy["total"]
    assert abs(problem.energy["drift"]) < 1e-12


def test_order_of_accuracy():
    """Halving the step divides the error by four."""
    ends = []
    for dt in (0.02, 0.01, 0.005, 0.0025):
        problem, free = oscillator(alpha=0.3, scheme="classical")
        problem.advance(2.0, dt=dt, progress=False)
        ends.append(problem.u.x.array[free])
    ratios = np.diff(ends)[:-1] / np.diff(ends)[1:]
    assert np.all(np.abs(ratios - 4.0) < 0.05)


def test_viscosity_damps_compression_and_leaves_rigid_motion_alone():
    problem = shaken(COMM, bulk_viscosity=(0.06, 1.2))
    assert problem.energy["viscosity"] > 0.01 * problem.energy["total"] and abs(problem.energy["drift"]) < 1e-12
    V = explicit_checks.box(COMM)
    v = fem.Function(V)
    v.interpolate(lambda x: np.array([1.0 - x[1], 2.0 + x[0], 0.0 * x[0]]))  # at one time level rotation is no strain
    free = di.ExplicitProblem(
        fem.Function(V), di.LinearElastic(1e3, 0.3, 1.0), velocity=v, bulk_viscosity=(0.06, 1.2)
    )  # fmt: skip
    assert np.abs(free.acceleration.x.array).max() < 1e-10


def cube(cell, n):
    domain = mesh.create_unit_cube(COMM, n, n, n, getattr(mesh.CellType, cell))
    V = fem.functionspace(domain, ("Lagrange", 1, (3,)))
    steel = di.LinearElastic(1.0, 0.3, 1.0)
    return di.ExplicitProblem(fem.Function(V), steel, velocity=fem.Function(V)), steel.wave_speed * n


def test_stable_steps_of_cubes():
    """T-6: in units of the cells' edge and the wave speed; one cube, and the assembled system of 6 x 6 x 6."""
    problem, unit = cube("hexahedron", 1)
    assert problem.stable_step() * unit == pytest.approx(0.733799, rel=2e-6)
    problem, unit = cube("hexahedron", 6)
    assert problem.stable_step("eigenvalue") * unit == pytest.approx(0.962431, rel=2e-6)
    assert problem.stable_step("length") * unit == pytest.approx(1.0, rel=1e-12)


def test_stable_step_of_a_tetrahedron():
    """A sixth of a cube, its stiffness from the constant gradients of its functions."""
    problem, unit = cube("tetrahedron", 1)
    X = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0]])
    G = np.linalg.inv(np.hstack([np.ones((4, 1)), X]))[1:]
    lmbda, mu, volume = 0.3 / (1.3 * 0.4), 0.5 / 1.3, 1.0 / 6.0
    K = lmbda * np.einsum("ia,jb->aibj", G, G) + mu * np.einsum("ja,ib->aibj", G, G)
    K = volume * (K + mu * np.einsum("ij,ka,kb->aibj", np.eye(3), G, G)).reshape(12, 12)
    expected = 2.0 / np.sqrt(np.linalg.eigvalsh(K / (volume / 4))[-1])
    assert problem.stable_step() == pytest.approx(expected, rel=1e-9)
    assert problem.stable_step("length") * unit == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize("cell", ("triangle", "quadrilateral", "tetrahedron", "hexahedron"))
@pytest.mark.parametrize("degree", (1, 2))
@pytest.mark.filterwarnings("ignore:dt =")
def test_element_bound_is_safe_on_distorted_meshes(cell, degree):
    """Never more than the true limit, and of its size; the true limit is one: 99 % run, 101 % do not."""
    plane = cell in ("triangle", "quadrilateral")
    kind = getattr(mesh.CellType, cell)
    domain = mesh.create_unit_square(COMM, 5, 5, kind) if plane else mesh.create_unit_cube(COMM, 3, 3, 3, kind)
    x, dim = domain.geometry.x, 2 if plane else 3
    random = np.random.default_rng(4)
    x[:, :dim] += random.uniform(-0.05, 0.05, (len(x), dim))
    V = fem.functionspace(domain, ("Lagrange", degree, (dim,)))
    steel = di.LinearElastic(1.0, 0.3, 1.0, "plane_strain" if plane else "3d")

    def problem():
        v = fem.Function(V)
        v.x.array[:] = np.random.default_rng(1).uniform(-1e-3, 1e-3, len(v.x.array))
        return di.ExplicitProblem(fem.Function(V), steel, velocity=v)

    p = problem()
    limit = p.stable_step("eigenvalue")
    assert 0.5 * limit < p.stable_step() < limit
    p.advance(1000 * 0.99 * limit, dt=0.99 * limit, progress=False, unsafe=True)
    with pytest.raises(RuntimeError, match="unstable"):
        problem().advance(4000 * 1.01 * limit, dt=1.01 * limit, progress=False, unsafe=True)


def test_mass_scaling_reaches_its_step_and_tells_the_mass():
    V = square(8, length=4.0)
    V.mesh.geometry.x[np.isclose(V.mesh.geometry.x[:, 0], 0.5), 0] = 0.1  # a thin cell
    steel = di.LinearElastic(1.0, 0.3, 1.0, "plane_strain")
    plain = di.ExplicitProblem(fem.Function(V), steel, velocity=fem.Function(V))
    wanted = 2 * plain.stable_step()
    scaled = di.ExplicitProblem(fem.Function(V), steel, velocity=fem.Function(V), mass_scaling=wanted)
    assert scaled.stable_step() == pytest.approx(wanted, rel=1e-9)
    added = (scaled.mass.array.sum() - plain.mass.array.sum()) / 2
    assert scaled.added_mass == pytest.approx(added, rel=1e-12) and 0.0 < added < 4.0


def test_prescribed_motion_is_followed_and_its_work_counted():
    """A bar pulled at one end as sin^2: the end is where it should be, and energies add up."""
    V = square(20, length=20.0)
    right = fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[0], 20.0))
    pull = di.PrescribedMotion(fem.dirichletbc(np.array([0.1, 0.0]), right, V), lambda t: np.sin(0.2 * t) ** 2)
    u = fem.Function(V)
    problem = di.ExplicitProblem(
        u, di.LinearElastic(1.0, 0.0, 1.0, "plane_strain"), velocity=fem.Function(V), bcs=[pull]
    )  # fmt: skip
    seen = []
    problem.advance(12.0, callback=lambda p: seen.append((p.time, u.x.array[2 * right[0]])), progress=False)
    times, values = np.array(seen).T
    np.testing.assert_allclose(values, 0.1 * np.sin(0.2 * times) ** 2, rtol=0, atol=1e-15)
    assert problem.energy["external"] > 1e-4 and abs(problem.energy["drift"]) < 1e-3
    history = problem.energy_history
    total = history[:, 1:-1].sum(axis=1) - history[:, -1]
    assert np.ptp(total) < 1e-13


def test_a_spinning_flying_body_keeps_its_momentum():
    """Linear and angular momentum to 1e-12 over 100,000 steps, and no spurious strain; neo-Hookean."""
    domain = mesh.create_box(COMM, [[-1.0, -0.5, -0.5], [1.0, 0.5, 0.5]], [2, 1, 1], mesh.CellType.hexahedron)
    V = fem.functionspace(domain, ("Lagrange", 1, (3,)))
    u, v = fem.Function(V), fem.Function(V)
    spin = 0.02
    v.interpolate(lambda x: np.array([1.0 - spin * x[1], spin * x[0], 0.3 + 0.0 * x[0]]))
    problem = di.ExplicitProblem(u, di.NeoHookean(1.0, 0.3, 1.0), velocity=v)
    m, X = problem.mass.array.reshape(-1, 3), V.tabulate_dof_coordinates()

    def momenta():
        # v half a step ago with the forces of now is v now; x x m v does not care for the part along v.
        p = m * problem.velocity.x.array.reshape(-1, 3)
        x = X + problem.u.x.array.reshape(-1, 3)
        return np.concatenate([p.sum(axis=0), np.cross(x, p).sum(axis=0)])

    start, dt = momenta(), 0.9 * problem.stable_step()
    problem.advance(100_000 * dt, dt=dt, progress=False)
    assert problem.step >= 100_000
    path = problem.time * np.linalg.norm(start[:3])  # what angular momentum about the origin is made of
    np.testing.assert_allclose(momenta()[:3], start[:3], rtol=0, atol=1e-12 * np.abs(start[:3]).max())
    np.testing.assert_allclose(momenta()[3:], start[3:], rtol=0, atol=1e-12 * path)
    # The body turned hundreds of times; what strains it is the pull outwards, rho w^2 L^2/(2 E) = 2e-4.
    sides = np.linalg.norm((X + u.x.array.reshape(-1, 3))[V.dofmap.list] - np.roll(
        (X + u.x.array.reshape(-1, 3))[V.dofmap.list], 1, axis=1), axis=2)  # fmt: skip
    before = np.linalg.norm(X[V.dofmap.list] - np.roll(X[V.dofmap.list], 1, axis=1), axis=2)
    assert np.abs(sides / before - 1).max() < 1e-3


def test_a_mesh_that_is_changed_later_is_refused():
    V = square(4)
    steel = di.LinearElastic(1.0, 0.3, 1.0, "plane_strain")
    problem = di.ExplicitProblem(fem.Function(V), steel, velocity=fem.Function(V))
    V.mesh.geometry.x[0, 0] -= 0.1
    with pytest.raises(ValueError, match="mesh was changed"):
        problem.advance(1.0)


def test_bad_input():
    V = square(4)
    u, v = fem.Function(V), fem.Function(V)
    steel = di.LinearElastic(1.0, 0.3, 1.0, "plane_strain")
    other = fem.Function(fem.functionspace(V.mesh, ("Lagrange", 2, (2,))))

    def make(*arguments, **options):
        return di.ExplicitProblem(u, *(arguments or (steel,)), **{"velocity": v, **options})

    for text, error, call in (
        ("no density", ValueError, lambda: make(di.LinearElastic(1.0, 0.3, hypothesis="plane_strain"))),
        ("density", ValueError, lambda: make(di.LinearElastic(1.0, 0.3, 0.0, "plane_strain"))),
        ("velocity must be a Function", TypeError, lambda: make(velocity=1.0)),
        ("another space", ValueError, lambda: make(velocity=other)),
        ("scheme 'leap' is unknown", ValueError, lambda: make(scheme="leap")),
        ("damping must be", TypeError, lambda: make(damping=0.1)),
        ("bulk_viscosity is", ValueError, lambda: make(bulk_viscosity=(0.06, -1.0))),
        ("needs a density", ValueError, lambda: di.ExplicitProblem(
            u, residual=ufl.inner(u, ufl.TestFunction(V)) * ufl.dx, velocity=v)),
        ("diagonal", ValueError, lambda: make(damping=di.Rayleigh(0.0, 1.0), scheme="classical")),
        ("until is", ValueError, lambda: make().advance(-1.0)),
        ("until", ValueError, lambda: make().advance(math.nan)),
        ("dt", ValueError, lambda: make().advance(1.0, dt=0.0)),
        ("dt is 'fast'", ValueError, lambda: make().advance(1.0, dt="fast")),
        ("method 'guess' is unknown", ValueError, lambda: make().stable_step("guess")),
        ("jumps at the start", ValueError, lambda: make(
            bcs=[fem.dirichletbc(np.ones(2), fem.locate_dofs_geometrical(V, lambda x: x[0] < 0.1), V)])),
        ("tag 7", ValueError, lambda: make(loads=[di.Traction(
            mesh.meshtags(V.mesh, 1, *(np.array([i], dtype=np.int32) for i in (0, 1))), 7, (1.0, 0.0))])),
    ):  # fmt: skip
        with pytest.raises(error, match=text):
            call()
    u.x.array[3] = np.nan
    with pytest.raises(ValueError, match="not a number"):
        make()
