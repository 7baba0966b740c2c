# SPDX-License-Identifier: MIT
"""Frames of a passage on a block of four cells: written one after the other, saved, and read by a run that goes on."""

from types import SimpleNamespace

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.io.run_folder import RunFolder
from impact_studies.rail_joint.frame_series import FrameSeries
from impact_studies.rail_joint.passage import Frame
from impact_studies.rail_joint.stress import NAMES


class Saved:
    """Stands for a SavedCase: files by name in one folder."""

    def __init__(self, folder):
        self.folder = folder

    def file(self, name):
        return self.folder / f"{name}.h5"

    def add(self, name, write):
        write(self.file(name))


def frame(V, factor):
    """Displacement factor (x, y, z), and stresses factor times the number of their name."""
    scalars = fem.functionspace(V.mesh, ("Lagrange", 1))
    u, stress = fem.Function(V), {name: fem.Function(scalars) for name in NAMES}
    u.interpolate(lambda x: factor * x)
    for k, f in enumerate(stress.values()):
        f.interpolate(lambda x, k=k: factor * (k + x[0]))
    return Frame(time=0.1 * factor, place=-0.5, displacement=u, stress=stress)


def test_frames_are_kept_saved_and_read_again(tmp_path):
    domain = mesh.create_box(MPI.COMM_SELF, [(0, 0, 0), (2, 1, 1)], (4, 1, 1), mesh.CellType.hexahedron)
    V = fem.functionspace(domain, ("Lagrange", 1, (3,)))
    law = di.LinearElastic(1.0, 0.3, 1.0)
    passage = SimpleNamespace(run=di.ExplicitProblem(fem.Function(V), law, velocity=fem.Function(V)))
    model, saved, found = SimpleNamespace(V=V, mesh=domain), Saved(tmp_path), []
    for again in (False, True):
        with RunFolder(tmp_path / f"run {again}", comm=MPI.COMM_SELF) as run:
            series = FrameSeries(model, saved, run)
            if again:
                series.read(passage, 2)
            else:
                for factor in (1.0, 3.0):
                    series.add(passage, frame(V, factor))
            series.close()
            assert (run.path / "frames.bp").is_dir()
        assert series.names == ["frame_0", "frame_1"]
        found.append(series)
    for k, factor in enumerate((1.0, 3.0)):
        for series in found:
            picture, shear = series.pictures[k], series.shears[k]
            assert picture.place == -0.5
            u, mises = picture.displacement, picture.stress
            assert u.values == pytest.approx(factor * u.points, abs=1e-14)
            assert mises.values[:, 0] == pytest.approx(factor * mises.points[:, 0], abs=1e-14)  # number 0
            k_shear = NAMES.index("tau_xz")
            assert shear.values[:, 0] == pytest.approx(factor * (k_shear + shear.points[:, 0]), abs=1e-14)
    assert np.array_equal(found[0].pictures[1].displacement.values, found[1].pictures[1].displacement.values)
