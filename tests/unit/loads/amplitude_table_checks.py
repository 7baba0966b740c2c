# SPDX-License-Identifier: MIT
"""Tables as amplitudes of loads and supports and as motions of obstacles, on any number of ranks. See on_ranks.py."""

import functools

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI
from shared_folder import shared_folder

import dolfinx_impact as di

COMM = MPI.COMM_WORLD
TIMES, VALUES = [0.0, 0.04, 0.1], [0.0, 1.0, 0.4]
LAST = 0.08


def smooth_step(t):
    """The table with smooth steps, written out."""
    k = int(t >= TIMES[1])
    r = min((t - TIMES[k]) / (TIMES[k + 1] - TIMES[k]), 1.0)
    return VALUES[k] + (VALUES[k + 1] - VALUES[k]) * r**3 * (10 - 15 * r + 6 * r**2)


def linear(t):
    return float(np.interp(t, TIMES, VALUES))


@functools.cache
def square():
    """One mesh for all runs that are compared: DOLFINx may partition a second one otherwise."""
    return mesh.create_rectangle(COMM, [[0.0, 0.0], [1.0, 1.0]], [3, 3], mesh.CellType.quadrilateral)


def run(kind, amplitude, motion, until=LAST):
    """A block above a floor that moves, drawn sideways at its head by a support, under a load."""
    block = square()
    V = fem.functionspace(block, ("Lagrange", 1, (2,)))
    sides = [mesh.locate_entities_boundary(block, 1, lambda x, y=y: np.isclose(x[1], y)) for y in (0.0, 1.0)]
    facets = np.concatenate(sides)
    order = np.argsort(facets)
    tags = mesh.meshtags(
        block, 1, facets[order], np.repeat([1, 2], [len(s) for s in sides]).astype(np.int32)[order]
    )  # fmt: skip
    floor = di.RigidPlane(point=(0.0, 0.0), normal=(0.0, 1.0))
    floor.motion = motion
    head = fem.locate_dofs_topological(V.sub(0), 1, sides[1])
    drawn = di.PrescribedMotion(fem.dirichletbc(0.01, head, V.sub(0)), amplitude)
    load = di.Traction(tags, 2, (0.0, -5.0), amplitude=amplitude)
    make = di.ExplicitProblem if kind == "explicit" else di.NewmarkProblem
    law = di.LinearElastic(E=100.0, nu=0.3, density=1.0, hypothesis="plane_strain")
    contact = di.Penalty(di.ContactPair(tags, slave=1, master=floor), penalty=1e4)
    problem = make(fem.Function(V, name="displacement"), law, bcs=[drawn], loads=[load], contact=[contact])
    if until:
        problem.advance(until=until, dt=1e-3, progress=False)
    return problem


def moved(f):
    return lambda t: np.array([0.0, 0.02 * f(t), 0.0])


def check_a_table_is_the_function_written_out():
    """To the last digits: the same numbers enter the same steps."""
    for kind in ("explicit", "implicit"):
        for interpolation, written in (("linear", linear), ("smooth", smooth_step)):
            table = di.AmplitudeTable(TIMES, VALUES, interpolation)
            plane = di.AmplitudeTable(TIMES, [[0.0, 0.02 * v] for v in VALUES], interpolation)
            ours, theirs = run(kind, table, plane), run(kind, written, moved(written))
            size = COMM.allreduce(np.abs(theirs.u.x.array).max(initial=0.0), MPI.MAX)
            assert size > 1e-3, "the block is deformed"
            # What values that differ by round-off cause in 80 steps.
            assert np.allclose(ours.u.x.array, theirs.u.x.array, rtol=0.0, atol=1e-10 * size), (kind, interpolation)


def check_a_restored_run_goes_on_with_its_tables():
    for kind in ("explicit", "implicit"):
        table, plane = di.AmplitudeTable(TIMES, VALUES), di.AmplitudeTable(TIMES, [[0.0, 0.02 * v] for v in VALUES])
        whole, half = run(kind, table, plane), run(kind, table, plane, until=LAST / 2)
        with shared_folder(COMM) as folder:
            half.save(folder / "half.h5")
            again = run(kind, table, plane, until=None)
            again.restore(folder / "half.h5")
        again.advance(until=LAST, dt=1e-3, progress=False)
        size = COMM.allreduce(np.abs(whole.u.x.array).max(initial=0.0), MPI.MAX)
        assert np.allclose(again.u.x.array, whole.u.x.array, rtol=0.0, atol=1e-10 * size), kind


def check_times_outside_are_refused_on_all_ranks():
    for kind in ("explicit", "implicit"):
        table = di.AmplitudeTable(TIMES, VALUES, after="refuse", name="pulse")
        problem = run(kind, table, None, until=LAST)
        with pytest.raises(ValueError, match="pulse is asked for the time .* goes from 0 to 0.1"):
            problem.advance(until=2 * TIMES[-1], dt=1e-3, progress=False)


def check_tables_that_differ_between_ranks_are_refused():
    if COMM.size == 1:
        return
    table = di.AmplitudeTable(TIMES, [0.0, 1.0, 0.4 + 0.1 * (COMM.rank == 1)])
    with pytest.raises(ValueError, match="rank"):
        run("explicit", table, None, until=None)


def check_a_static_history_by_a_table():
    """A static problem has no time: the table gives the values between two solves."""
    block = mesh.create_unit_square(COMM, 2, 2, mesh.CellType.quadrilateral)
    V = fem.functionspace(block, ("Lagrange", 1, (2,)))
    u = fem.Function(V)
    feet = fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[1], 0.0))
    top = mesh.locate_entities_boundary(block, 1, lambda x: np.isclose(x[1], 1.0))
    tags = mesh.meshtags(block, 1, np.sort(top), np.full(len(top), 2, dtype=np.int32))
    table, pull = di.AmplitudeTable(TIMES, VALUES), di.Traction(tags, 2, (0.0, 1.0))
    law = di.LinearElastic(E=100.0, nu=0.3, hypothesis="plane_strain")
    problem = di.StaticProblem(u, law, bcs=[fem.dirichletbc(np.zeros(2), feet, V)], loads=[pull])
    sizes = []
    for t in (0.02, 0.04, 0.07):
        pull.constant.value = table(t) * np.array([0.0, 1.0])
        problem.solve(progress=False)
        sizes.append(COMM.allreduce(np.abs(u.x.array).max(initial=0.0), MPI.MAX))
    assert np.allclose(np.array(sizes) / sizes[1], [0.5, 1.0, 0.7], rtol=1e-9)
    with pytest.raises(ValueError, match="set load.constant.value = table"):
        di.StaticProblem(fem.Function(V), law, loads=[di.Traction(tags, 2, (0.0, 1.0), amplitude=table)])
