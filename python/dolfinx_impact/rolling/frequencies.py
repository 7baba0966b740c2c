# SPDX-License-Identifier: MIT
"""Quadratic eigenproblem (s^2 M + s G + K - W) x = 0 of a body in the ALE frame; seed (3.54), corrected."""

from __future__ import annotations

import numpy as np
from petsc4py import PETSc

from .. import _cpp
from ..common.types import FloatArray

SHIFT = 1e-3  # of the mesh's frequency: keeps the factorised matrix regular where rigid motions are free
GROWTH = 1e-6  # real part over the largest modulus found, at which a mode grows
MAX_RESTARTS = 500  # of the eigensolver
RIGID_MOTIONS = 6  # of a body in space
ROUND_OFF = 5e-8  # of the mesh's frequency: a few times the square root of the unit of round-off
RIGID = 10.0  # moduli below this many times the larger of the last two belong to rigid motions


def solve(
    K: PETSc.Mat, G: PETSc.Mat, M: PETSc.Mat, along: PETSc.Mat, count: int, least: float, tolerance: float
) -> tuple[FloatArray, int]:
    """Find the frequencies of smallest modulus. Collective.

    A mode x exp(i omega t) with omega > 0 is a wave: forward if its phase travels with the flow of the material,
    backward, and then given with a minus sign, if it travels against it. With x ~ exp(-i n theta) the form `along` is
    -i n times the mass, so that the sign is that of minus its imaginary part.

    Args:
        K: tangent stiffness minus W, with ones on the diagonal of supports [F/L].
        G: gyroscopic matrix, zero at supports [M/T].
        M: mass matrix, zero at supports [M].
        along: matrix of the derivative along the flow, zero at supports [M/T].
        count: number of frequencies [1].
        least: below it a mode's derivative along the flow, over its amplitude, is none: half the angular velocity of a
            body, as waves have a whole number of lengths around it; zero without a spin [1/T].
        tolerance: relative tolerance of an eigenvalue [1].

    Returns:
        Frequencies, sorted by modulus, (count) or fewer [1/T], and the number of modes found that grow [1].

    Raises:
        RuntimeError: the solver found fewer than asked for.
    """
    diagonals = [A.getDiagonal() for A in (K, M)]
    highest = float(np.sqrt(diagonals[0].sum() / diagonals[1].sum()))
    shift = SHIFT * highest
    for d in diagonals:
        d.destroy()
    # A body that nothing holds has the rigid motions first.
    pairs = _cpp.solve.quadratic_eigenpairs(K, G, M, 2 * count + 2 * RIGID_MOTIONS, shift, tolerance, MAX_RESTARTS)
    product = K.createVecRight()
    # Free rigid motions have s = 0 as a double root, which round-off splits into a pair of any phase.
    small = max(GROWTH * max((abs(s) for s, *_ in pairs), default=0.0), ROUND_OFF * highest)
    found: list[float] = []
    growing = 0
    for s, real, imaginary in pairs:
        if abs(s.real) > small:
            growing += s.real > 0
            continue
        if s.imag < RIGID * small:
            continue  # a rigid motion, or the conjugate of a mode, which is the same motion
        # Imaginary part of x^H D x, where D is real and x = a + i b: a.D b - b.D a.
        along.mult(imaginary, product)
        twist = product.dot(real)
        along.mult(real, product)
        twist -= product.dot(imaginary)
        size = 0.0
        for part in (real, imaginary):
            M.mult(part, product)
            size += product.dot(part)
        found.append(-s.imag if twist > least * size else s.imag)
    for thing in (product, *(part for _, *parts in pairs for part in parts)):
        thing.destroy()
    if len(found) < count:
        raise RuntimeError(f"the eigensolver found {len(found)} of {count} frequencies ({growing} modes grow)")
    return np.array(sorted(found, key=abs)[:count]), growing
