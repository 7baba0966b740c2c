# SPDX-License-Identifier: MIT
"""Symmetric systems with unsymmetric parts that factors leave out, and how long factors are kept."""

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from petsc4py import PETSc

import dolfinx_impact as di
from dolfinx_impact import _cpp
from dolfinx_impact.forms import elasticity
from dolfinx_impact.statics.linear_solver import LinearSolver

OPTIONS = {"pc_type": "cholesky", "ksp_rtol": 1e-13}


def space():
    domain = mesh.create_unit_square(MPI.COMM_SELF, 4, 3, mesh.CellType.quadrilateral)
    return fem.functionspace(domain, ("Lagrange", 1, (2,)))


def stiffness(V, young=1.0):
    u, v = ufl.TrialFunction(V), ufl.TestFunction(V)
    law = di.LinearElastic(young, 0.3, 1.0, "plane_strain").law(V.mesh)
    return di.Tangent(elasticity.tangent(None, u, v, law, ufl.dx)).assemble().copy()


def unsymmetric(K, rng, size):
    """A dense matrix, in PETSc's."""
    E = PETSc.Mat().createAIJ(K.getSizes(), comm=MPI.COMM_SELF, nnz=K.getSize()[1])
    E[:, :] = size * rng.standard_normal(K.getSize())
    E.assemble()
    return E


def left_edge(V):
    fixed = np.zeros(len(V.tabulate_dof_coordinates()) * 2, dtype=np.int8)
    fixed.reshape(-1, 2)[np.isclose(V.tabulate_dof_coordinates()[:, 0], 0.0)] = 1
    return fixed


def pinned(A, fixed):
    free = np.where(fixed, 0.0, 1.0)
    return free[:, None] * A * free + np.diag(1.0 - free)


def patient(V, iterations=0):
    limits = _cpp.solve.LinearSolverLimits()
    limits.patience = iterations
    return LinearSolver(V, OPTIONS, "impact_test_", limits=limits)


def test_solutions_are_those_of_the_whole_matrix_and_factors_those_of_the_symmetric_one(rng):
    V = space()
    K, fixed = stiffness(V), left_edge(V)
    E = unsymmetric(K, rng, 1e-4)
    system = _cpp.solve.PerturbedSystem(K, [E], fixed, 1.0)
    assert not system.symmetric
    A = pinned(K[:, :] + E[:, :], fixed)
    x, y = system.create_vector(), system.create_vector()
    x.array[:] = rng.standard_normal(len(fixed))
    system.mult(x, y)
    np.testing.assert_allclose(y.array, A @ x.array, rtol=0, atol=1e-14 * np.abs(A).sum(axis=1).max())
    bare = system.assemble()
    assert bare.isSymmetric(1e-15)
    np.testing.assert_allclose(bare[:, :], pinned(K[:, :], fixed), rtol=0, atol=1e-16)
    solver, b = patient(V), system.create_vector()
    assert solver.factors is None and solver.null_pivots == 0
    load, given = rng.standard_normal(len(fixed)), np.where(fixed, 0.01, 0.0)
    x.array[:] = given
    system.load(-load, x, b)
    assert solver.solve(system, b, x) is None
    expected = np.linalg.solve(A, np.where(fixed, given, load - (K[:, :] + E[:, :]) @ given))
    np.testing.assert_allclose(x.array, expected, rtol=0, atol=1e-10 * np.abs(expected).max())  # condition 1e3
    found = system.create_vector()
    solver.factors.solve(b, found)
    by_factors = np.linalg.solve(pinned(K[:, :], fixed), b.array)
    np.testing.assert_allclose(found.array, by_factors, rtol=0, atol=1e-10 * np.abs(by_factors).max())


def test_factors_are_kept_as_long_as_told(rng):
    V = space()
    K, fixed = stiffness(V), left_edge(V)
    solver = patient(V, 30)

    def solve(system):
        b, x = system.create_vector(), system.create_vector()
        b.array[:] = np.where(fixed, 0.0, rng.standard_normal(len(fixed)))
        assert solver.solve(system, b, x) is None
        y = system.create_vector()
        system.mult(x, y)
        assert (y - b).norm() < 1e-11 * b.norm()

    first = _cpp.solve.PerturbedSystem(K, [], fixed, 1.0)
    solver.set_up(first)
    assert solver.num_set_ups == 1 and solver.factors is not None
    for size in (1e-5, 1e-4):
        solve(_cpp.solve.PerturbedSystem(K, [unsymmetric(K, rng, size)], fixed, 1.0))
    assert solver.num_set_ups == 1, "few iterations: the factors of the first system serve"
    far = _cpp.solve.PerturbedSystem(K, [unsymmetric(K, rng, 1.0)], fixed, 1.0)
    solve(far)
    assert solver.num_set_ups == 2, "more iterations than told"
    solve(far)
    assert solver.num_set_ups == 2, "factors of the same system are not made twice"
    solver.reset()
    assert solver.factors is None
    solver.set_up(first)
    assert solver.num_set_ups == 3


@pytest.mark.parametrize("held, motions", ((False, 3), (True, 0)))
def test_motions_that_nothing_holds_are_counted(rng, held, motions):
    """The unsymmetric part would hold the body, but it is not factorised."""
    V = space()
    K, fixed = stiffness(V), left_edge(V)
    solver = patient(V)
    fixed = fixed if held else 0 * fixed
    solver.set_up(_cpp.solve.PerturbedSystem(K, [unsymmetric(K, rng, 1e-2)], fixed, 1.0))
    assert solver.null_pivots == motions
