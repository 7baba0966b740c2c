# SPDX-License-Identifier: MIT
"""Signs of a residual's tangent: a few of Lanczos' steps find directions in which it is negative."""

import warnings

import numpy as np
import scipy
from dolfinx.fem import FunctionSpace
from petsc4py import PETSc

from ..common.collective import common
from ..common.types import BoolArray, FloatArray

STEPS = 40  # of Lanczos' method; the ends of the spectrum come first
NOISE = 1e-6  # lowest over highest value that counts as zero: rounding leaves far less of rigid motions
WRONG = 0.1  # beyond this a sign is wrong: prestress and softening bring no more at a start


def extremes(K: PETSc.Mat, free: BoolArray) -> tuple[float, float]:
    """Bounds from inside on the spectrum of the symmetric part of a matrix, scaled by its diagonal. Collective.

    Ritz values of Lanczos' method: the spectrum has values as low as the first, and as high as the second.

    Args:
        K: square matrix, its rows those of owned degrees of freedom.
        free: mask of the rows and columns that count.

    Returns:
        Lowest and highest value, in units of the diagonal [1].
    """
    comm = K.comm.tompi4py()
    first, last = K.getOwnershipRange()
    diagonal = K.getDiagonal()
    size = np.abs(diagonal.array_r)
    diagonal.destroy()
    scale = np.where(free & (size > 0.0), 1.0 / np.sqrt(np.where(size > 0.0, size, 1.0)), 0.0)
    right, left = K.createVecs()

    def times(x: FloatArray) -> FloatArray:
        right.array[:] = scale * x
        K.mult(right, left)
        product = left.array_r.copy()
        K.multTranspose(right, left)
        return np.asarray(0.5 * scale * (product + left.array_r))

    def dot(x: FloatArray, y: FloatArray) -> float:
        return float(comm.allreduce(float(x @ y)))

    # The same start on any number of ranks, with something of every direction.
    numbers = np.arange(first, last, dtype=float)
    q = np.where(scale > 0.0, np.sin(1.0 + 12.9898 * numbers) + 0.5 * np.cos(0.7 * numbers), 0.0)
    before, beta, alphas, betas = np.zeros_like(q), 0.0, [], []
    norm = np.sqrt(dot(q, q))
    for _ in range(STEPS):
        if not norm > 0.0:
            break
        q /= norm
        product = times(q) - beta * before
        alphas.append(dot(q, product))
        product -= alphas[-1] * q
        before, q = q, product
        beta = norm = np.sqrt(dot(q, q))
        betas.append(beta)
        if not beta > 1e-12 * np.abs(alphas).max():
            break
    for vector in (right, left):
        vector.destroy()
    if not alphas:
        return 0.0, 0.0
    values = scipy.linalg.eigvalsh_tridiagonal(np.array(alphas), np.array(betas[: len(alphas) - 1]))
    return float(values[0]), float(values[-1])


def is_displacement(V: FunctionSpace) -> bool:
    """Whether functions of a space have the components of a displacement: others, of saddle points or of fields with
    several equilibria, may have a tangent that is not positive.

    Args:
        V: the space.
    """
    gdim: int = V.mesh.geometry.dim
    return V.num_sub_spaces == V.dofmap.bs == gdim


def check_curvature(K: PETSc.Mat, free: BoolArray) -> None:
    """Refuse, or warn of, a residual whose tangent is negative in some directions. Collective.

    Args:
        K: tangent at the start [F/L].
        free: mask of owned degrees of freedom that are not prescribed.

    Raises:
        ValueError: it is strongly negative; on all ranks.

    Warns:
        UserWarning: it is negative a little.
    """
    low, high = extremes(K, free)
    size = max(-low, high)
    if not -low > NOISE * size:
        return
    text = (
        f"the tangent of the residual is negative in some directions, by {-low / size:.2g} of its largest value "
        "(scaled by its diagonal): the body would fly apart by itself. Is the residual internal minus external forces, "
        "and is the sign of each term right (all of them, springs on ds, too)?"
    )
    if -low > WRONG * size:
        raise common(ValueError(text))
    if K.comm.rank == 0:
        warnings.warn(f"{text} Bodies with prestress, or that soften, may begin so", stacklevel=5)
