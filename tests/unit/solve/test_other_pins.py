# SPDX-License-Identifier: MIT
"""Multigrid hierarchies serve systems in which other unknowns are pinned, whatever the size of pinned rows."""

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import _cpp

LARGE = 1e3  # entries of pinned rows over the mean diagonal: a fine part of a mesh has a stiffness as small as this
RTOL = 1e-8


def cube():
    """Problem of a cube that stands on its lower side, by multigrid, and nodes of a part of its upper side."""
    domain = mesh.create_unit_cube(MPI.COMM_SELF, 8, 8, 8, mesh.CellType.hexahedron)
    V = fem.functionspace(domain, ("Lagrange", 1, (3,)))
    below = mesh.locate_entities_boundary(domain, 2, lambda x: x[2] < 1e-9)
    clamp = fem.dirichletbc(np.zeros(3), fem.locate_dofs_topological(V, 2, below), V)
    problem = di.StaticProblem(fem.Function(V), di.LinearElastic(1.0, 0.3), bcs=[clamp], options={"pc_type": "gamg"})
    x = V.tabulate_dof_coordinates()
    return problem, np.flatnonzero((x[:, 2] > 1 - 1e-9) & (np.hypot(x[:, 0] - 0.5, x[:, 1] - 0.5) < 0.3))


@pytest.mark.parametrize("closes", (True, False))
def test_iterations_with_a_hierarchy_of_other_pins(closes):
    problem, nodes = cube()
    solver, K = problem.linear_solver, problem.tangent.assemble()
    free = problem.fixed[: problem.num_owned].astype(bool)
    held = free.copy()
    held[3 * nodes + 2] = True
    diagonal = LARGE * np.abs(K.getDiagonal().array).mean()
    first, second = (_cpp.solve.CondensedSystem(K, [], True, None, pins, diagonal)
                     for pins in ((free, held) if closes else (held, free)))  # fmt: skip
    load = np.random.default_rng(1).standard_normal(problem.num_owned)

    def iterations(system):
        x, b = system.create_vector(), system.create_vector()
        x.set(0.0)
        system.load(load, x, b)
        before = solver.num_iterations
        assert not solver.solve(system, b, x, RTOL)
        r = b.duplicate()
        system.mult(x, r)
        assert (r - b).norm() <= 1.1 * RTOL * b.norm()
        return solver.num_iterations - before

    own = iterations(first)
    other = iterations(second)
    assert solver.num_set_ups == 1
    if closes:
        # Each row of the size of LARGE would be an eigenvalue far from the others, and take an iteration at least.
        assert other < own + 0.75 * len(nodes)
    else:
        # Freed unknowns are relaxed with what they do to their neighbours: 26 iterations after 23, without that 35.
        assert other <= own + 6
