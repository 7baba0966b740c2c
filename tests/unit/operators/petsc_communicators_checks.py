# SPDX-License-Identifier: MIT
"""Problems on one mesh and space that end at different times on the ranks of COMM_WORLD; see on_ranks.py.

PETSc frees its copy of a communicator with the last object on it, and Python's garbage collector ends objects when it
likes: without a copy that is kept the next problem would wait for ever, some ranks making a copy and others not.
"""

import gc

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI
from operator_checks import body, hypothesis

import dolfinx_impact as di

COMM = MPI.COMM_WORLD


def static(V):
    problem = di.StaticProblem(fem.Function(V, name="u"), material(V), bcs=[held(V)], loads=[weight(V)])
    problem.solve()
    return problem


def implicit(V):
    problem = di.NewmarkProblem(fem.Function(V, name="u"), material(V), bcs=[held(V)], loads=[weight(V)])
    problem.advance(until=0.1, dt=0.1)
    return problem


def own_residual(V):
    u, v = fem.Function(V, name="u"), ufl.TestFunction(V)
    problem = di.StaticProblem(u, residual=ufl.inner(ufl.grad(u), ufl.grad(v)) * ufl.dx, bcs=[held(V)])
    problem.solve()
    return problem


def matrix(V):
    tangent = di.Tangent(ufl.inner(ufl.grad(ufl.TrialFunction(V)), ufl.grad(ufl.TestFunction(V))) * ufl.dx)
    tangent.assemble()
    return tangent


KINDS = (static, implicit, own_residual, matrix)


def material(V):
    return di.LinearElastic(10.0, 0.3, 1.0, hypothesis(V.mesh))


def weight(V):
    return di.BodyForce(np.ones(V.mesh.geometry.dim))


def held(V):
    dofs = fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[0], 0.0))
    return fem.dirichletbc(np.zeros(V.mesh.geometry.dim), dofs, V)


def space(domain):
    return fem.functionspace(domain, ("Lagrange", 1, (domain.geometry.dim,)))


def end_on_some_ranks(problem):
    """What is left of a problem: it lives on rank 0 alone."""
    left = [problem] if COMM.rank == 0 else []
    del problem
    gc.collect()
    return left


def check_a_second_problem_on_the_same_space():
    for first in KINDS:
        for second in KINDS:
            V = space(body("quadrilateral"))
            left = end_on_some_ranks(first(V))
            second(V)
            assert len(left) == (COMM.rank == 0)


def check_a_second_space_on_the_same_mesh():
    for first in KINDS:
        domain = body("quadrilateral")
        left = end_on_some_ranks(first(space(domain)))
        gc.collect()
        for second in KINDS:
            second(space(domain))
        assert len(left) == (COMM.rank == 0)
