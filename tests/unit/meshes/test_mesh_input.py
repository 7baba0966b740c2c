# SPDX-License-Identifier: MIT
"""read_mesh and check_mesh: good files, and what is said about bad ones."""

import warnings

import bad_files
import numpy as np
import pytest
from dolfinx import io, mesh
from mesh_modules import committed, mesh_input, meshes
from mpi4py import MPI

from dolfinx_impact import compat

GOOD = committed.path("distorted_hexahedra.msh")
KEYS = [*bad_files.MESHES, "empty.msh", "picture.msh", "geometry.msh", "cut_0.2.msh", "cut_0.5.msh", "cut_0.8.msh"]
KEYS += [
    "cut_0.99.msh",
    "lines_lost.msh",
    "solid_as_plane.msh",
    "mesh.stl",
    "broken.xdmf",
    "no_grid.xdmf",
    "missing.msh",
]
KEYS += ["bad_gdim"]


@pytest.fixture(scope="module")
def cases(tmp_path_factory):
    found = bad_files.write_all(tmp_path_factory.mktemp("bad"), GOOD)
    assert set(found) == set(KEYS)
    return found


@pytest.mark.timeout(30)
@pytest.mark.parametrize("key", KEYS)
def test_bad_file(cases, key):
    path, arguments, error, words = cases[key]
    with pytest.raises(error) as caught, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        mesh_input.read_mesh(path, MPI.COMM_SELF, **arguments)
    for word in words:
        assert word in str(caught.value), str(caught.value)


def test_good_file_and_names(tmp_path):
    path = bad_files.msh(tmp_path / "good.msh")
    read = mesh_input.read_mesh(path, MPI.COMM_SELF, required_cell_tags=("body",), required_facet_tags=("low", 4))
    domain, cell_tags, facet_tags = read
    assert domain.geometry.dim == 2 and set(cell_tags.values) == {1} and set(facet_tags.values) == {3, 4}
    assert read.facet_names == {"low": 3, "high": 4}
    assert read.report.num_cells == 2 and read.report.num_negative == 0 and read.report.facet_counts == {3: 2, 4: 1}
    assert mesh_input.read_mesh(path, MPI.COMM_SELF, gdim=3).mesh.geometry.dim == 3


def test_a_consistent_orientation_is_no_fault(tmp_path):
    clockwise = [(3, 1, (4, 3, 2, 1)), (3, 1, (3, 6, 5, 2))]
    path = bad_files.msh(tmp_path / "clockwise.msh", elements=clockwise, names=((2, 1, "body"),))
    assert mesh_input.read_mesh(path, MPI.COMM_SELF).report.num_negative == 2


def test_warnings(tmp_path):
    nodes = [*bad_files.SQUARE, (1, 0, 0), (9, 9, 0)]
    cracked = [bad_files.QUADS[0], (3, 1, (7, 5, 6, 3)), (15, 9, (8,))]
    path = bad_files.msh(tmp_path / "loose.msh", nodes=nodes, elements=cracked)
    with pytest.warns(UserWarning) as caught:
        mesh_input.read_mesh(path, MPI.COMM_SELF)
    said = " ".join(str(w.message) for w in caught)
    assert "1 nodes belong to no cell (first: [8])" in said and 'nodes of 1 ("body") lie on another node' in said


@pytest.mark.parametrize("recipe, degree", [("block", 1), ("cylinder_on_half_plane", 2), ("sphere_on_half_space", 1)])
def test_xdmf_round_trip(tmp_path, recipe, degree):
    m = meshes.make(recipe, MPI.COMM_SELF, degree=degree)
    path = tmp_path / "mesh.xdmf"
    write_xdmf(path, m)
    read = mesh_input.read_mesh(path, MPI.COMM_SELF, required_facet_tags=sorted(set(m.facet_tags.values)))
    before = mesh_input.check_mesh(m.mesh, m.cell_tags, m.facet_tags)
    assert read.report.facet_counts == before.facet_counts and read.report.cell_counts == before.cell_counts
    assert compat.coordinate_element(read.mesh).degree == degree
    data = path.with_suffix(".h5")
    data.write_bytes(data.read_bytes()[:3000])
    with pytest.raises(ValueError, match="mesh.h5 is damaged|has no dataset"):
        mesh_input.read_mesh(path, MPI.COMM_SELF)
    data.unlink()
    with pytest.raises(FileNotFoundError, match="keep the .xdmf and the .h5 file together"):
        mesh_input.read_mesh(path, MPI.COMM_SELF)


def write_xdmf(path, m):
    with io.XDMFFile(m.mesh.comm, path, "w") as file:
        file.write_mesh(m.mesh)
        for tags in (m.cell_tags, m.facet_tags):
            m.mesh.topology.create_connectivity(tags.dim, m.mesh.topology.dim)
            file.write_meshtags(tags, m.mesh.geometry)


def test_check_names_the_bad_cells():
    domain = mesh.create_rectangle(MPI.COMM_SELF, [(0, 0), (1, 1)], (4, 4), mesh.CellType.quadrilateral)
    assert mesh_input.check_mesh(domain).num_cells == 16
    nodes = compat.geometry_dofmap(domain)[[3, 9]]
    for cell in nodes:
        domain.geometry.x[cell[3]] = domain.geometry.x[cell].mean(axis=0) - 0.4 * np.array((1, 1, 0))
    with pytest.raises(ValueError) as caught:
        mesh_input.check_mesh(domain, where="plate")
    assert str(caught.value).startswith("plate: ") and "cell 3, centre (" in str(caught.value)


def test_reading_leaves_gmsh_as_it_was():
    import gmsh

    gmsh.initialize(interruptible=False)
    try:
        gmsh.model.add("mine")
        mesh_input.read_mesh(GOOD, MPI.COMM_SELF)
        meshes.make("block", MPI.COMM_SELF)
        assert gmsh.model.getCurrent() == "mine" and "mine" in gmsh.model.list()
        assert gmsh.option.getNumber("General.Terminal") == 1
    finally:
        gmsh.finalize()


def test_a_mesh_unpacks_with_its_tags_and_keeps_its_report():
    domain = mesh.create_unit_square(MPI.COMM_SELF, 2, 2)
    tags = mesh.meshtags(domain, 2, np.arange(8, dtype=np.int32), np.repeat([3, 4], 4).astype(np.int32))
    report = mesh_input.check_mesh(domain, tags)
    assert isinstance(report, mesh_input.MeshReport) and report.cell_counts == {3: 4, 4: 4} and report.num_cells == 8
    # Right-angled triangles with legs of 1/2: |det J| is 1/4, their extent 1/2.
    assert report.smallest_det == pytest.approx(1.0, rel=1e-14)
    found = mesh_input.MeshInput(domain, tags, None, {"steel": 3}, report=report)
    assert tuple(found) == (domain, tags, None) and found.facet_names == {}
