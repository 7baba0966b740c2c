# SPDX-License-Identifier: MIT
"""Newton's method on a small static problem converges quadratically, also with friction and sliding over edges."""

import numpy as np
import pytest
import scipy.sparse as sparse
import ufl
from dolfinx import fem
from penalty_model import Deformable
from scipy.sparse.linalg import splu


def stiffness(V):
    """Linear elasticity with Young's modulus 20 and no lateral contraction."""
    u, v = ufl.TrialFunction(V), ufl.TestFunction(V)
    return fem.assemble_matrix(fem.form(20 * ufl.inner(ufl.sym(ufl.grad(u)), ufl.sym(ufl.grad(v))) * ufl.dx)).to_scipy()


@pytest.mark.parametrize("friction", (0.0, 0.3))
@pytest.mark.parametrize("cell, degree", [("quadrilateral", 1), ("triangle", 2), ("hexahedron", 1), ("tetrahedron", 2)])
def test_quadratic_convergence(cell, degree, friction):
    """The upper block is pushed down and sideways by its upper side, in one step."""
    model = Deformable(cell, 1, degree, friction=friction)
    V, dim = model.V, model.dim
    K = stiffness(V).tocsc()
    height = V.tabulate_dof_coordinates()[:, dim - 1]
    ends = [np.flatnonzero(np.isclose(height, 0.0)), np.flatnonzero(height > 1.7)]  # the upper side is bent
    assert len(ends[0]) > 0 and len(ends[1]) > 0
    u = np.zeros(model.num)
    u.reshape(-1, dim)[ends[1], dim - 1] = -0.03
    u.reshape(-1, dim)[ends[1], 0] = 0.04
    fixed = (np.concatenate(ends)[:, None] * dim + np.arange(dim)).ravel()
    free = np.setdiff1d(np.arange(model.num), fixed)
    residuals, kinks = [], None
    for _ in range(25):
        r = K @ u - model.force(u)
        residuals.append(np.abs(r[free]).max())
        if residuals[-1] < 1e-12:
            break
        rows, cols, values = model.tangent(u)
        A = (K + sparse.coo_matrix((values, (rows, cols)), shape=K.shape)).tocsc()[free][:, free]
        u[free] -= splu(A).solve(r[free])
        kinks, before = model.kinks(u), kinks
    assert residuals[-1] < 1e-12, residuals
    assert np.array_equal(kinks, before)
    # Once small, the residual squares (in units of the force, about 1); above round-off.
    last = [(a, b) for a, b in zip(residuals, residuals[1:]) if a < 1e-4 and b > 1e-13]
    assert all(b < 1e3 * a**2 + 1e-12 for a, b in last), residuals
    assert (model.state(u).status > 0).any()
