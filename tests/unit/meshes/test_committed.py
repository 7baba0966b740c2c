# SPDX-License-Identifier: MIT
"""The committed meshes: unchanged, small, readable, and still what their recipe makes."""

import pytest
from mesh_modules import committed, exact, mesh_input, meshes, quality, volumes
from mpi4py import MPI


def test_checksums():
    listed = committed.checksums()
    assert set(listed) == set(committed.FILES) == {file.name for file in committed.FOLDER.iterdir()}
    for name, digest in listed.items():
        assert committed.path(name).stat().st_size < 150_000
        assert committed.checksum(committed.path(name)) == digest, f"{name} is not the file in checksums.txt"


@pytest.mark.parametrize("name", committed.FILES)
def test_read(name):
    recipe, parameters = committed.FILES[name]
    made = meshes.make(recipe, MPI.COMM_SELF, **parameters)
    facets = [tag for tag in made.tags if tag in meshes.FACETS]
    read = mesh_input.read_mesh(committed.path(name), MPI.COMM_SELF, required_facet_tags=facets)
    assert {**read.cell_names, **read.facet_names} == made.tags
    assert read.mesh.geometry.dim == made.mesh.geometry.dim
    assert quality(read.mesh) > 0.05
    if "tetra" not in name:  # free tetrahedra depend on the version of gmsh
        counts = [m.topology.index_map(m.topology.dim).size_global for m in (read.mesh, made.mesh)]
        assert counts[0] == counts[1] == read.report.num_cells
    sizes = volumes(read.mesh, read.cell_tags)
    for body, size in exact(recipe, made.parameters).items():
        assert sizes[meshes.BODIES[body]] == pytest.approx(size, rel=0.05)


def test_unknown_name():
    with pytest.raises(ValueError, match="no committed mesh 'x.msh'; there are: distorted_hexahedra.msh"):
        committed.path("x.msh")
