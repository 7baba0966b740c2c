# SPDX-License-Identifier: MIT
"""Problems that are no longer used give back their memory, on any number of ranks."""

import gc
import weakref

import numpy as np
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.common import memory

COMM = MPI.COMM_WORLD
CELLS = 16  # along each side: factors of 60 MB and more


def resident():
    """Memory of this process [MB]."""
    with open("/proc/self/status", encoding="ascii") as file:
        return next(int(line.split()[1]) / 1e3 for line in file if line.startswith("VmRSS"))


def solve(V, options):
    """Pull a block of one space; problem and contacts go at the end, their solver is returned as a weak reference."""
    u, domain = fem.Function(V), V.mesh
    ends = [mesh.locate_entities_boundary(domain, 2, lambda x, z=z: np.isclose(x[2], z)) for z in (0.0, 1.0)]
    bottom = fem.dirichletbc(np.zeros(3), fem.locate_dofs_topological(V, 2, ends[0]), V)
    top = mesh.meshtags(domain, 2, np.sort(ends[1]), np.full(len(ends[1]), 1, dtype=np.int32))
    plane = di.RigidPlane(point=(0.0, 0.0, 1.0), normal=(0.0, 0.0, -1.0))
    problem = di.StaticProblem(
        u, di.LinearElastic(1e9, 0.3, 1.0), bcs=[bottom], loads=[di.Traction(top, 1, (0.0, 0.0, 1e5))],
        contact=[di.Lagrange(di.ContactPair(top, 1, plane))], options=options,
    )  # fmt: skip
    problem.solve()
    return weakref.ref(problem), weakref.ref(problem.linear_solver)


def check_solvers_are_freed():
    """PETSc's objects do not keep the solver that made them, and do not outlive it on several ranks."""
    domain = mesh.create_box(COMM, [[0.0] * 3, [1.0] * 3], [CELLS] * 3, mesh.CellType.hexahedron)
    V = fem.functionspace(domain, ("Lagrange", 1, (3,)))
    for options in (None, {"ksp_type": "cg", "pc_type": "gamg"}):
        found, sizes = [], []
        for _ in range(4):
            found.append(solve(V, options))
            gc.collect()
            memory.free_garbage(domain.comm, 0)
            sizes.append(resident())
        assert all(reference() is None for pair in found for reference in pair)
        # The first leaves what libraries keep; factors take 60 MB and more a problem, a hierarchy some 15.
        grown = max(COMM.allgather(sizes[-1] - sizes[1]))
        assert grown < (60.0 if options is None else 20.0) / COMM.size, sizes


def check_large_problems_collect_small_ones_do_not():
    """Problems lie in reference cycles: without a collection they would wait for one."""
    V = fem.functionspace(mesh.create_unit_cube(COMM, 3, 3, 3, mesh.CellType.hexahedron), ("Lagrange", 1, (3,)))
    found = []
    gc.collect()
    gc.disable()
    try:
        found.append(solve(V, None)[0])
        memory.free_garbage(COMM, memory.MANY - 1)
        assert found[0]() is not None, "without cycles no collection is needed any more"
        memory.free_garbage(COMM, memory.MANY)
        assert found[0]() is None
    finally:
        gc.enable()
