# SPDX-License-Identifier: MIT
"""Signs of a residual's tangent at the start, on any number of ranks. See on_ranks.py."""

import warnings

import numpy as np
import pytest
import ufl
from dolfinx import fem
from in_time_checks import CELLS, LAMBDA, MU, Block, rows

import dolfinx_impact as di
from dolfinx_impact.assembly.curvature import extremes


def problems(block, residual):
    """What makes a static problem and solves it, an implicit and an explicit one."""
    return (
        lambda: di.StaticProblem(block.u, residual=residual).solve(),
        lambda: di.NewmarkProblem(block.u, residual=residual, density=1.0),
        lambda: di.ExplicitProblem(block.u, residual=residual, density=1.0),
    )


def residual_of(block, sign=1.0, spring=0.0, weight=0.0):
    """A linear elastic law, its shear term with a sign; a spring on the facets above; a weight; and the constants of
    these. One form for all: on each kind of cells it is compiled once."""
    constants = [fem.Constant(block.mesh, value) for value in (sign, spring, np.full(block.dim, weight))]
    shear, stiffness, force = constants
    e = ufl.sym(ufl.grad(block.u))
    stress = LAMBDA * ufl.tr(e) * ufl.Identity(block.dim) + shear * 2 * MU * e
    residual = (ufl.inner(stress, ufl.grad(block.w)) - ufl.inner(force, block.w)) * block.dx
    ds = ufl.Measure("ds", domain=block.mesh, subdomain_data=block.tags)
    return residual + stiffness * ufl.inner(block.u, block.w) * ds(2), stiffness


def residual(block, **given):
    return residual_of(block, **given)[0]


def check_a_wrong_sign_is_refused_or_told():
    """The shear term of a law: refused. A weak spring on ds, which a body with prestress may look like: told.
    Right signs, and a bed of springs, say nothing."""
    for cell in rows(CELLS):
        block = Block(cell)
        for make in problems(block, residual(block, sign=-1.0)):
            with pytest.raises(ValueError, match="negative"):
                make()
        _, implicit, explicit = problems(block, residual(block, spring=-2.0))
        for make in (implicit, explicit):
            if block.mesh.comm.rank == 0:
                with pytest.warns(UserWarning, match="negative in some directions.*springs on ds"):
                    make()
            else:
                make()
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.filterwarnings("ignore", "this .* and an? .* that is still alive")
            for make in problems(block, residual(block, spring=2.0)):
                make()


def check_ends_of_a_known_spectrum():
    """Rigid motions are zero to rounding; without them the lowest value is positive; reversed, the ends change."""
    block = Block("quadrilateral")
    n = block.V.dofmap.index_map.size_local * 2
    K = di.StaticProblem(block.u, residual=residual(block)).tangent.assemble()
    low, high = extremes(K, np.ones(n, dtype=bool))
    assert abs(low) < 1e-9 and 1.0 < high < 4.0
    K.scale(-1.0)
    assert extremes(K, np.ones(n, dtype=bool)) == pytest.approx((-high, -low), abs=1e-9)
    assert extremes(K, np.zeros(n, dtype=bool)) == (0.0, 0.0)


def advance(problem, until, **given):
    """Advance an implicit problem in a fixed number of steps, an explicit one by itself."""
    if isinstance(problem, di.NewmarkProblem):
        problem.advance(until, dt=0.02, progress=False)
    else:
        problem.advance(until, progress=False, **given)


def check_a_body_that_grows_by_itself_stops_the_run():
    """A spring of a sign that is right at the start, wrong later, and one that is weakly wrong: the run stops where the
    energy that the residual has given passes what the body may have stored. Energies alone stop nothing with
    energy_limits=None; a further call goes on in implicit runs."""
    for cell in rows(CELLS):
        for make in (di.ExplicitProblem, di.NewmarkProblem):
            block = Block(cell)
            form, k = residual_of(block, spring=1.0)
            velocity = fem.Function(block.V)
            velocity.interpolate(lambda x: 0.1 * np.sin([x[i] + i for i in range(block.dim)]))
            problem = make(block.u, residual=form, density=1.0, velocity=velocity)
            advance(problem, 0.1)
            k.value = -20.0
            with pytest.raises(RuntimeError, match="has given the body an energy of .* wrong sign"):
                advance(problem, 1000.0)
            reached = problem.time
            assert reached < 20.0 and np.all(np.isfinite(problem.u.x.array))
            advance(problem, reached + 0.04, **({} if make is di.NewmarkProblem else {"energy_limits": None}))
            assert problem.time == reached + 0.04


def check_energy_that_was_stored_or_belongs_to_forces_in_the_residual_stops_nothing():
    """A body that springs back from strains of 50 %, and one that falls by a force that the residual has."""
    for cell in rows(CELLS):
        for make in (di.ExplicitProblem, di.NewmarkProblem):
            block = Block(cell)
            block.u.interpolate(lambda x: 0.5 * x[: block.dim])
            advance(make(block.u, residual=residual(block), density=1.0), 0.5)
            block = Block(cell)
            problem = make(block.u, residual=residual(block, weight=30.0), density=1.0)
            advance(problem, 0.5)
            assert problem.energy["internal"] < 0.0 < 10.0 < problem.energy["kinetic"]
