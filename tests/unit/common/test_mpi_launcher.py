# SPDX-License-Identifier: MIT
"""Ranks are started by the MPI that Python uses."""

import sys

import pytest

from dolfinx_impact.common.mpi_launcher import mpi_launcher


def program(folder, name):
    """An empty program in a folder."""
    folder.mkdir(exist_ok=True)
    path = folder / name
    path.write_text("#!/bin/sh\n")
    path.chmod(0o755)
    return str(path)


@pytest.mark.parametrize("name", ("mpirun", "mpiexec"))
def test_the_launcher_beside_python_comes_first(name, tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "executable", str(tmp_path / "own" / "python3"))
    monkeypatch.setenv("PATH", str(tmp_path / "system"))
    assert mpi_launcher() is None
    system = program(tmp_path / "system", "mpirun")
    assert mpi_launcher() == system
    assert program(tmp_path / "own", name) == mpi_launcher()
