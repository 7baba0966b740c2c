# SPDX-License-Identifier: MIT
"""Run by test_mpi.py on several ranks: recipes and bad files must behave the same on every rank. Prints "agreed"."""

import sys
import warnings
from pathlib import Path

import bad_files
from mesh_modules import CASES, committed, exact, mesh_input, meshes, quality, volumes
from mpi4py import MPI

from dolfinx_impact import compat

comm = MPI.COMM_WORLD


def same(value):
    values = comm.allgather(value)
    assert all(v == values[0] for v in values), values
    return value


def counts_alone(name, parameters):
    """Of cells, of tagged facets and of tagged cells where one rank makes the mesh."""
    m = meshes.make(name, MPI.COMM_SELF, **parameters)
    report = mesh_input.check_mesh(m.mesh, m.cell_tags, m.facet_tags)
    return report.num_cells, report.facet_counts, report.cell_counts


def recipes():
    for case in (
        "two_blocks",
        "cylinder",
        "sphere",
        "cone",
        "punch_round",
        "two_bars",
        "wheel_2d",
        "joint_2d_wheel",
        "joint_3d",
    ):
        name, parameters, _ = CASES[case]
        m = meshes.make(name, comm, **parameters)
        facets = [tag for key, tag in m.tags.items() if key in meshes.FACETS]
        report = same(mesh_input.check_mesh(m.mesh, m.cell_tags, m.facet_tags, required_facet_tags=facets))
        num_cells, facet_counts, cell_counts = comm.bcast(counts_alone(name, parameters) if comm.rank == 0 else None)
        assert report.num_cells == num_cells
        assert report.facet_counts == facet_counts and report.cell_counts == cell_counts
        assert quality(m.mesh) > 0.3
        found = volumes(m.mesh, m.cell_tags)
        for body, size in exact(name, m.parameters).items():
            assert abs(found[meshes.BODIES[body]] / size - 1) < 0.02, (name, body)
    for arguments in ({"radius": -1.0}, {"nonsense": 1}, {"cell": "hexahedron"}):
        try:
            meshes.make("cylinder_on_half_plane", comm, **arguments)
        except ValueError as error:
            same(str(error))
        else:
            raise AssertionError(f"{arguments} was accepted")


def files(folder):
    cases = bad_files.write_all(folder, committed.path("distorted_hexahedra.msh")) if comm.rank == 0 else None
    for name, (path, arguments, kind, words) in comm.bcast(cases).items():
        try:
            mesh_input.read_mesh(path, comm, **arguments)
        except kind as error:
            said = same(str(error))
            assert all(word in said for word in words), (name, said)
        else:
            raise AssertionError(f"{name} was accepted")
    for name in committed.FILES:
        report = same(mesh_input.read_mesh(committed.path(name), comm).report)
        assert report.num_cells == mesh_input.read_mesh(committed.path(name), MPI.COMM_SELF).report.num_cells
    m = meshes.make("cylinder_on_half_plane", comm)
    where = comm.bcast(folder / "parallel.xdmf")
    from test_mesh_input import write_xdmf

    write_xdmf(where, m)
    read = mesh_input.read_mesh(where, comm)
    before = mesh_input.check_mesh(m.mesh, m.cell_tags, m.facet_tags)
    assert same(read.report.facet_counts) == before.facet_counts


def one_bad_rank():
    """A cell folded on the last rank only is reported by all."""
    m = meshes.make("block", comm, cells=(12, 12))
    if comm.rank == comm.size - 1:
        cell = compat.geometry_dofmap(m.mesh)[0]
        m.mesh.geometry.x[cell] = m.mesh.geometry.x[cell[[1, 0, 2, 3]]]
    try:
        mesh_input.check_mesh(m.mesh, m.cell_tags)
    except ValueError as error:
        assert "folded" in same(str(error))
    else:
        raise AssertionError("a folded cell was accepted")


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    recipes()
    files(Path(sys.argv[1]))
    one_bad_rank()
    comm.barrier()
    if comm.rank == 0:
        print("agreed")
