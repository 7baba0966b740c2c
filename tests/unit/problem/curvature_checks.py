# SPDX-License-Identifier: MIT
"""Signs of a residual's tangent at the start, on any number of ranks. See on_ranks.py."""

import warnings

import numpy as np
import pytest
import ufl
from values_in_time_checks import CELLS, LAMBDA, MU, Block

import dolfinx_impact as di
from dolfinx_impact.assembly.curvature import extremes


def problems(block, residual):
    """What makes a static problem and solves it, an implicit and an explicit one."""
    return (
        lambda: di.StaticProblem(block.u, residual=residual).solve(),
        lambda: di.NewmarkProblem(block.u, residual=residual, density=1.0),
        lambda: di.ExplicitProblem(block.u, residual=residual, density=1.0),
    )


def shear(block, sign):
    e = ufl.sym(ufl.grad(block.u))
    stress = LAMBDA * ufl.tr(e) * ufl.Identity(block.dim) + sign * 2 * MU * e
    return ufl.inner(stress, ufl.grad(block.w)) * block.dx


def check_a_wrong_sign_is_refused_or_told():
    """The shear term alone, a whole law: refused. A weak spring on ds, which a body with prestress may look like: told.
    Right signs, and a bed of springs, say nothing."""
    for cell in CELLS:
        block = Block(cell)
        ds = ufl.Measure("ds", domain=block.mesh, subdomain_data=block.tags)
        for make in problems(block, shear(block, -1.0)):
            with pytest.raises(ValueError, match="negative"):
                make()
        spring = ufl.inner(block.u, block.w) * ds(2)
        _, implicit, explicit = problems(block, shear(block, 1.0) - 2.0 * spring)
        for make in (implicit, explicit):
            if block.mesh.comm.rank == 0:
                with pytest.warns(UserWarning, match="negative in some directions.*springs on ds"):
                    make()
            else:
                make()
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.filterwarnings("ignore", "this .* and an? .* that is still alive")
            for make in problems(block, shear(block, 1.0) + 2.0 * spring):
                make()


def check_ends_of_a_known_spectrum():
    """Rigid motions are zero to rounding; without them the lowest value is positive; reversed, the ends change."""
    block = Block("quadrilateral")
    n = block.V.dofmap.index_map.size_local * 2
    K = di.StaticProblem(block.u, residual=shear(block, 1.0)).tangent.assemble()
    low, high = extremes(K, np.ones(n, dtype=bool))
    assert abs(low) < 1e-9 and 1.0 < high < 4.0
    K.scale(-1.0)
    assert extremes(K, np.ones(n, dtype=bool)) == pytest.approx((-high, -low), abs=1e-9)
    assert extremes(K, np.zeros(n, dtype=bool)) == (0.0, 0.0)
