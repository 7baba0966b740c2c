# SPDX-License-Identifier: MIT
"""Run folders, gathered fields, pictures."""

import json

import h5py
import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

from dolfinx_impact.io import plots
from dolfinx_impact.io.gather import gather_field, gather_mesh
from dolfinx_impact.io.run_folder import RunFolder, vertex_average


def test_parameters_and_table(tmp_path):
    run = RunFolder(tmp_path / "a" / "b", {"load": np.float64(4e6), "box": np.array([1, 2])}, name="press")
    record = json.loads((tmp_path / "a" / "b" / "parameters.json").read_text())
    assert record["parameters"] == {"load": 4e6, "box": [1, 2]} and record["ranks"] == MPI.COMM_WORLD.size
    assert {"dolfinx_impact", "dolfinx", "petsc", "nanobind"} <= set(record["versions"])
    run.table("line", {"z": (np.array([0.0, 1.5]), "m"), "shear": ([3.0, 4.0], "Pa")})
    assert run.file("line.csv").read_text().split() == ["z", "[m],shear", "[Pa]", "0.0,3.0", "1.5,4.0"]
    with h5py.File(run.file("line.h5")) as file:
        assert file["shear"].attrs["units"] == "Pa" and file["z"][1] == 1.5
    with pytest.raises(ValueError, match="different lengths"):
        run.table("bad", {"z": ([1.0], "m"), "p": ([1.0, 2.0], "Pa")})


def test_default_folder(tmp_path, monkeypatch):
    monkeypatch.delenv("IMPACT_OUTPUT", raising=False)
    monkeypatch.chdir(tmp_path)
    assert RunFolder(name="x").path == tmp_path / "results" / "x"
    monkeypatch.setenv("IMPACT_OUTPUT", str(tmp_path / "named"))
    assert RunFolder(name="x").path == tmp_path / "named"


@pytest.mark.parametrize("ranks", (1, 2))
def test_a_folder_that_cannot_be_made_is_an_error_on_all_ranks(ranks, script_on_ranks, tmp_path):
    (tmp_path / "file").write_text("in the way")
    code = """
    import sys
    from mpi4py import MPI
    from dolfinx_impact.io.run_folder import RunFolder
    try:
        RunFolder(sys.argv[1])
    except RuntimeError as error:
        said = MPI.COMM_WORLD.gather(str(error))
        if said:
            print(len(said), len(set(said)), said[0])
    """
    output = script_on_ranks(ranks, code, tmp_path / "file" / "below")
    assert f"{ranks} 1 results cannot be written to" in output and "Not a directory" in output and "--output" in output


@pytest.mark.parametrize("ranks", (1, 2, 3))
def test_fields_and_gathering(ranks, script_on_ranks, tmp_path):
    """A gathered field is the field, whatever the number of ranks; files are written in both formats."""
    code = """
    import sys
    import numpy as np
    from dolfinx import fem, mesh
    from mpi4py import MPI
    from dolfinx_impact.io.gather import gather_field, gather_mesh
    from dolfinx_impact.io.run_folder import RunFolder
    comm = MPI.COMM_WORLD
    m = mesh.create_rectangle(comm, [[0, 0], [2, 1]], [7, 5], mesh.CellType.quadrilateral)
    u = fem.Function(fem.functionspace(m, ("Lagrange", 2, (2,))), name="u")
    u.interpolate(lambda x: (x[0] * x[1], x[0] ** 2))
    s = fem.Function(fem.functionspace(m, ("Lagrange", 1)), name="s")
    field, cells = gather_field(u), gather_mesh(m)
    if comm.rank == 0:
        x = field.points
        assert field.values.shape == (15 * 11, 2) and np.unique(x.round(9), axis=0).shape == x.shape
        assert np.allclose(field.values, np.column_stack([x[:, 0] * x[:, 1], x[:, 0] ** 2]))
        assert np.allclose(x[field.cells[:, :4]], cells.points[cells.cells])
        assert len(cells.cells) == 35
    run = RunFolder(sys.argv[1])
    assert [p.name for p in run.fields("out", [u, s])] == ["out.bp", "out_1.bp"]
    run.fields("out", [u, s], xdmf=True)
    run.print("once")
    """
    output = script_on_ranks(ranks, code, tmp_path)
    assert output.count("once") == 1
    assert {"out.bp", "out_1.bp", "out.xdmf", "out.h5"} <= {p.name for p in tmp_path.iterdir()}


@pytest.mark.parametrize("cell", ("triangle", "quadrilateral", "tetrahedron", "hexahedron"))
@pytest.mark.parametrize("degree", (1, 2))
def test_vtk_cells_are_not_folded(cell, degree):
    """Node orders by the volume VTK computes."""
    pytest.importorskip("pyvista")
    kind = getattr(mesh.CellType, cell)
    if cell in ("triangle", "quadrilateral"):
        m = mesh.create_unit_square(MPI.COMM_SELF, 2, 3, kind)
    else:
        m = mesh.create_unit_cube(MPI.COMM_SELF, 2, 3, 2, kind)
    field = gather_field(fem.Function(fem.functionspace(m, ("Lagrange", degree))))
    made = plots.grid(field).compute_cell_sizes()
    size = made["Area"] if m.topology.dim == 2 else made["Volume"]
    assert np.abs(size).sum() == pytest.approx(1.0, rel=1e-6)
    assert len(gather_mesh(m).cells) == made.n_cells


def test_vertex_average_of_a_linear_stress_is_exact():
    m = mesh.create_unit_square(MPI.COMM_SELF, 4, 3, mesh.CellType.quadrilateral)
    u = fem.Function(fem.functionspace(m, ("Lagrange", 2)), name="u")
    u.interpolate(lambda x: x[0] ** 2 + x[1])
    gradient = vertex_average(ufl.grad(u)[0], m, "gradient")
    x = gradient.function_space.tabulate_dof_coordinates()
    assert gradient.name == "gradient" and np.allclose(gradient.x.array, 2 * x[:, 0], atol=1e-12)


def test_without_a_screen_pictures_are_left_out(tmp_path, monkeypatch, capsys):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setattr(plots.shutil, "which", lambda name: None)
    RunFolder(tmp_path).pictures(plots.screen)
    assert "left out" in capsys.readouterr().out
    with pytest.raises(RuntimeError, match="division"):
        RunFolder(tmp_path).pictures(lambda: 1 / 0)


def test_a_png_is_smaller_with_fewer_colours(tmp_path):
    plt = plots.pyplot()
    sizes = []
    for colours in (None, 16):
        figure, axes = plt.subplots(figsize=(3, 2))
        plots.show(axes, np.random.default_rng(1).integers(0, 255, (40, 60, 3), dtype=np.uint8), (0, 6, 0, 4))
        assert axes.get_xlabel() == "x [mm]"
        sizes.append(plots.save(figure, tmp_path / f"{colours}.png", colours).stat().st_size)
    assert sizes[1] < sizes[0]
