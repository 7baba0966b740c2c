# SPDX-License-Identifier: MIT
"""Largest stable step of Newmark's method with beta < gamma/2."""

from __future__ import annotations

import math

import numpy as np
from petsc4py import PETSc

from ... import _cpp
from ...common.types import BoolArray

TOLERANCE = 1e-6  # relative error of the highest frequency: nobody steps closer to the limit


def highest_frequency(stiffness: PETSc.Mat, mass: PETSc.Mat, held: BoolArray) -> float:
    """Highest angular frequency of K x = omega^2 M x, by SLEPc's Krylov-Schur method. Collective.

    Args:
        stiffness: K, symmetric [F/L].
        mass: M, symmetric [M].
        held: mask of owned degrees of freedom that do not move: prescribed ones, and those without mass, which follow
            the others without inertia.

    Returns:
        Angular frequency [1/T].

    Raises:
        RuntimeError: the eigenvalue solver does not converge.
    """
    K, M = stiffness.copy(), mass.copy()
    rows = M.getOwnershipRange()[0] + np.flatnonzero(held).astype(np.int32)
    K.zeroRowsColumns(rows, 0.0)
    M.zeroRowsColumns(rows, 1.0)
    found = _cpp.solve.largest_eigenvalue(K, M, TOLERANCE)
    K.destroy()
    M.destroy()
    if found is None:
        raise RuntimeError("the highest frequency was not found: take beta >= gamma/2, which is stable with any step")
    value, vector = found
    vector.destroy()
    return math.sqrt(max(value, 0.0))
