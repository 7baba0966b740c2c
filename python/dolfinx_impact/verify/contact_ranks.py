# SPDX-License-Identifier: MIT
"""Level ranks, contact: a block pressed on another one and pulled sideways, by the methods of the UFL side."""

import numpy as np
from dolfinx import fem

from .. import contact, meshes
from ..statics.problem import StaticProblem
from .contact_bodies import steel

CASES = (
    ("quadrilateral", 2, "plane_strain", ("lagrange", "penalty", "augmented")),
    ("tetrahedron", 1, "3d", ("lagrange", "penalty")),
)
PUSH, PULL, GAP = 0.02, 0.01, 0.002  # bodies apart: their nodes have places of their own
FRICTION, PENALTY = 0.3, 20.0


def values(comm, gather):
    """Arrays of every case and solver. Collective.

    Args:
        gather: function of a space and an array over its dofs.
    """
    out = {}
    for cell, degree, hypothesis, solvers in CASES:
        for solver in solvers:
            problem, start = _solve(comm, cell, degree, hypothesis, solver)
            key = f"{cell}|{degree}|{hypothesis}|contact.{solver}"
            V, enforced = problem.space, problem.contact[0]
            out[f"{key}_u"] = gather(V, start)
            out[f"{key}_friction_u"] = gather(V, problem.u.x.array)
            out[f"{key}_force"] = gather(V, enforced.contact_forces())
            out[f"{key}_total"] = [enforced.force.tolist()]
    return out


def _solve(comm, cell, degree, hypothesis, solver):
    dim = 3 if hypothesis == "3d" else 2
    # The slave is long and has most of the cells: the cut between the ranks goes through the contact.
    sizes, cells = {"lower": (2.0, 0.5), "upper": (1.6, 0.25)}, {"lower_cells": (12, 3), "upper_cells": (9, 1)}
    if dim == 3:
        sizes, cells = {"lower": (2, 0.5, 0.5), "upper": (1.6, 0.4, 0.25)}, {
            "lower_cells": (8, 2, 2), "upper_cells": (5, 2, 1)}  # fmt: skip
    m = meshes.make("two_blocks", comm, cell=cell, gap=GAP, **sizes, **cells)
    V = fem.functionspace(m.mesh, ("Lagrange", degree, (dim,)))
    u = fem.Function(V, name="u")
    still, moving = (fem.Constant(m.mesh, np.zeros(dim)) for _ in range(2))
    bcs = [
        fem.dirichletbc(value, fem.locate_dofs_topological(V, dim - 1, m.facet_tags.find(m.tags[name])), V)
        for name, value in (("bottom", still), ("top", moving))
    ]
    pair = contact.ContactPair(m.facet_tags, m.tags["master_surface"], m.tags["slave_surface"], FRICTION)
    method = contact.Lagrange(pair)
    if solver != "lagrange":
        method = contact.Penalty(pair, PENALTY, augmented=solver == "augmented")
    problem = StaticProblem(u, steel(hypothesis), bcs=bcs, contact=[method])
    moving.value[-1] = -PUSH
    problem.solve(rtol=1e-13)
    pressed = u.x.array.copy()
    moving.value[0] = PULL
    problem.solve(rtol=1e-13)
    return problem, pressed
