# SPDX-License-Identifier: MIT
"""Cost of cells with one point and hourglass control: whole explicit steps and kernels against full integration, steps
in mixed precision against full integration in double, and steps against those that are written by hand."""

from collections.abc import Sequence
from functools import partial

import numpy as np
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

from dolfinx_impact import _cpp, materials
from dolfinx_impact.assembly import operators
from dolfinx_impact.dynamics.explicit import ExplicitProblem
from dolfinx_impact.materials import FULL, REDUCED
from .explicit import CELLS_PER_S, hand_written_row, initial_velocity, step_seconds
from .rows import Job, Row, row
from .setup import Case, MaterialClass, Setup, best_time

CASES: Sequence[Case] = (("hexahedron", 1, 50), ("quadrilateral", 1, 400))
MIXED_CASES: Sequence[tuple[int, MaterialClass]] = ((40, materials.LinearElastic), (40, materials.NeoHookean))
INTEGRATIONS = (FULL, REDUCED)
ROUNDS = 5
HAND_WRITTEN_CELLS, HAND_WRITTEN_STEPS = 30, 200  # cells per side, steps per round


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


def mixed_rows(n: int, law: MaterialClass, steps: int = 60, rounds: int = ROUNDS) -> list[Row]:
    """Measure one point with element forces in float against full integration in double, in alternation.

    Args:
        n: hexahedra per side.
        law: class of the material.
        steps: steps per round [1].
        rounds: number of rounds [1].

    Returns:
        A row of the whole step, whose ratio is the median of those of the rounds.
    """
    V = fem.functionspace(
        mesh.create_unit_cube(MPI.COMM_SELF, n, n, n, mesh.CellType.hexahedron), ("Lagrange", 1, (3,))
    )
    problems = [
        ExplicitProblem(
            fem.Function(V, name="u"), law(1e3, 0.3, 1.0, "3d", integration), velocity=initial_velocity(V),
            precision=precision,
        )
        for integration, precision in ((FULL, "double"), (REDUCED, "mixed"))
    ]  # fmt: skip
    whole = np.array([[step_seconds(p, steps, 1)[0] for p in problems] for _ in range(rounds)])
    full, count = float(np.median(whole[:, 0])), n**3 * 1e-6
    ratio = float(np.median(whole[:, 0] / whole[:, 1]))
    label = f"{law.law_class.name} reduced, mixed / full, double, whole step"
    return [row(label, "hexahedron P1", 1, ratio * count / full, CELLS_PER_S, count / full)]


def hand_written_rows(n: int = HAND_WRITTEN_CELLS, steps: int = HAND_WRITTEN_STEPS, rounds: int = 3) -> list[Row]:
    """Measure the step of hexahedra with one point against that which is written by hand.

    Args:
        n: hexahedra per side.
        steps: steps per round [1].
        rounds: number of rounds [1].

    Returns:
        A row; none where the processor has no vectors that there are loops for.
    """
    if not _cpp.bench.HandWrittenStep.widths():
        return []
    return [hand_written_row(Setup("hexahedron", 1, n), "hexahedron P1", steps, rounds, REDUCED)]


def jobs() -> list[Job]:
    """Measurements of this module.

    Returns:
        A text and a function that returns rows, for each measurement.
    """
    out: list[Job] = [(f"one point, {cell}", partial(one_point_rows, cell, n)) for cell, _, n in CASES]
    out += [
        (f"one point, mixed precision, {law.law_class.name}", partial(mixed_rows, n, law)) for n, law in MIXED_CASES
    ]
    return [*out, ("one point, written by hand", hand_written_rows)]
