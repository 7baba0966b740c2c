# SPDX-License-Identifier: MIT
"""SNES by options on 1 and 2 ranks."""

import snes_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(snes_checks, ranks=(2,), timeout=300)


def test_monitor_prints(capfd):
    """PETSc's own monitor sees every iteration of the package's method."""
    _, report = snes_checks.stretched({"snes_monitor": None})
    lines = [line for line in capfd.readouterr().out.splitlines() if "SNES Function norm" in line]
    assert len(lines) == len(report.residual_norms[0])
