# SPDX-License-Identifier: MIT
"""Arguments of problems in time that people leave out, and numbers at the end of their range."""

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di

PROBLEMS = (di.ExplicitProblem, di.NewmarkProblem)
CELLS = ("triangle", "quadrilateral", "tetrahedron", "hexahedron")


def body(cell="quadrilateral", degree=1, **given):
    """Displacement function of a bar, law, and the degrees of freedom of its held end along x."""
    kind = mesh.CellType[cell]
    if cell in ("triangle", "quadrilateral"):
        m = mesh.create_rectangle(MPI.COMM_SELF, [[0, 0], [1, 0.3]], [4, 1], kind)
    else:
        m = mesh.create_box(MPI.COMM_SELF, [[0, 0, 0], [1, 0.3, 0.3]], [3, 1, 1], kind)
    dim = m.geometry.dim
    V = fem.functionspace(m, ("Lagrange", degree, (dim,)))
    held = fem.locate_dofs_geometrical((V.sub(0), V.sub(0).collapse()[0]), lambda x: np.isclose(x[0], 0))[0]
    return fem.Function(V), di.LinearElastic(1e3, 0.3, 1.0, "plane_strain" if dim == 2 else None), held


@pytest.mark.parametrize("problem", PROBLEMS)
def test_without_velocity_bodies_begin_at_rest(problem):
    u, law, _ = body()
    load = di.BodyForce((1.0, 0.0))
    runs = [
        problem(f, law, loads=[load], velocity=v) for f, v in ((u, None), (u.copy(), fem.Function(u.function_space)))
    ]
    for run in runs:
        assert not np.any(run.velocity.x.array)
        run.advance(0.01, dt=0.001, progress=False)
    assert np.array_equal(runs[0].u.x.array, runs[1].u.x.array) and np.any(runs[0].u.x.array)


@pytest.mark.covering(2)
@pytest.mark.parametrize("problem", PROBLEMS)
@pytest.mark.parametrize("degree", (1, 2))
@pytest.mark.parametrize("cell", CELLS)
def test_start_at_a_support_is_zero_to_rounding(cell, degree, problem):
    """A shape that vanishes at the support does so to rounding, of its own size."""
    u, law, held = body(cell, degree)
    u.interpolate(lambda x: np.stack([1e-3 * np.sin(1.57 * x[0]), *(0.0 * x[1 : len(u)])]))
    u.x.array[held] = 7e-21 * (-1.0) ** np.arange(len(held))
    support = fem.dirichletbc(0.0, held, u.function_space.sub(0))
    run = problem(u, law, bcs=[support])
    run.advance(0.01, dt=0.001, progress=False)
    assert not np.any(run.u.x.array[held])
    v = fem.Function(u.function_space)
    v.x.array[held] = 1e-9
    with pytest.raises(ValueError, match="jumps at the start"):
        problem(v, law, bcs=[support])


def test_implicit_step_must_be_given():
    run = di.NewmarkProblem(*body()[:2])
    with pytest.raises(TypeError, match="advance needs dt, the largest step"):
        run.advance(1.0, progress=False)


@pytest.mark.parametrize("until, dt", ((1e300, 1e300), (1e300, 1e299), (1e-300, 1.0), (1e-300, 1e-301)))
def test_implicit_steps_without_a_square(until, dt):
    run = di.NewmarkProblem(*body()[:2])
    with pytest.raises(ValueError, match="whose squares are numbers"):
        run.advance(until, dt=dt, progress=False)
    assert run.time == 0.0


@pytest.mark.parametrize("problem", PROBLEMS)
def test_step_longer_than_the_way(problem):
    """A dt beyond the time to advance by is one step to its end, however long."""
    u, law, _ = body()
    run = problem(u, law)
    options = {"unsafe": True} if problem is di.ExplicitProblem else {"smallest": 1e-320}
    if options.get("unsafe"):
        with pytest.warns(UserWarning, match="beyond the stable step"):
            run.advance(1e-3, dt=1e300, progress=False, **options)
    else:
        run.advance(1e-3, dt=1e300, progress=False, **options)
    assert run.time == 1e-3 and run.step == 1
