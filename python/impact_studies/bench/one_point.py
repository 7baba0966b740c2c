# SPDX-License-Identifier: MIT
"""Cost of cells with one point and hourglass control against full integration: whole explicit steps, and kernels."""

from collections.abc import Sequence
from functools import partial

import numpy as np
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

from dolfinx_impact import materials
from dolfinx_impact.assembly import operators
from dolfinx_impact.dynamics.explicit import ExplicitProblem
from .explicit import CELLS_PER_S, initial_velocity, step_seconds
from .rows import Job, Row, row
from .setup import Case, MaterialClass, best_time

CASES: Sequence[Case] = (("hexahedron", 1, 50), ("quadrilateral", 1, 400))
INTEGRATIONS = ("full", "reduced")
ROUNDS = 5


def one_point_rows(
    cell: str, n: int, steps: int = 60, rounds: int = ROUNDS, law: MaterialClass = materials.LinearElastic
) -> list[Row]:
    """Measure both in alternation, in one process.

    Args:
        cell: "hexahedron" or "quadrilateral".
        n: cells per side.
        steps: steps per round [1].
        rounds: number of rounds [1].
        law: class of the material.

    Returns:
        Rows of the whole step and of the force alone; their ratio is the median of those of the rounds.
    """
    kind, plane = getattr(mesh.CellType, cell), cell == "quadrilateral"
    domain = (
        mesh.create_unit_square(MPI.COMM_SELF, n, n, kind)
        if plane
        else mesh.create_unit_cube(MPI.COMM_SELF, n, n, n, kind)
    )
    dim, count = 2 if plane else 3, domain.topology.index_map(domain.topology.dim).size_local * 1e-6
    V = fem.functionspace(domain, ("Lagrange", 1, (dim,)))
    problems, forces = [], []
    for integration in INTEGRATIONS:
        u = fem.Function(V, name="u")
        material = law(1e3, 0.3, 1.0, "plane_strain" if plane else "3d", integration)
        problems.append(ExplicitProblem(u, material, velocity=initial_velocity(V)))
        forces.append(operators.InternalForce(operators.internal_force_form(u, ufl.TestFunction(V), material)))
    b = fem.Function(V).x.array
    whole = np.array([[step_seconds(p, steps, 1)[0] for p in problems] for _ in range(rounds)])
    alone = np.array([
        [best_time(lambda f=f: f._cpp_object.assemble(b), rounds=1)[0] for f in forces]  # type: ignore[misc]
        for _ in range(rounds)
    ])  # fmt: skip
    out = []
    for name, seconds in (("whole step", whole), ("force", alone)):
        full = float(np.median(seconds[:, 0]))
        ratio = float(np.median(seconds[:, 0] / seconds[:, 1]))
        label = f"{law.law_class.name} reduced / full, {name}"
        out.append(row(label, f"{cell} P1", 1, ratio * count / full, CELLS_PER_S, count / full))
    return out


def jobs() -> list[Job]:
    """Measurements of this module.

    Returns:
        A text and a function that returns rows, for each measurement.
    """
    return [(f"one point, {cell}", partial(one_point_rows, cell, n)) for cell, _, n in CASES]
