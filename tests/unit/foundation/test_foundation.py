# SPDX-License-Identifier: MIT
"""Foundations: on ranks, against closed forms and dense matrices, and what is refused."""

import warnings

import foundation_checks as checks
import numpy as np
import pytest
import scipy.linalg
import ufl
from dolfinx import fem, mesh
from foundation_checks import BOTTOM, DENSITY, HEIGHT, LEFT, TOP, WIDTH, block, moving, steel, uniform
from mpi4py import MPI
from on_ranks import rank_tests

import dolfinx_impact as di
from impact_verify.differences import petsc_to_scipy

test_one_rank, test_several_ranks = rank_tests(checks, in_make_test={"added_mass": (1,)})
SELF = MPI.COMM_SELF


# --- closed forms ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("damping", (0.0, 0.4))
@pytest.mark.parametrize("kind", (di.ExplicitProblem, di.NewmarkProblem))
def test_a_stiff_block_swings_as_a_mass_on_a_spring(kind, damping):
    """Frequency sqrt(k A/m), decay c A/(2 m). The block is 4e-4 times as soft as the springs: k H/E; the error of the
    time step is smaller, (omega dt)^2/24 and /12."""
    E, k, speed = 5e4, 20.0, -0.1
    u, tags = block(SELF, n=(4, 2))
    problem = kind(u, steel(E), velocity=uniform(u, (0.0, speed)), loads=[di.Foundation(tags, BOTTOM, k, damping)])
    mass = DENSITY * WIDTH * HEIGHT
    rate = 0.5 * damping * WIDTH / mass
    omega = np.sqrt(k * WIDTH / mass - rate**2)
    dt = 0.5 * problem.stable_step() if kind is di.ExplicitProblem else 5e-3
    for turn in (0.25, 1.0, 1.75):
        time = turn * 2 * np.pi / omega
        problem.advance(time, dt=dt, progress=False)
        swing = speed / omega * np.exp(-rate * time) * np.sin(omega * time)
        assert np.mean(u.x.array[1::2]) == pytest.approx(swing, abs=8e-4 * abs(speed) / omega * (1 + turn * 2 * np.pi))
        assert np.abs(u.x.array[::2]).max() < 1e-3 * abs(speed) / omega


@pytest.mark.parametrize("dim", (2, 3))
def test_a_rail_on_a_foundation(dim):
    """Zimmermann: a point load settles an endless beam on a Winkler foundation by P/(8 E I lambda^3), lambda =
    (k/(4 E I))^(1/4), at half the distance pi/lambda between the ends of the settled part it is zero at 3 pi/4. The
    shear, which the formula leaves out, adds of the order of (lambda h)^2 = 6e-4, and the load's width as much."""
    h, E, slender = 1.0, 1e3, 0.025
    inertia, k = h**3 / 12, 4 * E * h**3 / 12 * (slender / h) ** 4
    cells, length = 200, 12.0 / slender
    low, high = [(-length / 2, *(-h / 2 for _ in range(dim - 1))), (length / 2, *(h / 2 for _ in range(dim - 1)))]
    create = mesh.create_rectangle if dim == 2 else mesh.create_box
    kind = mesh.CellType.quadrilateral if dim == 2 else mesh.CellType.hexahedron
    domain = create(SELF, [low, high], (cells, *(1 for _ in range(dim - 1))), kind)
    size = length / cells
    bottom = mesh.locate_entities_boundary(domain, dim - 1, lambda x: np.isclose(x[dim - 1], -h / 2))
    loaded = mesh.locate_entities_boundary(
        domain, dim - 1, lambda x: np.isclose(x[dim - 1], h / 2) & (np.abs(x[0]) < 1.01 * size)
    )
    facets = np.concatenate([bottom, loaded])
    order = np.argsort(facets)
    values = np.repeat([1, 2], [len(bottom), len(loaded)]).astype(np.int32)
    tags = mesh.meshtags(domain, dim - 1, facets[order], values[order])
    V = fem.functionspace(domain, ("Lagrange", 2, (dim,)))
    u = fem.Function(V, name="u")
    middle = fem.locate_dofs_geometrical(V, lambda x: np.all(np.isclose(x, 0.0), axis=0))
    assert len(middle) == 1
    x = V.tabulate_dof_coordinates()
    axial = [fem.dirichletbc(0.0, fem.locate_dofs_geometrical((V.sub(a), V.sub(a).collapse()[0]), where)[0], V.sub(a))
             for a, where in ((0, lambda x: np.all(np.isclose(x[[0, dim - 1]], 0.0), axis=0)),
                              (1, lambda x: np.isclose(x[1], 0.0)))[: dim - 1]]  # fmt: skip
    P = 1.0
    load = di.Traction(tags, 2, (*(0.0 for _ in range(dim - 1)), -P / (2 * size) / h ** (dim - 2)))
    law = di.LinearElastic(E, 0.0, 1.0, "3d" if dim == 3 else "plane_stress")
    rail = di.Foundation(tags, 1, k)
    di.StaticProblem(u, law, bcs=axial, loads=[rail, load]).solve()
    assert rail.force(u)[-1] == pytest.approx(P, rel=1e-8)
    axis = np.flatnonzero(np.all(np.isclose(x[:, 1:], 0.0), axis=1))
    w = u.x.array.reshape(-1, dim)[axis, dim - 1]
    place = slender / h * np.abs(x[axis, 0])
    expected = -P / (8 * E * inertia * (slender / h) ** 3) * np.exp(-place) * (np.cos(place) + np.sin(place))
    inside = place < 4.0  # of 6: the ends change it by exp(-6)
    assert np.abs(w - expected)[inside].max() < 4e-3 * np.abs(expected).max()


# --- the stable step -------------------------------------------------------------------------------------------------


def matrices(u, springs):
    """Dense stiffness with springs, matrix of the dashpots, and lumped mass."""
    V = u.function_space
    v, du = ufl.TestFunction(V), ufl.TrialFunction(V)
    K = di.Tangent(di.operators.tangent_form(u, du, v, steel()) + springs.springs(du, v)).assemble()
    C = di.Tangent(springs.dashpots(du, v)).assemble()
    return petsc_to_scipy(K).toarray(), petsc_to_scipy(C).toarray(), np.diag(di.lumped_mass(V, steel()).array)


@pytest.mark.parametrize("stiffness, damping", ((2e4, 0.0), ((3e3, 1e4), 0.0), (0.1, 20.0), (5e3, (4.0, 9.0))))
def test_the_stable_step_counts_springs_and_dashpots(stiffness, damping):
    """Against dense eigenvalues: with springs (and dashpots) that are stiffer than the cells. dt^2/4 K + dt/2 C has the
    largest eigenvalue one over the mass."""
    u, tags = block(SELF, n=(3, 2))
    springs = di.Foundation(tags, BOTTOM, stiffness, damping)
    problem = di.ExplicitProblem(u, steel(), velocity=uniform(u, 0.0), loads=[springs])
    K, C, M = matrices(u, springs)

    def top(dt):
        return scipy.linalg.eigvalsh(dt**2 / 4 * K + dt / 2 * C, M)[-1]

    low, high = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if top(middle) > 1.0 else (middle, high)
    # Squares of frequencies to 1e-8.
    assert problem.stable_step("eigenvalue") == pytest.approx(low, rel=1e-7)
    # The bound by cells holds, and is not far off: shared nodes have up to four times the mass of one cell's.
    assert 0.3 * low < problem.stable_step() <= low * (1 + 1e-9)
    without = di.ExplicitProblem(fem.Function(u.function_space, name="u"), steel(), velocity=uniform(u, 0.0))
    assert problem.stable_step() < 0.8 * without.stable_step()


@pytest.mark.parametrize("stiffness, damping", ((2e4, 0.0), (0.1, 20.0)))
def test_runs_are_stable_up_to_the_step_and_not_beyond(stiffness, damping):
    def run(factor):
        u, tags = block(SELF, n=(3, 2))
        v = uniform(u, (0.01, -0.1))
        v.x.array[:] += 1e-3 * np.random.default_rng(1).uniform(-1, 1, v.x.array.size)
        springs = di.Foundation(tags, BOTTOM, stiffness, damping)
        problem = di.ExplicitProblem(u, steel(), velocity=v, loads=[springs])
        dt = factor * problem.stable_step("eigenvalue")
        problem.advance(600 * dt, dt=dt, progress=False, unsafe=True, energy_limits=None)
        return problem.energy["kinetic"]

    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "dt = .* is beyond the stable step")  # that by cells
        assert run(0.99) < 1.0
    with pytest.warns(UserWarning, match="beyond the stable step"):  # without limits nothing stops what grows
        assert abs(run(1.02)) > 1e6


def test_other_damping_beside_dashpots_shortens_the_step():
    """Rayleigh's factors and linear viscosity: the eigenvalues of a dense problem, with alpha M + beta K_bodies in C.
    The step by cells stays below it."""
    u, tags = block(SELF, n=(3, 2))
    springs = di.Foundation(tags, BOTTOM, 0.1, 6.0)
    alpha, beta = 2.0, 5e-3
    problem = di.ExplicitProblem(
        u, steel(), velocity=uniform(u, 0.0), loads=[springs], damping=di.Rayleigh(alpha, beta)
    )
    K, C, M = matrices(u, springs)
    C = C + alpha * M + beta * K  # with the springs' part, which is small here, on the safe side
    dt = problem.stable_step("eigenvalue")
    assert scipy.linalg.eigvalsh(dt**2 / 4 * K + dt / 2 * C, M)[-1] == pytest.approx(1.0, rel=1e-6)
    assert 0.3 * dt < problem.stable_step() <= dt
    viscous = di.ExplicitProblem(
        fem.Function(u.function_space, name="u"), steel(), velocity=uniform(u, 0.0), loads=[springs],
        bulk_viscosity=(0.1, 1.2),
    )  # fmt: skip
    plain = moving(di.ExplicitProblem, fem.Function(u.function_space, name="u"), tags)
    assert viscous.stable_step() < 0.95 * plain.stable_step()


def test_mass_scaling_counts_springs():
    """Cells whose springs are too stiff for the step get mass."""
    u, tags = block(SELF, n=(3, 2))
    loads = [di.Foundation(tags, BOTTOM, 2e4)]
    problem = di.ExplicitProblem(u, steel(), velocity=uniform(u, 0.0), loads=loads, mass_scaling=0.01)
    assert problem.added_mass > 0.0 and problem.stable_step() >= 0.01 * (1 - 1e-9)


# --- what is refused -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "stiffness, damping, error, match",
    (
        (0.0, 0.0, ValueError, "stiffness of a Foundation is zero"),
        (-1.0, 0.0, ValueError, "stiffness is -1.0: it must be finite and not negative"),
        (np.nan, 0.0, ValueError, "stiffness is nan"),
        ((1.0, -2.0), 0.0, ValueError, "not negative"),
        (np.ones((2, 2)), 0.0, ValueError, "shape"),
        ("stiff", 0.0, TypeError, "stiffness must be a number"),
        (True, 0.0, TypeError, "stiffness must be a number"),
        (None, 0.0, TypeError, "stiffness must be a number"),
        (1.0, np.inf, ValueError, "damping is inf"),
        (1.0, -0.1, ValueError, "damping is -0.1"),
        (1.0, "thick", TypeError, "damping must be a number"),
    ),
)
def test_bad_values(stiffness, damping, error, match):
    _, tags = block(SELF, n=(2, 2))
    with pytest.raises(error, match=match):
        di.Foundation(tags, BOTTOM, stiffness, damping)


def test_what_does_not_fit_the_problem():
    u, tags = block(SELF, n=(2, 2))
    v = ufl.TestFunction(u.function_space)
    x = ufl.SpatialCoordinate(u.function_space.mesh)
    other, _ = block(SELF, n=(2, 2))
    strange = fem.Function(fem.functionspace(other.function_space.mesh, ("DG", 0)), name="strange")
    for springs, match in (
        (di.Foundation(tags, BOTTOM, (1.0, 2.0, 3.0)), r"shape \(3,\)"),
        (di.Foundation(tags, BOTTOM, ufl.as_vector([x[0], x[0], x[1]])), r"shape \(3,\)"),
        (di.Foundation(tags, BOTTOM, strange), "another mesh"),
        (di.Foundation(tags, BOTTOM, x[0] - 1.0), "negative"),
        (di.Foundation(tags, BOTTOM, ufl.as_vector([x[0], x[0] - 1.0])), "negative"),
        (di.Foundation(tags, 17, 1.0), "no facet carries the tag 17"),
    ):
        with pytest.raises(ValueError, match=match):
            springs.springs(u, v)
    with pytest.raises(ValueError, match="unknown"):
        di.Foundation(tags, BOTTOM, 1.0).springs(u, v, hypothesis="round")
    with pytest.raises(ValueError, match="damping of a Foundation has shape"):
        di.Foundation(tags, BOTTOM, 1.0, (1.0, 1.0, 1.0)).dashpots(u, v)
    with pytest.raises(TypeError, match="facet_tags must be MeshTags"):
        di.Foundation(BOTTOM, tags, 1.0)


def test_what_problems_refuse():
    u, tags = block(SELF, n=(2, 2))
    _, others = block(SELF, n=(2, 2))
    damped = di.Foundation(tags, BOTTOM, 1.0, 0.1)
    with pytest.raises(ValueError, match="classical"):
        di.ExplicitProblem(u, steel(), velocity=uniform(u, 0.0), loads=[damped], scheme="classical")
    domain = u.function_space.mesh
    same = mesh.meshtags(domain, 1, tags.indices, tags.values)
    pair = [damped, di.Foundation(same, LEFT, 1.0)]
    for kind in (di.ExplicitProblem, di.NewmarkProblem):
        with pytest.raises(ValueError, match="share one subdomain_data"):
            kind(u, steel(), velocity=uniform(u, 0.0), loads=pair)
    cells = mesh.meshtags(domain, 2, np.arange(4, dtype=np.int32), np.full(4, 1, dtype=np.int32))
    with pytest.raises(ValueError, match="takes no dashpots"):
        di.RollingProblem(u, steel(), cells, {1: di.Translation((1.0, 0.0))}, loads=[damped])


def test_masses_that_are_refused():
    u, tags = block(SELF, n=(2, 2))
    for mass in (0.0, -1.0, np.inf):
        with pytest.raises(ValueError, match="mass is"):
            di.AddedMass(tags, BOTTOM, mass)
    with pytest.raises(TypeError, match="mass must be a number"):
        di.AddedMass(tags, BOTTOM, "heavy")
    with pytest.raises(ValueError, match="no facet carries the tag 17"):
        di.ExplicitProblem(u, steel(), velocity=uniform(u, 0.0), loads=[di.AddedMass(tags, 17, 1.0)])
    cells = mesh.meshtags(u.function_space.mesh, 2, np.arange(4, dtype=np.int32), np.full(4, 1, dtype=np.int32))
    with pytest.raises(ValueError, match="takes no AddedMass"):
        di.RollingProblem(u, steel(), cells, {1: di.Translation((1.0, 0.0))}, loads=[di.AddedMass(tags, BOTTOM, 1.0)])
    plane = di.RigidPlane(point=(0.0, -0.01), normal=(0.0, 1.0))
    pair = di.ContactPair(tags, slave=BOTTOM, master=plane)
    with pytest.raises(ValueError, match="pass on their mass"):
        di.NewmarkProblem(
            u, steel(), velocity=uniform(u, 0.0), loads=[di.AddedMass(tags, BOTTOM, 1.0)], contact=[di.Lagrange(pair)]
        )


def test_statics_do_not_see_masses():
    u, tags = block(SELF, n=(2, 2))
    loads = [di.Foundation(tags, BOTTOM, (1.0, 2.0)), di.Traction(tags, TOP, (0.0, -1.0))]
    di.StaticProblem(u, steel(), loads=loads).solve()
    expected = u.x.array.copy()
    u.x.array[:] = 0.0
    di.StaticProblem(u, steel(), loads=[*loads, di.AddedMass(tags, TOP, 7.0)]).solve()
    np.testing.assert_array_equal(u.x.array, expected)


def test_the_classical_scheme_takes_springs():
    """Springs need no diagonal matrix."""
    u, tags = block(SELF, n=(4, 2))
    loads = [di.Foundation(tags, BOTTOM, 4.0)]
    problem = di.ExplicitProblem(u, steel(), velocity=uniform(u, (0.0, -0.1)), loads=loads, scheme="classical")
    problem.advance(0.5, dt=0.5 * problem.stable_step(), progress=False)
    assert abs(problem.energy["drift"]) < 1e-11 and problem.energy["internal"] > 0.0


def test_repr():
    _, tags = block(SELF, n=(2, 2))
    assert repr(di.Foundation(tags, BOTTOM, 2.0)) == "Foundation(tag=1, stiffness=2.0, damping=0.0)"
    assert repr(di.AddedMass(tags, BOTTOM, 2)) == "AddedMass(tag=1, mass=2.0)"
    assert "expression" in repr(di.Foundation(tags, TOP, ufl.as_ufl(2.0)))
