# SPDX-License-Identifier: MIT
"""Level ranks, explicit dynamics: a block thrown obliquely at another one, with friction, 1,000 steps."""

import numpy as np
from dolfinx import fem

from .. import contact, meshes
from ..dynamics.explicit import ExplicitProblem
from ..loads import Traction
from ..materials import NeoHookean

CASES = (
    ("quadrilateral", 1, "plane_strain", ("penalty", "balanced", "kinematic")),
    ("tetrahedron", 1, "3d", ("penalty", "kinematic")),
)
STEPS, PART = 1000, 0.5  # steps, and their length over the stable one
REASON = "round-off of 1,000 steps with contact"
FRICTION, PRESS = 0.3, 5.0


def values(comm, gather):
    """Arrays of every case and method. Collective.

    Args:
        gather: function of a space and an array over its dofs.
    """
    out = {}
    for cell, degree, hypothesis, methods in CASES:
        for method in methods:
            problem = _run(comm, cell, degree, hypothesis, method)
            key, V = f"{cell}|{degree}|{hypothesis}|explicit.{method}", problem.space
            out[f"{key}_u"] = gather(V, problem.u.x.array)
            out[f"{key}_velocity"] = gather(V, problem.velocity.x.array)
            out[f"{key}_force"] = problem.force_history[0].tolist()
            out[f"{key}_energy"] = problem.energy_history[:, 1:].tolist()
    return out


def _run(comm, cell, degree, hypothesis, method):
    """The block slides, pressed down, over what other ranks have of the lower one.

    Raises:
        RuntimeError: there was no contact, or no slip, that could be compared.
    """
    dim = 3 if hypothesis == "3d" else 2
    # Offset, so that no edge is on an edge: round-off must not decide who touches.
    sizes = {"lower": (2.5, 0.5), "upper": (0.6, 0.4), "lower_cells": (13, 3), "upper_cells": (4, 3), "offset": 0.1}
    if dim == 3:
        sizes = {"lower": (2.5, 1.0, 0.5), "upper": (0.6, 0.5, 0.4), "lower_cells": (10, 4, 2),
                 "upper_cells": (3, 3, 2), "offset": (0.1, 0.23)}  # fmt: skip
    m = meshes.make("two_blocks", comm, cell=cell, gap=0.003, **sizes)
    V = fem.functionspace(m.mesh, ("Lagrange", degree, (dim,)))
    velocity = fem.Function(V)
    upper = V.tabulate_dof_coordinates()[:, dim - 1] > 0.5015
    velocity.x.array.reshape(-1, dim)[upper] = (3.0,) + (0.0,) * (dim - 2) + (-0.5,)
    held = fem.locate_dofs_topological(V, dim - 1, m.facet_tags.find(m.tags["bottom"]))
    pair = contact.ContactPair(m.facet_tags, m.tags["slave_surface"], m.tags["master_surface"], FRICTION)
    enforce = contact.Kinematic(pair) if method == "kinematic" else contact.Penalty(pair, balanced=method == "balanced")
    press = Traction(m.facet_tags, m.tags["top"], (0.0,) * (dim - 1) + (-PRESS,))
    problem = ExplicitProblem(
        fem.Function(V), NeoHookean(1e3, 0.3, 1.0, hypothesis), velocity=velocity, loads=[press],
        bcs=[fem.dirichletbc(np.zeros(dim), held, V)], contact=[enforce],
    )  # fmt: skip
    dt = PART * problem.stable_step()
    problem.advance(STEPS * dt, dt=dt, progress=False)
    lost = problem.contact[0].dissipated / problem.energy_history[0, 1]
    forces = np.linalg.norm(problem.force_history[0], axis=1)
    # On more ranks contact that is lost shows as a difference.
    if comm.size == 1 and not (lost > 0.1 and np.count_nonzero(forces[-100:])):
        raise RuntimeError(
            f"explicit.{method} on {cell}: friction took {lost:.1%} of the energy: too little is compared"
        )
    return problem
