# SPDX-License-Identifier: MIT
"""Whether a steady state is below its critical speed: stiffness minus W must be positive definite; and that speed."""

from __future__ import annotations

import numpy as np
from petsc4py import PETSc

from .. import _cpp
from ..statics.problem import StaticProblem

FACTOR_TOLERANCE = 1e-10  # relative, of the eigenvalue that gives the critical speed


def held_tangent(problem: StaticProblem) -> PETSc.Mat:
    """Tangent at the present state with contact by penalty, with ones in the rows of supports. Collective.

    Args:
        problem: static problem whose body includes W.

    Returns:
        A matrix of its own [F/L].
    """
    K = problem.tangent.assemble().copy()
    for contact in problem.contact:
        if not contact.has_multipliers:
            contact.update_gap(problem.u.x.array)
            K.axpy(1.0, contact.tangent(), PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
    rows = K.getOwnershipRange()[0] + np.flatnonzero(problem.fixed[: problem.num_owned])
    K.setOption(PETSc.Mat.Option.KEEP_NONZERO_PATTERN, True)
    K.zeroRowsColumns(rows.astype(np.int32), 1.0)
    return K


def critical_factor(problem: StaticProblem, W: PETSc.Mat) -> float:
    """Factor on all rates at which stiffness minus W becomes singular; the stiffness stays as it is. Collective.

    The smallest f with (K - f^2 W) x = 0: 1/f^2 is the largest eigenvalue of W x = (1/f^2) K x.

    Args:
        problem: static problem whose body includes W, held against rigid motion.
        W: at the present rates, zero at supports [F/L].

    Returns:
        The factor, infinite without a flow [1].

    Raises:
        RuntimeError: the eigensolver found none.
    """
    if W.norm() == 0.0:
        return float("inf")
    K = held_tangent(problem)
    K.axpy(1.0, W, PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
    found = _cpp.solve.largest_eigenvalue(W, K, FACTOR_TOLERANCE, factorise=True)
    K.destroy()
    value = 0.0
    if found is not None:
        value, vector = found
        vector.destroy()
    if not value > 0.0:
        raise RuntimeError("the eigensolver did not find the critical speed")
    return float(value**-0.5)


def negative_directions(problem: StaticProblem) -> int:
    """Number of negative eigenvalues of the tangent, by the inertia of its factors (Sylvester). Collective.

    Args:
        problem: static problem whose body includes W.

    Returns:
        The number [1].
    """
    K = held_tangent(problem)
    negative: int = _cpp.solve.num_negative_eigenvalues(K)
    K.destroy()
    return negative
