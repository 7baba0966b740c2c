# SPDX-License-Identifier: MIT
"""What one process computes at its SIMD width, with its BLAS kernels; writes an .npz file.

processor_checks.py FILE CELL...
"""

import sys

import numpy as np

from impact_verify import runs_in_time
from impact_verify.report import Report
from impact_verify.scenarios import explicit_runs, our_adapter

STEPS = 30


def runs(cells):
    """Bodies without contact, with every law, scheme and damping; blocks thrown over an edge, also in a variation."""
    for cell, degree, make in explicit_runs.RUNS:
        if cell in cells and make in (explicit_runs.without_contact, explicit_runs.overhang):
            yield from make(cell, degree)
            if (make, degree) == (explicit_runs.overhang, 1):
                yield from explicit_runs.varied_runs(cell, degree, make, (4,))


def results(cells):
    """Stable steps, motion, contact forces and energies on our side; stops where the hand-written side differs."""
    out, report = {}, Report()
    for case in runs(cells):
        problem = our_adapter.problem_of(case)
        dt = our_adapter.time_step(case, problem)
        record = our_adapter.record_of(problem, dt, STEPS)
        our_adapter.run = lambda *_: record
        runs_in_time.compare(report, case, STEPS)
        # By place: which node has which number is no result.
        order = np.lexsort(case.body.V.tabulate_dof_coordinates().round(6).T)
        key = f"{case.body.cell} {case.body.degree}, {case.name}"
        out["width"] = problem._bodies.internal._parts[0].width
        out[f"{key}: step"] = dt
        out[f"{key}: displacement"] = record.fields["displacement"][-1].reshape(len(order), -1)[order]
        out[f"{key}: energies"] = problem.energy_history[:, 1:]
        if case.contact:
            out[f"{key}: contact force"] = problem.force_history[0]
    assert report.passed and len(report.rows) > 20 * len(cells), [row.name for row in report.failures()]
    return out


if __name__ == "__main__":
    np.savez(sys.argv[1], **results(sys.argv[2:]))
