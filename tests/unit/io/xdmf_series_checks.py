# SPDX-License-Identifier: MIT
"""Series in XDMF, read by h5py and as XML. See on_ranks.py."""

import shutil
import warnings
import xml.etree.ElementTree as ElementTree

import basix.ufl
import dolfinx.io
import h5py
import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from shared_folder import shared_folder

import dolfinx_impact as di
from dolfinx_impact.io.run_folder import RunFolder
from dolfinx_impact.io.xdmf_series import XdmfSeries

COMM = MPI.COMM_WORLD
DOMAINS = {
    "triangle": lambda: mesh.create_unit_square(COMM, 2, 2),
    "quadrilateral": lambda: mesh.create_unit_square(COMM, 2, 2, mesh.CellType.quadrilateral),
    "tetrahedron": lambda: mesh.create_unit_cube(COMM, 2, 1, 1),
    "hexahedron": lambda: mesh.create_unit_cube(COMM, 2, 2, 1, mesh.CellType.hexahedron),
}
NAMES = {
    ("triangle", 1): "Triangle", ("triangle", 2): "Triangle_6",
    ("quadrilateral", 1): "Quadrilateral", ("quadrilateral", 2): "Quadrilateral_9",
    ("tetrahedron", 1): "Tetrahedron", ("tetrahedron", 2): "Tetrahedron_10",
    ("hexahedron", 1): "Hexahedron", ("hexahedron", 2): "Hexahedron_27",
}  # fmt: skip


def volumes(cell, x):
    """Volumes of cells by their corners in VTK's order, (cells, corners, 3): in wrong orders they do not add up."""
    a, b, c = x[:, 1] - x[:, 0], x[:, 2] - x[:, 0], x[:, -1] - x[:, 0]
    if cell == "triangle":
        return np.cross(a, b)[:, 2] / 2
    if cell == "quadrilateral":
        return np.cross(b, x[:, 3] - x[:, 1])[:, 2] / 2
    if cell == "tetrahedron":
        return np.sum(np.cross(a, b) * c, axis=1) / 6
    return np.sum(np.cross(a, x[:, 3] - x[:, 0]) * (x[:, 4] - x[:, 0]), axis=1)


def check_cells_of_degree_1_and_2():
    for (cell, degree), name in NAMES.items():
        domain = DOMAINS[cell]()
        gdim = domain.geometry.dim
        u = fem.Function(fem.functionspace(domain, ("Lagrange", degree, (gdim,))), name="displacement")
        with shared_folder() as path:
            series = XdmfSeries(RunFolder(path, comm=COMM), "u.xdmf", [u], [("displacement", "L")])
            for now in (0.0, 0.5):
                u.interpolate(lambda x: (now + x[0] ** degree) * np.ones((gdim, 1)))
                series.write(now)
            series.close()
            COMM.barrier()
            grids = ElementTree.parse(path / "u.xdmf").getroot().findall("Domain/Grid/Grid")
            assert [float(grid.find("Time").get("Value")) for grid in grids] == [0.0, 0.5]
            assert grids[1].find("Topology").get("TopologyType") == name
            attribute = grids[1].find("Attribute")
            assert (attribute.get("Name"), attribute.get("AttributeType")) == ("displacement", "Vector")
            assert attribute.find("Information").get("Value") == "L"
            with h5py.File(path / "u.h5", "r") as file:
                points, cells, topology = (
                    file[item.text.strip().partition(":")[2]][:]
                    for item in (grids[1].find(f"{part}/DataItem") for part in ("Geometry", "Attribute", "Topology"))
                )
                assert file["fields/displacement/1"].attrs["units"] == "L"
                values = file["fields/displacement/1"][:]
            np.testing.assert_array_equal(cells, values)
            corners = {"triangle": 3, "quadrilateral": 4, "tetrahedron": 4, "hexahedron": 8}[cell]
            assert np.sum(np.abs(volumes(cell, points[topology[:, :corners]]))) == pytest.approx(1.0, rel=1e-14)
            if degree == 2:  # a middle between the first two corners comes next, the middle of the cell last
                middle = (points[topology[:, 0]] + points[topology[:, 1]]) / 2
                np.testing.assert_allclose(points[topology[:, corners]], middle, atol=1e-14)
            if degree == 2 and cell in ("quadrilateral", "hexahedron"):
                middle = points[topology[:, :corners]].mean(axis=1)
                np.testing.assert_allclose(points[topology[:, -1]], middle, atol=1e-14)
            expected = np.zeros_like(values)
            expected[:, :gdim] = (0.5 + points[:, 0] ** degree)[:, None]
            np.testing.assert_allclose(values, expected, atol=1e-14)


def check_without_adios2():
    """A DOLFINx that was built without it: the ending .bp says what works, and .xdmf does."""
    domain = DOMAINS["quadrilateral"]()
    steel = di.LinearElastic(1.0, 0.3, 1.0, "plane_strain")
    V = fem.functionspace(domain, ("Lagrange", 2, (2,)))
    problem = di.ExplicitProblem(fem.Function(V), steel)
    writer = dolfinx.io.VTXWriter
    try:
        del dolfinx.io.VTXWriter
        with shared_folder() as path:
            with pytest.raises(RuntimeError, match=r'built without ADIOS2.*record\(..., ending=".xdmf"\)'):
                problem.record(path / "bp")
            recorder = problem.record(path / "run", ["displacement", "velocity", "stress"], every=2, ending=".xdmf")
            dt = 0.5 * problem.stable_step()
            problem.advance(5 * dt, dt=dt, progress=False)
            recorder.close()
            COMM.barrier()
            with h5py.File(path / "run" / "fields.h5", "r") as file:
                assert file["time"][:] == pytest.approx([0.0, 2 * dt, 4 * dt]) and len(file["fields/velocity"]) == 3
            run = RunFolder(path / "once", comm=COMM)
            assert [p.name for p in run.fields("u", [problem.u], xdmf=True)] == ["u.xdmf"]
    finally:
        dolfinx.io.VTXWriter = writer


def check_what_has_no_xdmf():
    u = fem.Function(fem.functionspace(DOMAINS["triangle"](), ("Lagrange", 3)), name="u")
    with shared_folder() as path:
        with pytest.raises(ValueError, match="no triangle cells of 10 nodes.*ending .bp"):
            XdmfSeries(RunFolder(path, comm=COMM), "u.xdmf", [u])


def check_a_series_that_is_removed():
    """The run warns once and goes on; closing the recorder is an error. Static problems likewise."""
    domain = DOMAINS["quadrilateral"]()
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    steel = di.LinearElastic(1.0, 0.3, 1.0, "plane_strain")
    side = fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[0], 0.0))
    held = fem.dirichletbc(np.zeros(2), side, V)
    run = di.ExplicitProblem(fem.Function(V), steel)
    static = di.StaticProblem(fem.Function(V), steel, bcs=held, loads=di.BodyForce((0.0, -1e-3)))
    with shared_folder() as path:
        recorders = [p.record(path / str(k), every=1, ending=".xdmf") for k, p in enumerate((run, static))]
        COMM.barrier()
        if COMM.rank == 0:
            for k in range(2):
                shutil.rmtree(path / str(k))
        COMM.barrier()
        for go_on in (lambda: run.advance(3 * run.stable_step(), progress=False), lambda: static.solve(steps=2)):
            with warnings.catch_warnings(record=True) as told:
                warnings.simplefilter("always")
                go_on()
            assert len(told) == (COMM.rank == 0) and all("is gone" in str(t.message) for t in told)
        for recorder in recorders:
            with pytest.raises(RuntimeError, match="is gone"):
                recorder.close()


def check_fields_of_a_mixed_space():
    """They are expressions, averaged at the vertices."""
    domain = DOMAINS["triangle"]()
    element = basix.ufl.mixed_element(
        [basix.ufl.element("Lagrange", "triangle", 2, shape=(2,)), basix.ufl.element("Lagrange", "triangle", 1)]
    )
    w = fem.Function(fem.functionspace(domain, element), name="w")
    (u, p), (v, q) = ufl.split(w), ufl.TestFunctions(w.function_space)
    residual = ufl.inner(ufl.grad(u), ufl.grad(v)) * ufl.dx + (p - ufl.div(u) - 1.0) * q * ufl.dx
    space, _ = w.function_space.sub(0).collapse()
    sides = fem.locate_dofs_geometrical((w.function_space.sub(0), space), lambda x: np.isclose(x[0], 0.0))
    problem = di.StaticProblem(
        w, residual=residual, bcs=fem.dirichletbc(fem.Function(space), sides, w.function_space.sub(0))
    )
    with pytest.raises(ValueError, match=r"mixed space.*fields=\[\] and expressions="):
        problem.record("x")
    with shared_folder() as path:
        recorder = problem.record(path / "run", [], expressions={"moved": u, "p": p}, ending=".xdmf")
        problem.solve()
        recorder.close()
        COMM.barrier()
        with h5py.File(path / "run" / "materials.h5", "r") as file:
            assert {*file["fields"]} == {"moved_0", "moved_1", "p"}
            np.testing.assert_allclose(file["fields/p/0"][:], 1.0, atol=1e-9)
