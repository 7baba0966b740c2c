# SPDX-License-Identifier: MIT
"""Recipes and reading on several ranks: the same meshes, the same errors everywhere, and nothing hangs."""

import os
import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.mpi
@pytest.mark.timeout(120)
@pytest.mark.parametrize("ranks", [2, 3])
def test_on_ranks(ranks, tmp_path):
    worker = Path(__file__).parent / "mpi_worker.py"
    command = ["mpirun", "-n", str(ranks), sys.executable, str(worker), str(tmp_path)]
    # Ranks that wait give way, and are not tied to a core another test's ranks are tied to as well.
    patient = {"OMPI_MCA_mpi_yield_when_idle": "1", "PRTE_MCA_hwloc_default_binding_policy": "none"}
    run = subprocess.run(command, capture_output=True, text=True, timeout=100, env={**os.environ, **patient})
    assert run.returncode == 0 and "agreed" in run.stdout, run.stdout[-2000:] + run.stderr[-6000:]
