# SPDX-License-Identifier: MIT
"""Speed of explicit steps with element forces in float against those in double."""

from collections.abc import Sequence
from functools import partial

import numpy as np
from dolfinx import fem, mesh
from mpi4py import MPI

from dolfinx_impact import materials
from dolfinx_impact.dynamics.explicit import ExplicitProblem
from .explicit import CELLS_PER_S, initial_velocity, step_seconds
from .rows import Job, Row, row
from .setup import Case, MaterialClass

CASES: Sequence[tuple[Case, MaterialClass]] = (
    (("hexahedron", 1, 40), materials.LinearElastic),
    (("hexahedron", 1, 40), materials.NeoHookean),
    (("tetrahedron", 1, 24), materials.LinearElastic),
    (("tetrahedron", 2, 12), materials.LinearElastic),
)
ROUNDS = 5


def mixed_rows(case: Case, law: MaterialClass, steps: int = 20, rounds: int = ROUNDS) -> list[Row]:
    """Measure both in alternation, in one process.

    Args:
        case: cell, degree, and cells per side.
        law: class of the material.
        steps: steps per round [1].
        rounds: number of rounds [1].

    Returns:
        A row of the whole step, whose ratio is the median of those of the rounds.
    """
    cell, degree, n = case
    domain = mesh.create_unit_cube(MPI.COMM_SELF, n, n, n, getattr(mesh.CellType, cell))
    count = domain.topology.index_map(3).size_local * 1e-6
    V = fem.functionspace(domain, ("Lagrange", degree, (3,)))
    material, problems = law(1e3, 0.3, 1.0), []
    for precision in ("double", "mixed"):
        u = fem.Function(V, name="u")
        problems.append(ExplicitProblem(u, material, velocity=initial_velocity(V), precision=precision))
    whole = np.array([[step_seconds(p, steps, 1)[0] for p in problems] for _ in range(rounds)])
    double = float(np.median(whole[:, 0]))
    ratio = float(np.median(whole[:, 0] / whole[:, 1]))
    label = f"{law.law_class.name} mixed / double, whole step"
    return [row(label, f"{cell} P{degree}", 1, ratio * count / double, CELLS_PER_S, count / double)]


def jobs() -> list[Job]:
    """Measurements of this module.

    Returns:
        A text and a function that returns rows, for each measurement.
    """
    return [
        (f"mixed precision, {cell} P{degree}, {law.law_class.name}", partial(mixed_rows, (cell, degree, n), law))
        for (cell, degree, n), law in CASES
    ]
