# SPDX-License-Identifier: MIT
"""Eigenvalues by SLEPc and MUMPS against NumPy's, of small matrices."""

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from dolfinx_impact import _cpp

SIZE = 12


def matrix(values):
    A = PETSc.Mat().createAIJ(values.shape, comm=MPI.COMM_SELF, nnz=len(values))
    A[:, :] = values
    A.assemble()
    return A


def symmetric(rng, shift=0.0):
    values = rng.standard_normal((SIZE, SIZE))
    return values + values.T + shift * np.eye(SIZE)


def test_negative_eigenvalues_are_counted(rng):
    for shift in (-50.0, -2.0, 0.0, 3.0, 50.0):
        values = symmetric(rng, shift)
        assert _cpp.solve.num_negative_eigenvalues(matrix(values)) == np.count_nonzero(np.linalg.eigvalsh(values) < 0.0)


def test_quadratic_eigenpairs_are_those_of_the_companion_matrix(rng):
    K, M = symmetric(rng, 40.0), symmetric(rng, 20.0)
    G = rng.standard_normal((SIZE, SIZE))
    G = G - G.T
    shift, count = 0.3, 4
    pairs = _cpp.solve.quadratic_eigenpairs(matrix(K), matrix(G), matrix(M), count, shift, 1e-12, 500)
    assert len(pairs) >= count
    zero, one = np.zeros((SIZE, SIZE)), np.eye(SIZE)
    inverse = np.linalg.inv(M)
    expected = np.linalg.eigvals(np.block([[zero, one], [-inverse @ K, -inverse @ G]]))
    expected = expected[np.argsort(np.abs(expected - shift))]
    for s, real, imaginary in pairs[:count]:
        assert np.abs(expected - s).min() < 1e-9 * abs(s)
        assert abs(s - shift) < abs(expected[count + 1] - shift)  # pairs have the same distance
        x = real.array + 1j * imaginary.array
        assert np.linalg.norm((s * s * M + s * G + K) @ x) < 1e-9 * np.linalg.norm(K @ x)
