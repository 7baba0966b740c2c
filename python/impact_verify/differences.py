# SPDX-License-Identifier: MIT
"""How far vectors and matrices of both sides differ."""

import numpy as np
from petsc4py import PETSc
from scipy.sparse import csr_matrix, issparse

from dolfinx_impact.common.types import FloatArray
from .matched_body import Body


def relative(a: FloatArray, b: FloatArray) -> float:
    """Relative difference of two arrays.

    Args:
        a: array.
        b: reference, of the same shape.

    Returns:
        Largest difference over the largest entry of b [1].
    """
    return np.max(np.abs(a - b)) / np.max(np.abs(b))


def relative_matrices(A: csr_matrix, B: csr_matrix) -> float:
    """Relative difference of two sparse matrices.

    Args:
        A: matrix.
        B: reference, of the same shape.

    Returns:
        Largest difference over the largest entry of B [1].
    """
    return np.max(np.abs((A - B).data), initial=0.0) / np.max(np.abs(B.data))


def largest_difference(body: Body, ours: FloatArray | csr_matrix, theirs: FloatArray | csr_matrix) -> tuple[float, str]:
    """Largest relative difference of vectors or sparse matrices, and where it is.

    Args:
        body: body of both sides.
        ours: our vector, shape (num_dofs), or sparse matrix, shape (num_dofs, num_dofs).
        theirs: the other side's in our order.

    Returns:
        Difference over the largest entry of `theirs` [1], and a text with the nodes and the two entries.
    """
    at: tuple[int, ...]
    if issparse(ours):
        difference = relative_matrices(ours, theirs)
        parts = csr_matrix(ours - theirs).tocoo()
        if parts.nnz == 0:
            return difference, ""
        k = _worst(parts.data)
        at = (int(parts.row[k]), int(parts.col[k]))
    else:
        difference = relative(ours, theirs)
        at = (_worst(ours - theirs),)
    x = body.V.tabulate_dof_coordinates()[:, : body.gdim]
    positions = [f"node at {np.round(x[i // body.gdim], 4).tolist()} component {i % body.gdim}" for i in at]
    return difference, f"{' against '.join(positions)}: UFL {ours[at]:.15g}, hand-written {theirs[at]:.15g}"


def _worst(error: FloatArray) -> int:
    """Index of the largest entry; a NaN counts as the largest."""
    return int(np.argmax(np.where(np.isnan(error), np.inf, np.abs(error))))


def petsc_to_scipy(matrix: PETSc.Mat) -> csr_matrix:
    """Copy of a PETSc matrix as a SciPy matrix.

    Args:
        matrix: assembled matrix on one rank.

    Returns:
        The same matrix.
    """
    indptr, indices, data = matrix.getValuesCSR()
    return csr_matrix((data, indices, indptr), shape=matrix.getSize())
