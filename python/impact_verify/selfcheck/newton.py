# SPDX-License-Identifier: MIT
"""Newton's method for small problems with prescribed degrees of freedom."""

from __future__ import annotations

import warnings

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import MatrixRankWarning, spsolve

from dolfinx_impact.common.types import FloatArray, IntArray
from .assembled import Assembled

ITERATIONS = 25
SMALL = 500  # unknowns up to which a singular matrix is solved in the sense of least squares


def solve(
    assembled: Assembled, start: FloatArray, prescribed: IntArray, load: FloatArray | float = 0.0, rtol: float = 1e-11
) -> FloatArray:
    """Solve vector(u) = load for the degrees of freedom that are not prescribed.

    Args:
        assembled: residual and tangent.
        start: first iterate, which has the prescribed values.
        prescribed: degrees of freedom that keep their values.
        load: right-hand side, shape (num_dofs).
        rtol: tolerance of the correction over the size of the unknowns [1].

    Returns:
        The solution.

    Raises:
        RuntimeError: the method does not converge.
    """
    u = start.copy()
    free = np.setdiff1d(np.arange(len(u)), prescribed)
    if not len(free):
        return u
    last = np.inf
    for _ in range(ITERATIONS):
        K: csr_matrix = assembled.matrix(u)
        r = (assembled.vector(u) - load)[free]
        step = _correction(csr_matrix(K[free][:, free]), r)
        u[free] -= step
        size = float(np.abs(step).max() / max(np.abs(u).max(), 1e-300))
        if not np.isfinite(size):
            break
        # Round-off of ill-conditioned systems may be larger than the tolerance: then corrections no longer shrink.
        if size <= rtol or (size < 1e-8 and size > 0.25 * last):
            return u
        last = size
    raise RuntimeError(f"Newton's method does not converge: after {ITERATIONS} steps the correction is {last:.1e}")


def _correction(K: csr_matrix, r: FloatArray) -> FloatArray:
    """Solution of K x = r, of least size where K is singular."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", MatrixRankWarning)
        try:
            x = spsolve(K.tocsc(), r)
            if np.all(np.isfinite(x)):
                return np.asarray(x)
        except MatrixRankWarning:
            pass
    if K.shape[0] > SMALL:
        raise RuntimeError("the tangent is singular with all nodes of the boundary prescribed")
    return np.asarray(np.linalg.lstsq(K.toarray(), r, rcond=1e-12)[0])
