# SPDX-License-Identifier: MIT
"""What one process computes at its SIMD width, with its BLAS kernels; writes an .npz file.

processor_checks.py FILE CELL...
"""

import sys

import numpy as np

from impact_verify import history
from impact_verify.report import Report

STEPS = 60


def runs(cells):
    """Bodies without contact, with every law, scheme and damping; blocks thrown over an edge, also in a variation."""
    for cell, degree, make in history.RUNS:
        if cell in cells and make in (history.without_contact, history.overhang):
            yield from make(cell, degree)
            if (make, degree) == (history.overhang, 1):
                yield from history.varied_runs(cell, degree, make, (4,))


def results(cells):
    """Stable steps, motion, contact forces and energies on our side; stops where the hand-written side differs."""
    out, report, ours = {}, Report(), history.ours
    for case in runs(cells):
        problem, dt, (u, v) = answer = ours(case, STEPS)
        history.ours = lambda *_: answer
        history.compare(report, case, STEPS)
        # By place: which node has which number is no result.
        order = np.lexsort(case.body.V.tabulate_dof_coordinates().round(6).T)
        key = f"{case.body.cell} {case.body.degree}, {case.name}"
        out["width"] = problem._bodies.internal._parts[0].width
        out[f"{key}: step"] = dt
        out[f"{key}: displacement"] = u[-1].reshape(len(order), -1)[order]
        out[f"{key}: energies"] = problem.energy_history[:, 1:]
        if case.contact:
            out[f"{key}: contact force"] = problem.force_history[0]
    assert report.passed and len(report.rows) > 20 * len(cells), [row.name for row in report.failures()]
    return out


if __name__ == "__main__":
    np.savez(sys.argv[1], **results(sys.argv[2:]))
