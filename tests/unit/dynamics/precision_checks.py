# SPDX-License-Identifier: MIT
"""Mixed precision on several ranks. See on_ranks.py."""

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di

COMM = MPI.COMM_WORLD


def check_what_float_is_not_for_is_refused_on_all_ranks():
    domain = mesh.create_unit_cube(COMM, 3, 2, 2, mesh.CellType.hexahedron)
    u = fem.Function(fem.functionspace(domain, ("Lagrange", 1, (3,))))
    plastic = di.J2Plasticity(1e3, 0.3, density=1.0, yield_stress=1.0)
    with pytest.raises(ValueError, match="found J2Plasticity"):
        di.ExplicitProblem(u, plastic, precision="mixed")
    mine = "float" if COMM.rank == COMM.size - 1 else "mixed"
    with pytest.raises(ValueError, match="'float'"):
        di.ExplicitProblem(u, di.LinearElastic(1e3, 0.3, 1.0), precision=mine)


def check_the_run_is_that_of_double():
    """Ghosts are summed in double: errors are those of one rank, of the forces of the steps (test_precision.py)."""
    domain = mesh.create_unit_cube(COMM, 4, 3, 3, mesh.CellType.hexahedron)
    V = fem.functionspace(domain, ("Lagrange", 1, (3,)))
    end = {}
    for precision in ("double", "mixed"):
        velocity = fem.Function(V)
        velocity.interpolate(lambda x: 0.1 * np.sin(3.0 * x[[1, 2, 0]]))
        problem = di.ExplicitProblem(
            fem.Function(V), di.LinearElastic(1e3, 0.3, 1.0), velocity=velocity, precision=precision
        )
        dt = 0.5 * problem.stable_step()
        problem.advance(20 * dt, dt=dt, progress=False)
        end[precision] = problem.u.x.array.copy()
    largest = COMM.allreduce(np.abs(end["double"]).max(), MPI.MAX)
    error = COMM.allreduce(np.abs(end["mixed"] - end["double"]).max(), MPI.MAX) / largest
    assert 0.0 < error < 20 * 40 * 2.0**-24
