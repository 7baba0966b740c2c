# SPDX-License-Identifier: MIT
"""Level history: runs in time on both sides; states, energies and contact forces of every step.

The runs are scenarios, which two adapters make with dolfinx_impact and with the hand-written solver.
"""

import numpy as np

from dolfinx_impact.common.types import FloatArray
from dolfinx_impact.dynamics.run_history import ENERGIES
from .report import Report
from .scenarios import explicit_runs, implicit_runs, our_adapter, their_adapter
from .scenarios.record import Record
from .scenarios.scenario import Accuracy, Scenario

Element = tuple[str, int, int, str]  # cell, degree, degree of the geometry and hypothesis, of rows


def run(report: Report, progress: bool | None = None) -> None:
    """Add the rows of explicit runs.

    Args:
        report: report to add to.
        progress: not used; all levels share these arguments.
    """
    for cell, degree, make in explicit_runs.RUNS:
        if report.wants(cell, degree):
            for case in (*make(cell, degree), *explicit_runs.varied_runs(cell, degree, make)):
                compare(report, case)


def run_implicit(report: Report) -> None:
    """Add the rows of implicit runs.

    Args:
        report: report to add to.
    """
    for cell, degree, make in implicit_runs.RUNS:
        if report.wants(cell, degree):
            for case in (*make(cell, degree), *implicit_runs.varied_runs(cell, degree, make)):
                compare(report, case)


def compare(report: Report, case: Scenario, steps: int | None = None) -> None:
    """Add the rows of one run: states, energies and contact forces of all time levels.

    Args:
        report: report to add to.
        case: the run.
        steps: number of steps; None: as the scenario has it.
    """
    steps, body = case.num_steps if steps is None else steps, case.body
    ours = our_adapter.run(case, steps)
    theirs = their_adapter.run(case, ours.time)
    element = (body.cell, body.degree, body.geometry_degree, body.hypothesis)
    expected = None if getattr(case.scheme, "error", None) is not None else steps
    add_rows(report, case.form, element, case.name, case.compared, ours, theirs, case.accuracy, expected)


def add_rows(
    report: Report,
    form: str,
    element: Element,
    name: str,
    compared: tuple[str, ...],
    ours: Record,
    theirs: Record,
    accuracy: Accuracy,
    steps: int | None,
) -> None:
    """Add the rows of one run.

    Args:
        report: report to add to.
        form: form of the rows.
        element: cell, degree, degree of the geometry and hypothesis.
        name: name of the run.
        compared: names of the fields that are compared.
        ours: what came out with dolfinx_impact.
        theirs: what came out with the hand-written solver.
        accuracy: how well both must agree.
        steps: number of steps that were asked for; None: our side chooses it.
    """
    pairs = {what: (ours.fields[what], theirs.fields[what]) for what in compared}
    for energy in ENERGIES:
        values, their_values = ours.energies[energy], theirs.energies[energy]
        if np.any(their_values) or np.any(values):
            pairs[f"{energy} energy"] = values, their_values
    if ours.force is not None and theirs.force is not None:
        pairs["contact force"] = ours.force, theirs.force
    for what, (a, b) in pairs.items():
        scale = theirs.largest_energy if what.endswith("energy") else float(np.abs(b).max())
        difference, note = largest_difference(np.asarray(a), np.asarray(b), scale)
        if steps is not None and len(ours.time) != steps + 1:
            difference, note = np.inf, f"the UFL side took {len(ours.time) - 1} steps instead of {steps}"
        report.add(
            "history", form, *element, difference, accuracy.tolerance, accuracy.reason, f"{what} of the {name}", note
        )


def largest_difference(a: FloatArray, b: FloatArray, scale: float) -> tuple[float, str]:
    """Largest difference of two histories over a scale, and where it is.

    Args:
        a: our values, shape (num_levels, ...).
        b: values of the other side, shape (num_levels, ...).
        scale: largest entry of b; for energies the largest energy of the run.

    Returns:
        Difference [1], infinite for histories that cannot be compared, and a note.
    """
    if a.shape != b.shape:
        return np.inf, f"UFL side {a.shape} values, hand-written side {b.shape}"
    if not scale > 0.0:
        return np.inf, "nothing happens on the hand-written side"
    error = np.where(np.isnan(a - b), np.inf, np.abs(a - b))
    k = np.unravel_index(np.argmax(error), error.shape)
    return float(error[k]) / scale, f"step {int(k[0])}: UFL {a[k]:.15g}, hand-written {b[k]:.15g}"
