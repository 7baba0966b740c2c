# SPDX-License-Identifier: MIT
"""Gaps, forces and tangents of a pair whose cells are spread over the ranks at random, against those of one rank that
has everything. See on_ranks.py."""

import numpy as np
from mpi4py import MPI
from penalty_model import Deformable, smooth

COMM = MPI.COMM_WORLD
KINDS = [("quadrilateral", 1, 1), ("triangle", 2, 2), ("hexahedron", 1, 1), ("tetrahedron", 1, 2)]
# Positions are the same to one rounding on all ranks; Newton's method ends within 1e-13 of the same point.
SAME_GAP = 1e-12
SAME_SUM = 1e-10  # entries that cancel, added in other orders; relative to the sum of their sizes


def in_order(comm, x, *values):
    """Points of all ranks in the order of their places."""
    x, *values = [np.concatenate(comm.allgather(v)) for v in (x, *values)]
    order = np.lexsort(np.round(x, 9).T)
    return [v[order] for v in (x, *values)]


def kinds():
    for kind in KINDS:
        for seed in (None, 5) if kind == KINDS[0] else (6,):
            for shift in (0.0, 0.3):  # covered by the master, and partly beside it
                yield kind, seed, shift


def pair(kind, comm, seed, shift, **more):
    dim = 2 if kind[0] in ("quadrilateral", "triangle") else 3
    return Deformable(*kind, comm, seed=seed, offset=(0.05 + shift,) * (dim - 1), **more)


def check_gaps():
    """The same gaps, normals and pressures, wherever cells lie; points beside the master are open."""
    for kind, seed, shift in kinds():
        results = []
        for comm in (COMM, MPI.COMM_SELF):
            model = pair(kind, comm, seed if comm is COMM else None, shift, reach=0.2)
            state = model.state(smooth(model.V, 0.02))
            p = model.points
            results.append(in_order(comm, p.x, p.gap, p.normal, p.weight, state.pressure, state.status))
        for found, expected in zip(*results):
            assert found.shape == expected.shape
            finite = np.isfinite(expected)
            assert np.array_equal(finite, np.isfinite(found))
            assert np.abs(found[finite] - expected[finite]).max() < SAME_GAP * (50 if expected.ndim == 2 else 1)
        x, gap, _, _, pressure, status = results[0]
        beside = x[:, 0] > 1.1
        assert beside.any() == (shift > 0)
        assert np.all(gap[beside] > 0) and np.all(status[beside] == 0)
        assert np.any(status > 0)


def form(comm, model, u):
    """Numbers that do not depend on the numbering: force . w and v . K w for some functions v, w."""
    functions = [smooth(model.V, 1.0, phase)[: model.num] for phase in (0.3, 1.7, 4.0)]
    f = model.force(u)
    whole = [np.concatenate(comm.allgather(w)) for w in functions]
    rows, cols, values = model.tangent(u)
    numbers, sizes = [], []
    for w in functions:
        numbers.append(comm.allreduce(f @ w))
        sizes.append(comm.allreduce(np.abs(f * w).sum()))
    for v in whole:
        for w in whole:
            terms = v[rows] * values * w[cols]
            numbers.append(comm.allreduce(terms.sum()))
            sizes.append(comm.allreduce(np.abs(terms).sum()))
    return np.array(numbers), np.array(sizes)


def check_forces():
    """Assembled forces and tangents, with friction and history, are those of one rank."""
    for kind, seed, shift in kinds():
        results = []
        for comm in (COMM, MPI.COMM_SELF):
            model = pair(kind, comm, seed if comm is COMM else None, shift, friction=0.3)
            model.u_n = smooth(model.V, 0.02, 1.0)
            x = model.points.x
            model.history.traction = 0.1 * np.cos(5 * x + 1).ravel()
            results.append(form(comm, model, smooth(model.V, 0.02)))
        (found, sizes), (expected, _) = results
        assert np.abs(expected).max() > 1e-3
        assert np.all(np.abs(found - expected) < SAME_SUM * sizes)
