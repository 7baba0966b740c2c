# SPDX-License-Identifier: MIT
"""A file in memory by pages, against a plain file with the same calls; and what ranks gather and write together."""

import io
import os

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

from dolfinx_impact.io.gather import Gathered, gather_field, gather_mesh, together
from dolfinx_impact.io.hdf5 import WrittenPages
from dolfinx_impact.io.output_folder import FolderGone, OutputFolder
from dolfinx_impact.io.plots import NoScreen, screen
from dolfinx_impact.io.series_writer import SeriesWriter


@pytest.mark.parametrize("below", [0, 10000])
def test_pages_are_a_file(below, rng, tmp_path):
    """Random calls on both."""
    (tmp_path / "base").write_bytes(content := rng.bytes(below))
    with open(tmp_path / "base", "rb") as base:
        pages, plain = WrittenPages(base.fileno() if below else None), io.BytesIO(content)
        for _ in range(60):
            at, length = (int(n) for n in rng.integers(0, [15000, 6000]))
            assert pages.seek(at) == plain.seek(at)
            if rng.random() < 0.5:
                data = rng.bytes(length)
                assert pages.write(data) == plain.write(data)
            else:
                found, expected = bytearray(length), bytearray(length)
                pages.readinto(found)
                plain.readinto(expected)
                assert found == expected
                pages.seek(plain.tell())  # a plain file ends; a page goes on with zeros
            assert pages.tell() == plain.tell()
        expected = plain.getvalue()
        assert pages.size == len(expected) == pages.seek(0, os.SEEK_END)
        assert pages.content(0, pages.size) == expected
        assert pages.seek(-10, os.SEEK_CUR) == pages.size - 10
        rebuilt = bytearray(content.ljust(len(expected), b"\0"))
        for offset, data in pages.writes():
            rebuilt[offset : offset + len(data)] = data
        assert bytes(rebuilt) == expected
        assert pages.truncate(100) == 100 == pages.size
        assert sum(len(data) for _, data in pages.writes()) <= 100
    assert (tmp_path / "base").read_bytes() == content


@pytest.mark.parametrize(
    "kind, degree, number", [("triangle", 1, 5), ("quadrilateral", 1, 9), ("tetrahedron", 1, 10), ("hexahedron", 2, 72)]
)
def test_cells_for_vtk(kind, degree, number):
    """Nodes in VTK's order go round each face: the area or volume by VTK's corners is that of the cell."""
    cell = getattr(mesh.CellType, kind)
    make = mesh.create_unit_square if kind in ("triangle", "quadrilateral") else mesh.create_unit_cube
    domain = make(MPI.COMM_SELF, *[1] * (2 if make is mesh.create_unit_square else 3), cell)
    V = fem.functionspace(domain, ("Lagrange", degree))
    f = fem.Function(V)
    f.interpolate(lambda x: x[0])
    found = gather_field(f)
    assert isinstance(found, Gathered) and np.array_equal(found.values[:, 0], found.points[:, 0])
    cells, kind_of_vtk = found.vtk()
    assert kind_of_vtk == number and np.array_equal(np.sort(cells), np.sort(found.cells))
    p = found.points[cells]
    if domain.topology.dim == 2:
        n = 3 if kind == "triangle" else 4
        x, y = p[:, :n, 0], p[:, :n, 1]
        area = np.abs(np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1)) / 2
        assert area.sum() == pytest.approx(1.0, rel=1e-14)
    elif kind == "hexahedron":
        # Edges 0-1, 0-3 and 0-4 span the cube, and 6 is opposite to 0.
        edges = p[0, [1, 3, 4]] - p[0, 0]
        assert abs(np.linalg.det(edges)) == pytest.approx(1.0) and p[0, 6] == pytest.approx(p[0, 0] + edges.sum(axis=0))
    assert gather_mesh(domain).cells.shape[0] == len(found.cells) and gather_mesh(domain).values is None


def test_errors_of_rank_0_are_those_of_all():
    assert together(MPI.COMM_SELF, lambda: 3) == 3
    with pytest.raises(ValueError, match="five"):
        together(MPI.COMM_SELF, lambda: [int("five")])
    with pytest.raises(RuntimeError, match="KeyError: 'x'"):
        together(MPI.COMM_SELF, lambda: {}["x"])


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
