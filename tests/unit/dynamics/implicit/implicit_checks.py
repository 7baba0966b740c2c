# SPDX-License-Identifier: MIT
"""Implicit runs: steps, checkpoints, energies and errors. See on_ranks.py."""

import contextlib
import functools

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from shared_folder import shared_folder

import dolfinx_impact as di
from dolfinx_impact import meshes

COMM = MPI.COMM_WORLD
SMALL = {"lower": (1.4, 0.5), "upper": (1.0, 0.5), "lower_cells": (7, 3), "upper_cells": (6, 3)}
LAWS = {
    "linear": functools.partial(di.LinearElastic, 1e3, 0.3, 1.0, "plane_strain"),
    "neo-Hookean": functools.partial(di.NeoHookean, 1e3, 0.3, 1.0, "plane_strain"),
    "J2": functools.partial(
        di.J2Plasticity, 1e3, 0.3, density=1.0, yield_stress=5.0, hardening=50.0, hypothesis="plane_strain"
    ),
}
CONTACTS = {
    "multipliers": di.Lagrange,
    "standard basis": functools.partial(di.Lagrange, basis="standard"),
    "penalty": functools.partial(di.Penalty, penalty=1e5),
    "augmented": functools.partial(di.Penalty, penalty=1e4, augmented=True, tolerance=1e-6),
}
DT = 4e-3  # the blocks touch in the second step


@functools.cache
def mesh_of(handle):
    """One mesh for all: DOLFINx may number it otherwise when it is made once more on several ranks."""
    return meshes.make("two_blocks", COMM if handle == COMM.handle else MPI.COMM_SELF, **SMALL)


def block_on_block(comm=COMM, contact="multipliers", law="linear", friction=0.3, gravity=True, **options):
    """A block thrown obliquely on another one that moves up and down; problem, not run yet."""
    made = mesh_of(comm.handle)
    tags = made.tags
    V = fem.functionspace(made.mesh, ("Lagrange", 1, (2,)))
    u, v = fem.Function(V), fem.Function(V)
    upper = made.cell_tags.find(tags["slave_body"])
    v.x.array.reshape(-1, 2)[np.unique(V.dofmap.list[upper].ravel())] = (0.5, -0.4)
    v.x.scatter_forward()
    bottom = fem.locate_dofs_topological(V, 1, made.facet_tags.find(tags["bottom"]))
    moving = di.PrescribedMotion(fem.dirichletbc(np.array([0.0, 0.002]), bottom, V), lambda t: np.sin(20 * t) ** 2)
    pair = di.ContactPair(made.facet_tags, tags["slave_surface"], tags["master_surface"], friction=friction)
    loads = [di.BodyForce((0.0, -9.81), amplitude=lambda t: 1.0 - np.exp(-t))] if gravity else []
    given = {"rho_inf": 0.8, "damping": di.Rayleigh(0.1, 1e-5), "bcs": [moving], **options}
    return di.NewmarkProblem(u, LAWS[law](), velocity=v, loads=loads, contact=[CONTACTS[contact](pair)], **given)


@functools.cache
def bar_of(handle):
    """One mesh for all bars, too."""
    comm = COMM if handle == COMM.handle else MPI.COMM_SELF
    return mesh.create_rectangle(comm, [[0.0, 0.0], [1.0, 0.2]], [8, 2], mesh.CellType.quadrilateral)


def bar(comm=COMM, **options):
    """A bar that is free, thrown along its axis, or at rest while one end is driven."""
    V = fem.functionspace(bar_of(comm.handle), ("Lagrange", 1, (2,)))
    u, v = fem.Function(V), fem.Function(V)
    v.interpolate(lambda x: np.vstack([1.0 + 0.1 * x[0], 0.0 * x[0]]))
    law = options.pop("material", LAWS["linear"]())
    if options.pop("driven", False):
        end = fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[0], 0.0))
        held = fem.dirichletbc(np.array([0.1, 0.0]), end, V)
        options["bcs"] = [di.PrescribedMotion(held, lambda t: np.sin(t) ** 2)]
        v.x.array[:] = 0.0
    return di.NewmarkProblem(u, law, velocity=v, **options)


def warned():
    """Context in which rank 0, which speaks for all, must warn of a scheme that is stable with small steps only."""
    if COMM.rank == 0:
        return pytest.warns(UserWarning, match="stable only with steps up to")
    return contextlib.nullcontext()


def assert_same(found, expected, name=""):
    """Bit for bit on one rank. On several, MUMPS sums in the order in which messages come in: the same matrix and right
    side do not give the same digits twice, and two uninterrupted runs differ by some 1e-9 of their largest number."""
    if COMM.size == 1:
        np.testing.assert_array_equal(found, expected, name)
    else:
        known = np.isfinite(expected)
        np.testing.assert_array_equal(np.isfinite(found), known)
        scale = COMM.allreduce(np.abs(expected[known]).max(initial=0.0), MPI.MAX)
        np.testing.assert_allclose(found[known], expected[known], atol=1e-8 * scale, err_msg=name)


def motion(problem):
    """Motion, and totals of the contact."""
    parts = [f.x.array for f in (problem.u, problem.velocity, problem.acceleration)]
    return np.concatenate([*parts, *(x for c in problem.contact for x in (c.force, c.moment, [c.area, c.dissipated]))])


def state(problem):
    """Motion, and what is told of the contact, the energies and the history."""
    parts = [motion(problem)]
    for c in problem.contact:
        parts += [np.ravel(getattr(c, name)) for name in ("gap", "normal", "pressure", "traction", "slip", "status")]
    energies = [value for name, value in problem.energy.items() if name != "drift"]
    history = [field.values.ravel() for field in problem.history.values()] if problem.has_history else []
    return np.concatenate([*parts, energies, *history])


VARIANTS = [
    {"contact": "multipliers"},
    {"contact": "standard basis", "friction": 0.0},
    {"contact": "penalty", "law": "neo-Hookean"},
    {"contact": "augmented", "friction": 0.0},
    {"contact": "penalty", "law": "J2", "lumping": "auto"},
]

# On several ranks one of each kind of contact is enough.
SOME = VARIANTS if COMM.size == 1 else [VARIANTS[0], VARIANTS[4]]


def check_a_body_at_rest_on_a_plane_stays_at_rest():
    """The whole residual is the round-off of the gaps, as 1/3 is no binary number."""
    low = 1.0 / 3.0
    domain = mesh.create_rectangle(COMM, [[0.1, low], [1.1, low + 0.7]], [5, 4], mesh.CellType.quadrilateral)
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    bottom = mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[1], low))
    tags = mesh.meshtags(domain, 1, np.sort(bottom), np.full(len(bottom), 3, dtype=np.int32))
    for law in ("linear", "neo-Hookean"):
        u = fem.Function(V)
        pair = di.ContactPair(tags, 3, di.RigidPlane((0.0, low), (0.0, 1.0)))
        problem = di.NewmarkProblem(u, LAWS[law](), velocity=fem.Function(V), contact=[di.Penalty(pair, penalty=7e4)])
        problem.advance(10 * DT, DT, progress=False)
        assert problem.step == 10
        assert COMM.allreduce(np.abs(u.x.array).max(initial=0.0), MPI.MAX) < 1e-14  # a few roundings of a position


def check_adaptive_runs_continue_with_their_step():
    with shared_folder() as path:
        whole, again = block_on_block(), block_on_block()
        whole.advance(4 * DT, DT, tolerance=1e-4, progress=False)
        whole.save(path / "a.h5")
        again.restore(path / "a.h5")
        for problem in (whole, again):
            problem.advance(8 * DT, DT, tolerance=1e-4, progress=False)
        assert again.step == whole.step > 8
        assert_same(state(again), state(whole))


def check_checkpoints_of_other_problems_are_refused():
    """The problem is not changed by a checkpoint that it refuses."""
    with shared_folder() as path:
        written = block_on_block()
        written.advance(3 * DT, DT, progress=False)
        written.save(path / "a.h5")
        others = {
            "scheme": {"rho_inf": 0.5}, "damping": {"damping": None}, "lumping": {"lumping": "auto"},
            "material": {"law": "neo-Hookean"}, "contact": {"friction": 0.1}, "loads": {"gravity": False},
        }  # fmt: skip
        for word, change in others.items():
            other = block_on_block(**change)
            before = state(other)
            with pytest.raises(ValueError, match=f"of another problem.*{word}"):
                other.restore(path / "a.h5")
            np.testing.assert_array_equal(state(other), before)
        still = fem.dirichletbc(np.zeros(2), np.zeros(0, dtype=np.int32), written.space)
        with pytest.raises(ValueError, match="supports|functions of time"):
            block_on_block(bcs=[still]).restore(path / "a.h5")


def check_energy_balances():
    """The trapezoidal rule without contact balances the energy exactly, with loads and damping: its works are those of
    the balance; the tolerance of Newton's method adds up over the steps. Prescribed motion has its own velocity, not
    that of the rule: an error of second order in the step, whose square is 4e-4."""
    free = bar(loads=[di.BodyForce((3.0, 0.0), amplitude=np.cos)], damping=di.Rayleigh(0.3, 1e-3))
    driven = bar(driven=True, damping=di.Rayleigh(0.3, 0.0))
    for problem, limit in ((free, 1e-9), (driven, 4e-4)):
        problem.advance(1.0, 0.02, progress=False, rtol=1e-12)
        energy = problem.energy
        assert energy["damping"] > 1e-4 and abs(energy["external"]) > 1e-4  # each is in the balance
        assert abs(energy["drift"]) < limit


def check_names_of_the_energies():
    """Those of explicit problems."""
    problem = bar()
    names = ("kinetic", "internal", "contact", "friction", "impact", "damping", "viscosity", "plastic", "external")
    assert tuple(problem.energy) == (*names, "total", "drift")
    problem.advance(0.1, 0.05, progress=False)
    assert problem.energy_history.shape == (3, 10)
    np.testing.assert_array_equal(problem.energy_history[-1, 1:], [problem.energy[n] for n in names])


def check_error_control():
    """Steps follow the local error: the estimate is that of Newmark's method, of the third power of the step. At half
    the tolerance, to the power 1/3, there are 1.26 times as many steps."""
    counts = []
    for tolerance in (1e-5, 1e-5 / 8):
        problem = bar(material=di.LinearElastic(1.0, 0.0, 1.0, "plane_strain"))
        problem.advance(2.0, 1.0, tolerance=tolerance, progress=False)
        counts.append(problem.step)
    assert counts[1] / counts[0] == pytest.approx(2.0, rel=0.15)


def check_a_step_that_fails_is_halved():
    """A step in which a soft block would turn over: Newton's method fails, its halves converge."""
    problem = bar(material=LAWS["neo-Hookean"]())
    problem.velocity.x.array[:] = 0.0
    spin = 40.0
    v = fem.Function(problem.space)
    v.interpolate(lambda x: np.vstack([-spin * x[1], spin * x[0]]))
    fresh = di.NewmarkProblem(fem.Function(problem.space), LAWS["neo-Hookean"](), velocity=v)
    fresh.advance(0.2, 0.1, progress=False, max_iterations=12)
    assert fresh.stepper.cut_backs > 0 and fresh.time == 0.2
    assert np.all(np.isfinite(fresh.u.x.array))


def check_long_steps_end_in_static_equilibrium():
    """A soft cantilever under a pressure that follows it. With rho_inf = 0 each of ten steps of many periods removes
    what still moves."""
    domain = mesh.create_rectangle(COMM, [[0.0, 0.0], [1.0, 0.2]], [8, 2], mesh.CellType.quadrilateral)
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    end = fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[0], 0.0))
    held = fem.dirichletbc(np.zeros(2), end, V)
    top = mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[1], 0.2))
    tags = mesh.meshtags(domain, 1, top, np.full(len(top), 1, dtype=np.int32))
    load = [di.FollowerPressure(tags, 1, 1.0)]
    u, w = fem.Function(V), fem.Function(V)
    static = di.StaticProblem(w, LAWS["neo-Hookean"](), bcs=[held], loads=load)
    static.solve(steps=4)
    problem = di.NewmarkProblem(u, LAWS["neo-Hookean"](), velocity=fem.Function(V), bcs=[held],
                                loads=[di.FollowerPressure(tags, 1, 1.0)], rho_inf=0.0)  # fmt: skip
    problem.advance(100.0, 10.0, progress=False)
    size = COMM.allreduce(np.abs(w.x.array).max(initial=0.0), MPI.MAX)
    assert size > 0.1
    np.testing.assert_allclose(u.x.array, w.x.array, atol=1e-6 * size)


def check_parameters():
    cases = [
        ({"beta": 0.0}, "beta is 0"), ({"gamma": 0.4}, "gamma is 0.4"), ({"rho_inf": 1.5}, "rho_inf is 1.5"),
        ({"hht": -0.5}, "hht is -0.5"), ({"hht": -0.1, "beta": 0.3}, "give one"),
        ({"impact": "persistency"}, "impact is 'persistency'"), ({"lumping": "diagonal"}, "diagonal"),
    ]  # fmt: skip
    for options, text in cases:
        with pytest.raises(ValueError, match=text):
            bar(**options)
    with pytest.raises(TypeError, match="rho_inf must be a number"):
        bar(rho_inf="0.8")
    with warned():
        small = bar(beta=0.2, gamma=0.5)
    assert 0.0 < small.stable_step() < np.inf and bar().stable_step() == np.inf


def check_the_stable_step_is_the_limit():
    """A little below it nothing grows, a little above the highest mode does."""
    sizes = []
    for part in (0.99, 1.01):
        problem = bar()
        rng = np.random.default_rng(1)
        points = problem.space.tabulate_dof_coordinates()[:, :2]
        noise = rng.uniform(-1e-3, 1e-3, 2)
        problem.u.x.array[:] = (1e-3 * np.sin(1e3 * points + noise)).ravel()
        with warned():
            rough = di.NewmarkProblem(problem.u, LAWS["linear"](), velocity=fem.Function(problem.space), beta=1 / 6)
        step = part * rough.stable_step()
        start = rough.energy["total"]
        rough.advance(200 * step, step, progress=False)
        sizes.append(rough.energy["total"] / start)
    assert sizes[0] < 10.0 and sizes[1] > 1e3


def check_a_residual_of_ones_own():
    """The same bar from a residual with a damping term in the velocity."""
    given = bar(damping=di.Rayleigh(0.5, 0.0))
    V = given.space
    u, v, w = fem.Function(V), fem.Function(V), ufl.TestFunction(V)
    v.x.array[:] = given.velocity.x.array
    mu, lmbda = 1e3 / 2.6, 1e3 * 0.3 / (1.3 * 0.4)
    eps = ufl.sym(ufl.grad(u))
    stress = 2 * mu * eps + lmbda * ufl.tr(eps) * ufl.Identity(2)
    residual = ufl.inner(stress, ufl.grad(w)) * ufl.dx + 0.5 * ufl.inner(v, w) * ufl.dx
    own = di.NewmarkProblem(u, residual=residual, density=1.0, velocity=v)
    for problem in (given, own):
        problem.advance(0.2, 0.01, progress=False, rtol=1e-12)
    np.testing.assert_allclose(u.x.array, given.u.x.array, atol=1e-11)
    assert own.energy["damping"] == pytest.approx(given.energy["damping"], rel=1e-9)
    assert own.energy["internal"] == pytest.approx(given.energy["internal"], rel=1e-6, abs=1e-9)


def check_repr():
    assert "beta=0.25, gamma=0.5, step 0, time 0" in repr(bar())
    assert "alpha_m=0.3333333333, alpha_f=0.4444444444" in repr(bar(rho_inf=0.8))
