# SPDX-License-Identifier: MIT
"""Level history, implicit runs of bodies that yield."""

from typing import Any

import numpy as np
from dolfinx import fem
from impact_reference import NewmarkScheme

from dolfinx_impact import materials
from dolfinx_impact.common.types import FloatArray
from dolfinx_impact.dynamics.implicit.newmark_problem import NewmarkProblem
from . import plastic_bodies, runs_in_time
from .report import Report
from .scenarios import our_adapter, their_adapter
from .scenarios.scenario import ACCURACY, STEPS, Implicit

# cell, degree, hypothesis, finite strain, mean dilatation, law; see plastic_bodies
YIELDING: tuple[tuple[str, int, str, bool, bool, str], ...] = (
    ("quadrilateral", 1, "plane_strain", False, True, "prager"),
    ("quadrilateral", 1, "axisymmetric", True, True, "linear"),
    ("triangle", 2, "plane_stress", False, False, "table"),
    ("hexahedron", 1, "3d", True, True, "voce"),
)


def run(report: Report) -> None:
    """Add the rows of implicit runs that yield.

    Args:
        report: report to add to.
    """
    for arguments in YIELDING:
        if report.wants(arguments[0], arguments[1]):
            compare(report, *arguments)


def compare(report: Report, *arguments: Any, steps: int = STEPS[Implicit]) -> None:
    """Add the rows of a block that flies away from its clamped end, fast enough to yield.

    Args:
        report: report to add to.
        arguments: of plastic_bodies.PlasticBodies.
        steps: number of steps.
    """
    both = plastic_bodies.PlasticBodies(*arguments)
    damping = (0.0, 0.0) if arguments[3] else (0.05, 0.02)  # in small strain
    body, dim = both.body, both.body.gdim
    x = body.V.tabulate_dof_coordinates()[:, :dim]
    speed = 4.0 * plastic_bodies.Y / np.sqrt(plastic_bodies.E * 1.5)
    v0 = np.stack([speed * x[:, -1] * (1.0 if a == dim - 1 else 0.3 * np.sin(3 * x[:, 0])) for a in range(dim)], axis=1)
    nodes = np.flatnonzero(np.isclose(x[:, -1], 0.0)).astype(np.int32)
    v0[nodes] = 0.0
    v = fem.Function(body.V)
    v.x.array[:] = v0.ravel()
    clamp = fem.dirichletbc(np.zeros(dim), nodes, body.V)
    problem = NewmarkProblem(
        both.u, both.steel, velocity=v, bcs=[clamp], rho_inf=0.8, damping=materials.Rayleigh(*damping)
    )
    ours = our_adapter.record_of(problem, 0.1, steps)
    start: FloatArray = np.empty(len(body.order))
    start[body.order] = v0.ravel()
    fixed = (dim * nodes[:, None] + np.arange(dim)).ravel()
    result = both.other.run_newmark(
        np.diff(ours.time), scheme=NewmarkScheme.chung_hulbert(0.8), v0=start, fixed_dofs=body.order[fixed],
        damping=damping,
    )  # fmt: skip
    dissipated = 100 * result.energies["plastic"][-1] / result.energies["kinetic"][0]
    name = f"yielding block, {dissipated:.0f} % dissipated"
    theirs = their_adapter.implicit_record(result, body.order)
    compared = ("displacement", "velocity", "acceleration")
    form, accuracy = f"implicit.{both.form}", ACCURACY[Implicit]
    runs_in_time.add_rows(report, form, both.element, name, compared, ours, theirs, accuracy, steps)
