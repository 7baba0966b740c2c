# SPDX-License-Identifier: MIT
"""Folders of runs, the series in them, and pictures without a screen."""

import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

from dolfinx_impact.io.output_folder import FolderGone, OutputFolder
from dolfinx_impact.io.plots import NoScreen, screen
from dolfinx_impact.io.series_writer import SeriesWriter


def test_a_folder_that_is_there_and_one_that_is_not(tmp_path):
    with OutputFolder(tmp_path / "a" / "b", MPI.COMM_SELF, alone=True) as folder:
        assert folder.write("x", lambda: folder.file("x").write_text("1")) == 1
        with pytest.raises(RuntimeError, match="another"):
            OutputFolder(folder.path, MPI.COMM_SELF, alone=True)
    OutputFolder(folder.path, MPI.COMM_SELF, alone=True).close()  # it was unlocked
    with pytest.raises(FolderGone, match="is gone"):
        folder.write("y", lambda: open(folder.file("y")))
    (folder.path / "z").mkdir()
    with pytest.raises(RuntimeError, match="z cannot be written") as error:
        folder.write("z", lambda: open(folder.file("z"), "w"))
    assert not isinstance(error.value, FolderGone)
    (tmp_path / "file").write_text("")
    with pytest.raises(RuntimeError, match="results cannot be written to"):
        OutputFolder(tmp_path / "file" / "below", MPI.COMM_SELF)


def test_pictures_without_a_screen(monkeypatch, tmp_path):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(NoScreen, match="install Xvfb"):
        screen()
    (tmp_path / "Xvfb").write_text("#!/bin/sh\nexit 1\n")
    (tmp_path / "Xvfb").chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:/bin:/usr/bin")
    with pytest.raises(NoScreen, match="did not start"):
        screen()
    monkeypatch.setenv("DISPLAY", ":77")
    screen()


def test_a_series_is_closed_once_and_can_be_left(tmp_path):
    domain = mesh.create_unit_square(MPI.COMM_SELF, 1, 1)
    f = fem.Function(fem.functionspace(domain, ("Lagrange", 1)))
    for end in ("close", "abandon"):
        series = SeriesWriter(MPI.COMM_SELF, tmp_path / f"{end}.bp", [f])
        series.write(0.0)
        getattr(series, end)()
        series.close()  # nothing is left to do
        with pytest.raises(AssertionError):
            series.write(1.0)
        assert (tmp_path / f"{end}.bp").is_dir()
