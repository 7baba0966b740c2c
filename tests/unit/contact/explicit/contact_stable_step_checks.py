# SPDX-License-Identifier: MIT
"""The stable step with springs of given stiffness, serial and cut by the ranks. See on_ranks.py."""

import numpy as np
from dolfinx import fem
from mpi4py import MPI
from over_ranks import largest

import dolfinx_impact as di
from dolfinx_impact import compat, meshes

COMM = MPI.COMM_WORLD


def pressed(comm, friction, balanced):
    """Two blocks whose nodes match, pressed together in equilibrium by stiff springs."""
    made = meshes.make("two_blocks", comm, cell="quadrilateral", gap=0.0, lower=(1.0, 0.5), upper=(1.0, 0.5),
                       lower_cells=(4, 2), upper_cells=(4, 2))  # fmt: skip
    V = fem.functionspace(made.mesh, ("Lagrange", 1, (2,)))
    tags, facets, (E, p, chi) = made.tags, made.facet_tags, (1e3, 1.0, 8e4)
    upper = made.mesh.geometry.x[compat.geometry_dofmap(made.mesh)][:, :, 1].mean(axis=1) > 0.5
    nodes, x = np.unique(V.dofmap.list[upper]), V.tabulate_dof_coordinates()
    u, v = fem.Function(V), fem.Function(V)
    rows = u.x.array.reshape(-1, 2)
    rows[:, 1] = -p / E * x[:, 1]
    rows[nodes, 1] -= p / chi
    # Small, and without regard to how nodes are numbered.
    v.x.array.reshape(-1, 2)[:] = 1e-8 * np.sin(1e3 * x @ [[1.3, 2.9], [3.1, 1.7], [0.0, 0.0]])
    bottom = fem.locate_dofs_topological(V, 1, facets.find(tags["bottom"]))
    rows[bottom] = v.x.array.reshape(-1, 2)[bottom] = 0.0
    pair = di.ContactPair(facets, tags["slave_surface"], tags["master_surface"], friction=friction)
    return di.ExplicitProblem(
        u, di.LinearElastic(E, 0.0, 1.0, "plane_strain"), velocity=v,
        loads=[di.Traction(facets, tags["top"], (0.0, -p))], bcs=[fem.dirichletbc(np.zeros(2), bottom, V)],
        contact=[di.Penalty(pair, penalty=chi, balanced=balanced)],
    )  # fmt: skip


def strayed(comm, friction, balanced, part, steps):
    """How far from equilibrium a run with a part of the limit strays; the limit."""
    problem = pressed(comm, friction, balanced)
    start, limit = problem.u.x.array.copy(), problem.stable_step("eigenvalue")
    problem.advance(steps * part * limit, dt=part * limit, progress=False, unsafe=True)
    return largest(np.abs(problem.u.x.array - start), comm), limit


def check_stiff_springs_set_the_limit():
    """0.99 of the limit runs on; with 1.01 what is small grows by exp(0.28) a step. The springs lower the limit; it is
    that of one rank."""
    for friction, balanced in ((0.0, False), (0.3, False), (0.3, True)):
        runs_on, limit = strayed(COMM, friction, balanced, 0.99, 1000)
        blows_up, _ = strayed(COMM, friction, balanced, 1.01, 80)
        assert runs_on < 1e-9 and blows_up > 1e-6, (runs_on, blows_up)  # it starts with 1e-11 a step
        squares, _ = pressed(COMM, friction, balanced).frequencies_by_cell()
        free = 2.0 / np.sqrt(largest(squares, COMM))
        assert limit < 0.4 * free
        alone = pressed(MPI.COMM_SELF, friction, balanced).stable_step("eigenvalue")
        assert abs(limit / alone - 1) < 1e-8  # tolerance of the eigenvalue
