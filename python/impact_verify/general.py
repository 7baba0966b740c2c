# SPDX-License-Identifier: MIT
"""Level contact, contact without pairs: forces, gaps and slips of all surface nodes at one time of a run."""

from typing import Any

import numpy as np

from .contact_patch import Rows
from .report import Report
from .scenarios import general_runs, our_adapter, their_adapter
from .scenarios.scenario import Explicit, Scenario

CELLS = ("triangle", "quadrilateral", "tetrahedron", "hexahedron")
MOST_STEPS, MORE_STEPS = 200, 10  # until bodies touch, and from then on
TOLERANCE = 1e-10
REASON = "round-off of some steps, times body size over gap"


def run(report: Report) -> None:
    """Add the rows of contact without pairs.

    Args:
        report: report to add to.
    """
    for cell in CELLS:
        if report.wants(cell, 1):
            for case in general_runs.touching(cell, 1):
                compare(report, case)


def compare(report: Report, case: Scenario) -> None:
    """Add the rows of a run: forces on all nodes, gaps, slips and statuses of the nodes' own springs.

    Args:
        report: report to add to.
        case: the run.
    """
    body = case.body
    assert isinstance(case.scheme, Explicit)
    problem = our_adapter.problem_of(case)
    dt = our_adapter.time_step(case, problem)
    ours: Any = problem.contact[0]
    crossed = "prism" in case.name
    steps, last = 0, MOST_STEPS
    while steps < last:
        steps += 1
        problem.advance(until=steps * dt, dt=dt, progress=False)
        if last == MOST_STEPS and ours.num_springs[crossed] > 0:
            last = steps + MORE_STEPS
    theirs = their_adapter.explicit_result(case, case.scheme, dt, steps).contacts[0]
    place = np.searchsorted(theirs.nodes, body.nodes[ours.nodes])
    all_nodes = body.to_ours(theirs.force[-1]).reshape(-1, body.gdim)
    rows = Rows(report, body, case.name)
    for what, a, b in (
        ("force", ours.traction * ours.weight[:, None], all_nodes[ours.nodes]),
        ("gap", _closed(ours.gap), _closed(theirs.gap[-1][place])),
        ("slip", ours.slip, theirs.slip[-1][place]),
        ("status", ours.status, theirs.status[-1][place]),
    ):
        rows(f"general_{what}", a, b, TOLERANCE, REASON, f"; {ours.num_springs[1]} crossed edges")


def _closed(gap: Any) -> Any:
    return np.where(np.isfinite(gap), gap, 0.0)
