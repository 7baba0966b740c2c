"""Recipes and reading on several ranks: the same meshes, the same errors everywhere, and nothing hangs."""

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
    run = subprocess.run(command, capture_output=True, text=True, timeout=100)
    assert run.returncode == 0 and "agreed" in run.stdout, run.stdout[-2000:] + run.stderr[-6000:]
