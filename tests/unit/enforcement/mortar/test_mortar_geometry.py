# SPDX-License-Identifier: MIT
"""Matrices of the nodal geometry against plain loops over the nodes."""

import numpy as np
import pytest
from mpi4py import MPI
from initial_penetration_checks import Square, overlapping_blocks

import dolfinx_impact as di


@pytest.fixture(autouse=True)
def alone():
    assert MPI.COMM_WORLD.size == 1, "dense matrices of one rank"


def dense(A):
    made = A.convert("dense")  # the array is a view of it
    return made.getDenseArray().copy()


def test_springs_between_bodies(rng):
    """J^T B J with the jump J u = u_j - sum_l (D^-1 M)_jl u_l of each node."""
    geometry = overlapping_blocks(0.01, di.Lagrange).contact[0].geometry
    rows = np.flatnonzero(geometry.participates)[::2].astype(np.int32)
    blocks = rng.normal(size=(len(rows), 2, 2))
    found = dense(geometry.springs(rows, blocks))
    num = geometry.index_map.size_local
    M = dense(geometry.integrals.M)
    expected = np.zeros((2 * num, 2 * num))
    for row, block in zip(rows, blocks):
        jump = -M[geometry.nodes[row]] / geometry.weight[row]
        jump[geometry.nodes[row]] += 1.0
        J = np.kron(jump, np.eye(2))
        expected += J.T @ block @ J
    assert np.count_nonzero(found) > 20
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-14 * np.abs(expected).max())
    assert not np.any(dense(geometry.springs(rows[:0], blocks[:0])))


@pytest.mark.parametrize("dim", (2, 3))
def test_stiffness_of_a_curved_obstacle(dim):
    """- D lambda dn/dx at the nodes in contact, and nothing elsewhere."""
    ball = di.RigidSphere(np.full(dim, 0.5) - 1.5 * np.eye(dim)[-1], 1.0)
    problem = Square(dim).problem(ball, di.Lagrange)
    geometry = problem.contact[0].geometry
    multiplier = np.linspace(0.0, 2.0, len(geometry.nodes))
    active = np.arange(len(geometry.nodes)) % 3 != 0
    found = geometry.tangent(multiplier, np.zeros((len(multiplier), dim)), active)
    assert found.getInfo()["nz_used"] == dim**2 * np.count_nonzero(active & (multiplier != 0.0))
    found = dense(found)
    expected = np.zeros_like(found)
    for i in np.flatnonzero(active):
        at = dim * geometry.nodes[i] + np.arange(dim)
        expected[np.ix_(at, at)] -= geometry.weight[i] * multiplier[i] * geometry.hessian[i]
    assert np.abs(expected).max() > 0.01
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * np.abs(expected).max())
