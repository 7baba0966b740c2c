# SPDX-License-Identifier: MIT
"""Level ranks, explicit dynamics: a block thrown obliquely at another one, with friction, 1,000 steps."""

from collections.abc import Callable
from typing import Any

import numpy as np
from dolfinx import fem
from dolfinx.fem import FunctionSpace
from mpi4py import MPI

from dolfinx_impact import contact, meshes  # type: ignore[attr-defined,unused-ignore]  # installed beside it
from dolfinx_impact.common.types import FloatArray
from dolfinx_impact.dynamics.explicit import ExplicitProblem
from dolfinx_impact.loads import Traction
from dolfinx_impact.materials import NeoHookean

CASES = (
    ("quadrilateral", 1, "plane_strain", ("penalty", "balanced", "kinematic")),
    ("tetrahedron", 1, "3d", ("penalty", "kinematic")),
)
STEPS, STEP_FRACTION = 1000, 0.5  # number of steps, and their length over the stable step [1]
REASON = "round-off of 1,000 steps with contact"
FRICTION, PRESSURE = 0.3, 5.0  # [1], [F/L^2]


def values(comm: MPI.Intracomm, gather: Callable[[FunctionSpace, FloatArray], list[Any] | None]) -> dict[str, Any]:
    """Results of every case and method. Collective.

    Args:
        comm: communicator of the meshes.
        gather: function of a space and an array over its degrees of freedom that returns all values on rank 0.

    Returns:
        Values by "cell|degree|hypothesis|method_quantity"; on other ranks than 0 gathered values are None.

    Raises:
        RuntimeError: friction dissipates too little energy for a comparison.
    """
    out: dict[str, Any] = {}  # numbers in nested lists, as JSON has them
    for cell, degree, hypothesis, methods in CASES:
        for method in methods:
            problem = _run(comm, cell, degree, hypothesis, method)
            key, V = f"{cell}|{degree}|{hypothesis}|explicit.{method}", problem.space
            out[f"{key}_u"] = gather(V, problem.u.x.array)
            out[f"{key}_velocity"] = gather(V, problem.velocity.x.array)
            out[f"{key}_force"] = problem.force_history[0].tolist()
            out[f"{key}_energy"] = problem.energy_history[:, 1:].tolist()
    return out


def _run(comm: MPI.Intracomm, cell: str, degree: int, hypothesis: str, method: str) -> ExplicitProblem:
    """Run in which the pressed upper block slides over parts of the lower one that other ranks own.

    Raises:
        RuntimeError: friction dissipates too little energy for a comparison.
    """
    dim = 3 if hypothesis == "3d" else 2
    # An offset, so that no edges coincide: round-off must not decide which nodes are in contact.
    sizes: dict[str, float | tuple[float, ...]]
    sizes = {"lower": (2.5, 0.5), "upper": (0.6, 0.4), "lower_cells": (13, 3), "upper_cells": (4, 3), "offset": 0.1}
    if dim == 3:
        sizes = {"lower": (2.5, 1.0, 0.5), "upper": (0.6, 0.5, 0.4), "lower_cells": (10, 4, 2),
                 "upper_cells": (3, 3, 2), "offset": (0.1, 0.23)}  # fmt: skip
    m = meshes.make("two_blocks", comm, cell=cell, gap=0.003, **sizes)
    V = fem.functionspace(m.mesh, ("Lagrange", degree, (dim,)))
    velocity = fem.Function(V)
    upper = V.tabulate_dof_coordinates()[:, dim - 1] > 0.5015
    velocity.x.array.reshape(-1, dim)[upper] = (3.0,) + (0.0,) * (dim - 2) + (-0.5,)
    fixed_nodes = fem.locate_dofs_topological(V, dim - 1, m.facet_tags.find(m.tags["bottom"]))
    pair = contact.ContactPair(m.facet_tags, m.tags["slave_surface"], m.tags["master_surface"], FRICTION)
    enforcement: contact.Kinematic | contact.Penalty = contact.Kinematic(pair)
    if method != "kinematic":
        enforcement = contact.Penalty(pair, balanced=method == "balanced")
    load = Traction(m.facet_tags, m.tags["top"], (0.0,) * (dim - 1) + (-PRESSURE,))
    problem = ExplicitProblem(
        fem.Function(V), NeoHookean(1e3, 0.3, 1.0, hypothesis), velocity=velocity, loads=[load],
        bcs=[fem.dirichletbc(np.zeros(dim), fixed_nodes, V)], contact=[enforcement],
    )  # fmt: skip
    dt = STEP_FRACTION * problem.stable_step()
    problem.advance(STEPS * dt, dt=dt, progress=False)
    dissipated = problem.contact[0].dissipated / problem.energy_history[0, 1]
    forces = np.linalg.norm(problem.force_history[0], axis=1)
    # On more ranks a lost contact appears as a difference.
    if comm.size == 1 and not (dissipated > 0.1 and np.count_nonzero(forces[-100:])):
        raise RuntimeError(
            f"explicit.{method} on {cell}: friction took {dissipated:.1%} of the energy: too little is compared"
        )
    return problem
