# SPDX-License-Identifier: MIT
"""Level ranks, contact: a block pressed on another one and pulled sideways, by the methods of the UFL side."""

from collections.abc import Callable
from typing import Any

import numpy as np
from dolfinx import fem
from dolfinx.fem import FunctionSpace
from mpi4py import MPI

from dolfinx_impact import contact, meshes  # type: ignore[attr-defined,unused-ignore]  # installed beside it
from dolfinx_impact.common.types import FloatArray
from dolfinx_impact.statics.static_problem import StaticProblem
from .contact_bodies import steel

CASES = (
    ("quadrilateral", 2, "plane_strain", ("lagrange", "penalty", "augmented")),
    ("tetrahedron", 1, "3d", ("lagrange", "penalty")),
)
PUSH, PULL, GAP = 0.02, 0.01, 0.002  # [L]; with a gap no two nodes have the same position
FRICTION, PENALTY = 0.3, 20.0


def values(comm: MPI.Intracomm, gather: Callable[[FunctionSpace, FloatArray], list[Any] | None]) -> dict[str, Any]:
    """Results of every case and solver. Collective.

    Args:
        comm: communicator of the meshes.
        gather: function of a space and an array over its degrees of freedom that returns all values on rank 0.

    Returns:
        Values by "cell|degree|hypothesis|solver_quantity"; on other ranks than 0 gathered values are None.
    """
    out: dict[str, Any] = {}  # numbers in nested lists, as JSON has them
    for cell, degree, hypothesis, solvers in CASES:
        for solver in solvers:
            problem, pressed = _solve(comm, cell, degree, hypothesis, solver)
            key = f"{cell}|{degree}|{hypothesis}|contact.{solver}"
            V, enforced = problem.space, problem.contact[0]
            out[f"{key}_u"] = gather(V, pressed)
            out[f"{key}_friction_u"] = gather(V, problem.u.x.array)
            out[f"{key}_force"] = gather(V, enforced.contact_forces())
            out[f"{key}_total"] = [np.asarray(enforced.force).tolist()]
    return out


def _solve(
    comm: MPI.Intracomm, cell: str, degree: int, hypothesis: str, solver: str
) -> tuple[StaticProblem, FloatArray]:
    """Problem after pressing and pulling, and its displacements after pressing alone."""
    dim = 3 if hypothesis == "3d" else 2
    # The slave is long and has most of the cells, so that the partition divides the contact surface.
    sizes: dict[str, tuple[float, ...]] = {"lower": (2.0, 0.5), "upper": (1.6, 0.25)}
    cells: dict[str, tuple[int, ...]] = {"lower_cells": (12, 3), "upper_cells": (9, 1)}
    if dim == 3:
        sizes = {"lower": (2, 0.5, 0.5), "upper": (1.6, 0.4, 0.25)}
        cells = {"lower_cells": (8, 2, 2), "upper_cells": (5, 2, 1)}
    m = meshes.make("two_blocks", comm, cell=cell, gap=GAP, **sizes, **cells)
    V = fem.functionspace(m.mesh, ("Lagrange", degree, (dim,)))
    u = fem.Function(V, name="u")
    zero, moving = (fem.Constant(m.mesh, np.zeros(dim)) for _ in range(2))
    bcs = [
        fem.dirichletbc(value, fem.locate_dofs_topological(V, dim - 1, m.facet_tags.find(m.tags[name])), V)
        for name, value in (("bottom", zero), ("top", moving))
    ]
    pair = contact.ContactPair(m.facet_tags, m.tags["master_surface"], m.tags["slave_surface"], FRICTION)
    method: contact.Lagrange | contact.Penalty = contact.Lagrange(pair)
    if solver != "lagrange":
        method = contact.Penalty(pair, PENALTY, augmented=solver == "augmented")
    problem = StaticProblem(u, steel(hypothesis), bcs=bcs, contact=[method])
    moving.value[-1] = -PUSH
    problem.solve(rtol=1e-13)
    pressed = u.x.array.copy()
    moving.value[0] = PULL
    problem.solve(rtol=1e-13)
    return problem, pressed
