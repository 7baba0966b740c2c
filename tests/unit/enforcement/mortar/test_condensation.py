# SPDX-License-Identifier: MIT
"""Frames of constrained directions and the transformation that condenses multipliers, against dense algebra."""

import numpy as np
import pytest
from mpi4py import MPI
from petsc4py import PETSc

from dolfinx_impact import _cpp


def full_matrix(K):
    """Sparse matrix with all entries of a dense one."""
    size = len(K)
    csr = np.arange(0, size * size + 1, size, dtype=np.int32), np.tile(np.arange(size, dtype=np.int32), size), K.ravel()
    return PETSc.Mat().createAIJ((size, size), csr=csr, comm=MPI.COMM_SELF)


@pytest.mark.parametrize("gdim", (2, 3))
def test_frames(gdim, rng):
    """Orthonormal, with the freed normal as one column and prescribed axes at their own places."""
    normals = rng.normal(size=(50, gdim))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    fixed = np.zeros((50, gdim), dtype=bool)
    fixed[10:30, 0] = True
    fixed[30:40, gdim - 1] = True
    fixed[40:] = True
    frames, place, length = _cpp.multipliers.frames_at(normals, fixed)
    assert np.allclose(np.einsum("nab,nac->nbc", frames, frames), np.eye(gdim), atol=1e-13)
    assert np.all(place[40:] == -1) and np.all(place[:40] >= 0)
    for i in range(40):
        free = np.where(fixed[i], 0.0, normals[i])
        assert np.isclose(length[i], np.linalg.norm(free), rtol=1e-14)
        assert np.allclose(frames[i][:, place[i]], free / length[i], atol=1e-13)
        for a in np.flatnonzero(fixed[i]):
            assert np.array_equal(frames[i][:, a], np.eye(gdim)[a])


@pytest.mark.parametrize("slips", (False, True))
def test_condensed_system_equals_the_saddle_point(slips, rng):
    """K u = f + B^T z with constraints (and, slipping, t = friction * pressure * direction): the condensed system has
    the same solution as the dense one with multipliers. Round-off times the condition of a few hundred."""
    gdim, num = 2, 6  # nodes 0, 1 are slaves, 2..5 masters and others
    size = gdim * num
    K = rng.normal(size=(size, size))
    K = K @ K.T + 10 * np.eye(size)
    f = rng.normal(size=size)
    D = np.array([0.7, 1.3])
    M = np.zeros((2, num))
    M[0, 2:4], M[1, 3:5] = [0.3, 0.4], [0.5, 0.8]
    normals = np.array([[0.6, 0.8], [0.0, 1.0]])
    tangents = np.array([[0.8, -0.6], [1.0, 0.0]])
    gap = np.array([0.1, -0.2])  # weighted gap over D
    tilt = 0.3 * tangents if slips else np.zeros((2, 2))
    # Dense: unknowns u, lambda; force of node j on u: lambda_j (n + tilt) by D and -M.
    A = np.zeros((size + 2, size + 2))
    A[:size, :size] = K
    for j in range(2):
        row = np.zeros(num)
        row[j], row[2:] = D[j], -M[j, 2:]
        A[:size, size + j] = -np.kron(row, normals[j] + tilt[j])
        A[size + j, :size] = np.kron(row / D[j], normals[j])
    exact = np.linalg.solve(A, np.concatenate([f, -gap]))
    frames, place, length = _cpp.multipliers.frames_at(normals, np.zeros((2, 2), dtype=bool))
    constrained = np.zeros((2, 2), dtype=bool)
    constrained[[0, 1], place] = True
    known = np.zeros((2, 2))
    known[[0, 1], place] = -gap
    rows = _cpp.multipliers.Constraints(
        np.array([0, 1], dtype=np.int32), np.array([0, 1], dtype=np.int32),
        frames, frames, constrained, known, tilt, place,
        np.array([0, 2, 4]), np.array([2, 3, 3, 4]),
        np.array([0.3, 0.4, 0.5, 0.8]) / np.array([0.7, 0.7, 1.3, 1.3]),
    )  # fmt: skip
    comm = MPI.COMM_SELF
    transformation = _cpp.multipliers.Condensation(comm, size, 0, gdim, [rows])
    assert transformation.symmetric != slips
    P = full_matrix(K)
    b, x, product = P.createVecLeft(), P.createVecRight(), P.createVecLeft()
    system = _cpp.solve.CondensedSystem(P, [], True, transformation, transformation.pinned, 1.0)
    system.load(-f, x, b)
    A = system.assemble().convert("dense")
    dense = A.getDenseArray()
    x.array[:] = rng.normal(size=size)
    system.mult(x, product)  # without forming it
    assert np.allclose(product.array, dense @ x.array, atol=1e-11)
    assert np.allclose(dense, dense.T, rtol=0, atol=1e-12) != slips
    x.array[:] = np.linalg.solve(dense, b.array)
    u = transformation.increment(x)
    assert np.allclose(u, exact[:size], atol=1e-11)
    residual = K @ u - f
    along = np.einsum("na,na->n", residual.reshape(-1, gdim)[:2], normals) / D
    assert np.allclose(along, exact[size:], atol=1e-11)
    free = transformation.residual(residual)
    assert np.max(np.abs(free)) < 1e-11
    # Multipliers kept as unknowns, scaled by an entry of K's size: forces D (n + tilt) lambda.
    kept = _cpp.multipliers.SaddlePoint(comm, size, gdim, [2])
    kept.assign([rows], np.zeros(size, dtype=bool), np.zeros(4), 3.0)
    assert np.array_equal(kept.pinned[size:], ~constrained.ravel())
    system = _cpp.solve.SaddlePointSystem(P, [], kept)
    x, b, product = (system.create_vector() for _ in range(3))
    A = system.assemble().convert("dense")
    dense = A.getDenseArray()
    x.array[:] = rng.normal(size=len(x.array))
    system.mult(x, product)
    assert np.allclose(product.array, dense @ x.array, atol=1e-11)
    x.set(0.0)
    system.load(-f, x, b)
    x.array[:] = np.linalg.solve(dense, b.array)
    assert np.allclose(system.displacements(x), exact[:size], atol=1e-11)
    along = 3.0 * kept.forces(x).reshape(2, gdim)[[0, 1], place] / D
    assert np.allclose(along, exact[size:], atol=1e-11)
    # From a start with other forces the same solution is found.
    start = np.where(constrained, 0.1, 0.0).ravel()
    kept.assign([rows], np.zeros(size, dtype=bool), start, 3.0)
    assert np.array_equal(kept.unknowns(exact[:size], start), np.concatenate([exact[:size], np.zeros(4)]))
    x.set(0.0)
    system.load(-f, x, b)
    x.array[:] = np.linalg.solve(dense, b.array)
    assert np.allclose(3.0 * kept.forces(x).reshape(2, gdim)[[0, 1], place] / D, exact[size:], atol=1e-11)
