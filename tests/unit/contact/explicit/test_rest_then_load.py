# SPDX-License-Identifier: MIT
"""Explicit runs of bodies that touch and are at rest: they stay so until a load begins, and then nothing stops them."""

import itertools

import numpy as np
import pytest
from dolfinx import fem
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import meshes

TOP = 0.7 / 3  # of the floor: no height of a node is exact
RAMP = 1e-4  # duration of a load's growth from zero [s]
CELLS = {2: ("triangle", "quadrilateral"), 3: ("tetrahedron", "hexahedron")}
METHODS = {
    "penalty": di.Penalty,
    "balanced": lambda pair: di.Penalty(pair, balanced=True),
    "kinematic": di.Kinematic,
}


def ramp(t):
    return min(1.0, t / RAMP)


def blocks(cell, floor, method, load="none", away=0.0):
    """A steel block on a floor that it touches; `away`: distance of both from the origin."""
    dim = next(d for d, cells in CELLS.items() if cell in cells)
    low = meshes.make(
        "two_blocks", MPI.COMM_SELF, cell=cell, lower=(TOP,) * dim, upper=(0.3 / 7,) * (dim - 1) + (0.1,),
        lower_cells=(4,) * dim, upper_cells=(3,) * (dim - 1) + (4,),
    )  # fmt: skip
    low.mesh.geometry.x[:, :dim] += away
    V = fem.functionspace(low.mesh, ("Lagrange", 1, (dim,)))
    steel = di.LinearElastic(200e9, 0.3, 7800.0, "plane_strain" if dim == 2 else None)
    up = np.eye(3)[dim - 1]
    master = low.tags["master_surface"] if floor == "block" else di.RigidPlane((TOP + away) * up[:dim], up[:dim])
    if floor == "moving plane":
        master.motion = lambda t: 1e-6 * up * ramp(t)
    pair = di.ContactPair(low.facet_tags, low.tags["slave_surface"], master)
    loads = {
        "none": [],
        "ramp": [di.Traction(low.facet_tags, low.tags["top"], -1e6 * up[:dim], amplitude=ramp)],
        "gravity": [di.BodyForce(-9.81 * up[:dim], amplitude=ramp)],
    }[load]
    x = V.tabulate_dof_coordinates()[:, dim - 1]
    foot = np.flatnonzero(np.isclose(x, away)).astype(np.int32)
    return di.ExplicitProblem(
        fem.Function(V),
        steel,
        velocity=fem.Function(V),
        bcs=[fem.dirichletbc(np.zeros(dim), foot, V)],
        loads=loads,
        contact=[METHODS[method](pair)] if method else [],
    )


def rows(floors, loads):
    """Balanced contact needs a deformable floor."""
    table = itertools.product(sum(CELLS.values(), ()), floors, METHODS, loads)
    return [row for row in table if row[2] != "balanced" or row[1] == "block"]


@pytest.mark.covering(2)
@pytest.mark.parametrize("cell, floor, method, load", rows(("plane", "block"), ("none",)))
def test_bodies_that_touch_stay_at_rest(cell, floor, method, load):
    """Gaps are zero to rounding, of either sign: no force acts on any node."""
    problem = blocks(cell, floor, method)
    problem.advance(50 * problem.stable_step(), progress=False)
    assert problem.step >= 50 and not np.any(problem.u.x.array) and not np.any(problem.force_history[0])


@pytest.mark.covering(2)
@pytest.mark.parametrize(
    "cell, floor, method, load", rows(("plane", "block", "moving plane"), ("ramp", "gravity", "none"))
)
def test_load_that_begins_at_zero(cell, floor, method, load):
    """Neither the guards of the energy nor warnings (which the suite takes for errors) meet a correct run."""
    problem = blocks(cell, floor, method, load)
    problem.advance(2 * RAMP, progress=False)
    assert problem.time == 2 * RAMP and abs(problem.energy["drift"]) < 1e-3
    # Springs may owe some per mill of an impact (docs/explicit/penalty.md, "Bound").
    assert problem._cpp_object.integrator.most_gained < 5e-3
    if load != "none":
        assert problem.energy["external"] > 0.0


@pytest.mark.parametrize("method", ("penalty", "kinematic"))
def test_far_from_the_origin(method):
    """Positions are rounded to 1e-10 of the block's size there: that moves it by as much, which no guard takes for
    growth."""
    problem = blocks("quadrilateral", "block", method, away=1e5)
    problem.advance(500 * problem.stable_step(), progress=False)
    assert problem.step >= 500 and np.max(np.abs(problem.u.x.array)) < 1e-8


@pytest.mark.parametrize("load", ("ramp", "gravity"))
@pytest.mark.parametrize("method", ("penalty", "kinematic"))
def test_growth_from_rest_is_found(method, load):
    """Steps twice the stable one: the fastest mode grows by 14 a step."""
    problem = blocks("quadrilateral", "plane", method, load)
    dt = 2.0 * problem.stable_step("eigenvalue")
    with pytest.warns(UserWarning, match="beyond the stable step"), pytest.raises(RuntimeError, match="went unstable"):
        problem.advance(60 * dt, dt=dt, progress=False, unsafe=True)
    assert problem.step < 60 and np.all(np.isfinite(problem.u.x.array))


def test_energy_limits_none_stops_no_run():
    """Without limits the energies stop nothing: growth by a factor of 1e6 and more is let go on. (Contact that is gone
    through still stops a run: here there is none.)"""
    problem = blocks("quadrilateral", "plane", None, "ramp")
    dt = 2.0 * problem.stable_step("eigenvalue")
    with pytest.warns(UserWarning, match="beyond the stable step"):
        problem.advance(20 * dt, dt=dt, progress=False, unsafe=True, energy_limits=None)
    internal, external = problem.energy_history[:, [2, 9]].T
    assert problem.step == 20 and internal.max() > 1e6 * np.abs(external).max()
