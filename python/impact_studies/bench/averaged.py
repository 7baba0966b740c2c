# SPDX-License-Identifier: MIT
"""Cost of explicit steps of linear tetrahedra with pressures or strains averaged at the nodes, against plain ones."""

from functools import partial
from typing import Any

import numpy as np
from dolfinx import fem, mesh
from mpi4py import MPI

from dolfinx_impact.dynamics.explicit import ExplicitProblem
from dolfinx_impact.materials import AVERAGED_PRESSURE, AVERAGED_STRAIN, FULL, LinearElastic, NeoHookean
from dolfinx_impact.plasticity import J2Plasticity
from .explicit import CELLS_PER_S, initial_velocity, step_seconds
from .rows import Job, Row, row

E, NU, ROUNDS, STEPS = 1e3, 0.3, 5, 40
GOAL = 0.6  # of the plain tetrahedron's step
LAWS: dict[str, tuple[type[Any], dict[str, Any]]] = {
    "linear_elastic": (LinearElastic, {}),
    "neo_hookean": (NeoHookean, {}),
    "j2 finite strain": (J2Plasticity, {"yield_stress": 1e-3, "hardening": 10.0, "finite_strain": True}),
}
AVERAGES = {
    AVERAGED_PRESSURE: ("averaged pressure", tuple(LAWS)),
    AVERAGED_STRAIN: ("averaged strain", ("linear_elastic", "neo_hookean")),
}


def _problem(n: int, law: str, integration: str) -> ExplicitProblem:
    """A cube that moves, with a law of LAWS."""
    domain = mesh.create_unit_cube(MPI.COMM_SELF, n, n, n, mesh.CellType.tetrahedron)
    u = fem.Function(fem.functionspace(domain, ("Lagrange", 1, (3,))), name="u")
    kind, parameters = LAWS[law]
    material = kind(E, NU, 1.0, integration=integration, **parameters)
    return ExplicitProblem(u, material, velocity=initial_velocity(u.function_space, 0.05))


def averaged_rows(n: int = 32) -> list[Row]:
    """Measure steps with and without averages in turn.

    Args:
        n: cells per side, each of which is six tetrahedra.

    Returns:
        Rows; the ratio is the median of those of the rounds.
    """
    rows = []
    for law, how, text in ((law, how, text) for how, (text, laws) in AVERAGES.items() for law in laws):
        plain, averaged = (_problem(n, law, integration) for integration in (FULL, how))
        times = np.array([[step_seconds(p, STEPS, 1)[0] for p in (plain, averaged)] for _ in range(ROUNDS)])
        base = 6 * n**3 / float(np.median(times[:, 0])) * 1e-6
        ratio = float(np.median(times[:, 0] / times[:, 1]))
        name = f"{text} / plain, {law}, goal {GOAL}"
        rows.append(row(name, "tetrahedron P1", 1, ratio * base, CELLS_PER_S, base))
    return rows


def jobs(large: bool = False) -> list[Job]:
    """Measurements of averaged pressure and strain.

    Args:
        large: take larger models.

    Returns:
        A text and a function that returns rows.
    """
    return [("explicit step, averaged pressure and strain", partial(averaged_rows, 30 if large else 20))]
