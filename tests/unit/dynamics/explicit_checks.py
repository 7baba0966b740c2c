# SPDX-License-Identifier: MIT
"""Explicit runs whose bodies are cut by the ranks, against the same run on one rank. See on_ranks.py."""

import warnings

import numpy as np
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di

COMM = MPI.COMM_WORLD
SAME = 1e-9  # of the largest entry after 1,000 steps: round-off, and how far waves carry it


def box(comm, cell="hexahedron", degree=1):
    """Cubes one by one by two; its displacement space."""
    kind = getattr(mesh.CellType, cell)
    domain = mesh.create_box(comm, [[0.0, 0.0, 0.0], [1.0, 1.0, 2.0]], [3, 3, 6], kind)
    return fem.functionspace(domain, ("Lagrange", degree, (3,)))


def shaken(comm, law=di.LinearElastic, residual=False, steps=1000, **arguments):
    """A clamped box whose free end is hit; problem after some steps."""
    V = box(comm)
    u, v = fem.Function(V, name="u"), fem.Function(V)
    v.interpolate(lambda x: np.array([0.05 * x[2], 0.0 * x[0], -0.1 * x[2] ** 2]))
    low = fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[2], 0.0))
    bcs = [fem.dirichletbc(np.zeros(3), low, V)]
    material = law(1e3, 0.3, 1.0)
    if residual:
        form = di.operators.internal_force_form(u, ufl.TestFunction(V), material)
        problem = di.ExplicitProblem(u, residual=form, density=1.0, velocity=v, bcs=bcs, **arguments)
    else:
        problem = di.ExplicitProblem(u, material, velocity=v, bcs=bcs, **arguments)
    dt = 0.5 * problem.stable_step()
    problem.advance(until=steps * dt, dt=dt, progress=False)
    return problem


def by_place(comm, f):
    """Values of a nodal function of all ranks, sorted by place."""
    V = f.function_space
    n = V.dofmap.index_map.size_local
    rows = np.hstack([V.tabulate_dof_coordinates()[:n], f.x.array[: 3 * n].reshape(-1, 3)])
    rows = np.vstack(comm.allgather(rows))
    return rows[np.lexsort(rows[:, :3].round(9).T)][:, 3:]


def assert_same(problem, alone):
    for name in ("u", "velocity", "acceleration"):
        here, there = by_place(COMM, getattr(problem, name)), by_place(MPI.COMM_SELF, getattr(alone, name))
        assert here.shape == there.shape
        assert np.abs(here - there).max() <= SAME * np.abs(there).max(), name
    for name, value in alone.energy.items():
        assert abs(problem.energy[name] - value) <= SAME * alone.energy["total"], name


def check_ranks():
    """Displacement, velocity, acceleration and energies are the same on any number of ranks after 1,000 steps."""
    variants = (
        {},
        {"law": di.NeoHookean, "damping": di.Rayleigh(0.3, 1e-4), "bulk_viscosity": (0.06, 1.2)},
        {"law": di.StVenantKirchhoff, "loads": [di.BodyForce((1.0, 0.0, -5.0), amplitude=lambda t: np.sin(8 * t))]},
    )
    for variant in variants:
        assert_same(shaken(COMM, **variant), shaken(MPI.COMM_SELF, **variant))


def check_a_rank_without_cells_of_a_material():
    """A single cell of its own material: the other ranks have none of it."""
    V = box(COMM)
    domain = V.mesh
    num = domain.topology.index_map(3).size_local
    cells = np.arange(num, dtype=np.int32)
    first = np.where(domain.topology.original_cell_index[:num] == 0, 2, 1).astype(np.int32)
    laws = {1: di.LinearElastic(1.0, 0.3, 1.0), 2: di.LinearElastic(1.0, 0.3, 10.0)}
    law = di.MaterialMap(mesh.meshtags(domain, 3, cells, first), laws)
    problem = di.ExplicitProblem(fem.Function(V), law, velocity=fem.Function(V))
    mass = COMM.allreduce(float(problem.mass.array[: problem.num_owned].sum())) / 3
    assert abs(mass - (2.0 + 9.0 / 27)) < 1e-12  # 54 cells in a volume of 2


def fed(rate=-0.5):
    """A box that shakes, and damping of the wrong sign, which no user can ask for: its energy grows, by exp(-rate t)
    where it vibrates, twice as fast where it moves along."""
    V = box(COMM)
    v = fem.Function(V)
    v.interpolate(lambda x: 0.1 * x)
    damping = di.Rayleigh(1.0, 0.0)
    vars(damping)["alpha"] = rate
    return di.ExplicitProblem(fem.Function(V), di.LinearElastic(1e3, 0.3, 1.0), velocity=v, damping=damping)


def advance_with_warnings(problem, until, **options):
    """Texts of warnings and of the error, or ''."""
    text = ""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            problem.advance(until, dt=1e-3, progress=False, **options)
        except RuntimeError as e:
            text = str(e)
    return [str(w.message) for w in caught], text


def check_energy_gained_without_work_warns_then_stops():
    """Limits of 10 and 50 % of what is there then: of 1.11 and 2 times the energy of the start."""
    problem = fed()
    told, error = advance_with_warnings(problem, 0.25)
    assert not error and len(told) == (COMM.rank == 0), (told, error)
    assert COMM.rank or ("gains energy: by the time 0.25" in told[0] and "smaller step" in told[0])
    told, error = advance_with_warnings(problem, 0.3)  # once
    assert not told and not error
    told, error = advance_with_warnings(problem, 20.0)
    assert "went unstable" in error and "gained energy" in error and "cell" in error and not told
    assert len(set(COMM.allgather(error))) == 1
    stopped = float(error.split("at the time ")[1].split(",")[0])
    assert np.log(2.0) < stopped < 2 * np.log(2.0) + 0.1 and 0.0 < problem.time <= stopped, (stopped, problem.time)
    assert np.all(np.isfinite(problem.u.x.array)) and problem.step > 0
    problem.advance(problem.time + 0.01, dt=1e-3, progress=False)  # goes on from there
    for limits in (None, (50.0, 100.0)):
        problem = fed()
        assert advance_with_warnings(problem, 5.0, energy_limits=limits) == ([], "")
        assert problem.energy["kinetic"] > 10.0 * problem.energy_history[0, 1]
    for limits in (0.1, (0.5, 0.1), (0.0, 1.0), ("a", 1.0), (0.1,), (np.nan, 1.0)):
        try:
            problem.advance(11.0, energy_limits=limits)
        except ValueError as e:
            assert "energy_limits" in str(e)
        else:
            raise AssertionError(f"{limits} were taken")


def check_errors_are_the_same_on_all_ranks():
    """A run that goes unstable says so on every rank, with the same words, and is back at its last good state."""
    V = box(COMM)
    u, v = fem.Function(V), fem.Function(V)
    v.interpolate(lambda x: 0.1 * x)
    problem = di.ExplicitProblem(u, di.LinearElastic(1e3, 0.3, 1.0), velocity=v)
    text = ""
    try:
        problem.advance(1.0, dt=1.2 * problem.stable_step("eigenvalue"), progress=False, unsafe=True)
    except RuntimeError as e:
        text = str(e)
    assert "went unstable at the time" in text and "cell" in text
    assert len(set(COMM.allgather(text))) == 1
    assert np.all(np.isfinite(problem.u.x.array)) and problem.energy["total"] < 10.0
    problem.advance(problem.time + 0.01, progress=False)
