# SPDX-License-Identifier: MIT
"""Meshes of Abaqus, MED and Exodus by meshio: sets become tags with names, on any number of ranks. See on_ranks.py."""

import contextlib

import numpy as np
import pytest
import ufl
from dolfinx import fem
from mpi4py import MPI
from shared_folder import shared_folder

import dolfinx_impact as di
from dolfinx_impact.io import meshio_reader

COMM = MPI.COMM_WORLD

PLATE = """*HEADING
a plate of two parts, 2 by 1
*NODE, NSET=ALL
 1, 0.0, 0.0
 2, 1.0, 0.0
 3, 2.0, 0.0
 14, 0.0, 1.0
 15, 1.0, 1.0
 16, 2.0, 1.0
*ELEMENT, TYPE=CPS4, ELSET=LEFT
 10, 1, 2, 15, 14
*ELEMENT, TYPE=CPS4, ELSET=RIGHT
 20, 2, 3, 16, 15
*NSET, NSET=foot
 1, 2, 3
*NSET, NSET=corner
 16
*ELSET, ELSET=_head_S3
 10, 20
*SURFACE, TYPE=ELEMENT, NAME=head
_head_S3, S3
*SURFACE, TYPE=ELEMENT, NAME=end
RIGHT, S2
*STEP
"""


def lengths(read):
    """Length or area of each set of facets by name, and of each set of cells."""
    out = {}
    for names, tags, measure in (
        (read.facet_names, read.facet_tags, ufl.ds),
        (read.cell_names, read.cell_tags, ufl.dx),
    ):
        d = measure(domain=read.mesh, subdomain_data=tags)
        one = fem.Constant(read.mesh, 1.0)
        for name, tag in names.items():
            out[name] = COMM.allreduce(fem.assemble_scalar(fem.form(one * d(tag))), MPI.SUM)
    return out


def write(path, text):
    if COMM.rank == 0:
        path.write_text(text)
    COMM.barrier()


def check_abaqus():
    with shared_folder() as folder:
        write(folder / "plate.inp", PLATE)
        with pytest.warns(UserWarning, match="'corner' holds no facet") if COMM.rank == 0 else contextlib.nullcontext():
            read = di.read_mesh(folder / "plate.inp", sets=["LEFT", "RIGHT", "head", "foot", "end"])
        assert read.cell_names == {"LEFT": 1, "RIGHT": 2} and {*read.facet_names} == {"head", "foot", "end"}
        found = lengths(read)
        assert found == pytest.approx({"head": 2.0, "foot": 2.0, "end": 1.0, "LEFT": 1.0, "RIGHT": 1.0}, rel=1e-12)
        assert read.mesh.geometry.dim == 2
        # The sets by their names in a problem.
        V = fem.functionspace(read.mesh, ("Lagrange", 1, (2,)))
        pair = di.ContactPair(read.facet_tags, read.facet_names["foot"], di.RigidPlane((0.0, 0.0), (0.0, 1.0)))
        law = di.MaterialMap(read.cell_tags, {1: material(), 2: material()})
        di.StaticProblem(fem.Function(V), law, contact=di.Lagrange(pair))


def material():
    return di.LinearElastic(E=1.0, nu=0.3, density=1.0, hypothesis="plane_strain")


def written(cell, degree, folder):
    """A file of MED by meshio: a unit block with groups of cells "low" and "high", and of facets "top" and "foot"."""
    import gmsh
    import meshio

    path = folder / f"{cell}{degree}.med"
    if COMM.rank == 0:
        gmsh.initialize(interruptible=False)
        gmsh.option.setNumber("General.Terminal", 0)
        plane = cell in ("triangle", "quad")
        occ = gmsh.model.occ
        if plane:
            parts = [(2, occ.addRectangle(0, y, 0, 1, 0.5)) for y in (0.0, 0.5)]
        else:
            parts = [(3, occ.addBox(0, 0, z, 1, 1, 0.5)) for z in (0.0, 0.5)]
        occ.fragment(parts[:1], parts[1:])
        occ.synchronize()
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.4)
        if cell in ("quad", "hexahedron"):
            for dim in (1, 2, 3):
                for _, tag in gmsh.model.getEntities(dim):
                    if dim == 1:
                        gmsh.model.mesh.setTransfiniteCurve(tag, 3)
                    elif dim == 2:
                        gmsh.model.mesh.setTransfiniteSurface(tag)
                        gmsh.model.mesh.setRecombine(2, tag)
                    else:
                        gmsh.model.mesh.setTransfiniteVolume(tag)
        dim = 2 if plane else 3
        gmsh.model.mesh.generate(dim)
        gmsh.model.mesh.setOrder(degree)
        numbers, x, _ = gmsh.model.mesh.getNodes()
        place = np.zeros(int(numbers.max()) + 1, dtype=int)
        place[numbers.astype(int)] = np.arange(len(numbers))
        suffix = {"triangle": "6", "quad": "9", "tetra": "10", "hexahedron": "27"}
        facet = {"triangle": "line", "quad": "line", "tetra": "triangle", "hexahedron": "quad"}[cell]
        kind = cell if degree == 1 else cell + suffix[cell]
        face = facet if degree == 1 else {"line": "line3", "triangle": "triangle6", "quad": "quad9"}[facet]
        blocks, families = [], []
        for of, name, groups in ((dim, kind, (-1, -2)), (dim - 1, face, (-3, -4))):
            rows, tags = [], []
            for _, entity in gmsh.model.getEntities(of):
                middle = np.array(gmsh.model.occ.getCenterOfMass(of, entity))[dim - 1]
                if of == dim:
                    tag = groups[0] if middle < 0.5 else groups[1]
                else:
                    tag = {0.0: groups[0], 1.0: groups[1]}.get(round(middle, 9))
                if tag is None:
                    continue
                _, _, nodes = gmsh.model.mesh.getElements(of, entity)
                n = len(nodes[0]) // len(gmsh.model.mesh.getElements(of, entity)[1][0])
                rows.append(place[nodes[0].astype(int)].reshape(-1, n))
                tags += [tag] * len(rows[-1])
            from meshio.gmsh.common import _gmsh_to_meshio_order

            blocks.append((name, _gmsh_to_meshio_order(name, np.vstack(rows))))
            families.append(np.array(tags))
        made = meshio.Mesh(x.reshape(-1, 3)[:, :dim], blocks, cell_data={"cell_tags": families})
        made.cell_tags = {-1: ["low"], -2: ["high"], -3: ["foot"], -4: ["top"]}
        meshio.write(path, made)
        gmsh.finalize()
    COMM.barrier()
    return path


def check_med_files_of_all_cells_and_degrees():
    with shared_folder() as folder:
        for cell in ("triangle", "quad", "tetra", "hexahedron"):
            for degree in (1, 2):
                if cell in ("quad", "hexahedron") and degree == 2:
                    continue  # meshio writes no MED of 9 and 27 nodes
                read = di.read_mesh(written(cell, degree, folder))
                assert read.cell_names == {"low": 1, "high": 2} and read.facet_names == {"foot": 1, "top": 2}
                exact = {"low": 0.5, "high": 0.5, "foot": 1.0, "top": 1.0}
                assert lengths(read) == pytest.approx(exact, rel=1e-12), (cell, degree)


def check_all_orders_of_nodes():
    """Cells of degree 2 whose nodes are moved are those that were written: the volume of a bent hexahedron."""
    import meshio

    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
    edges = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
    faces = [(0, 3, 4, 7), (1, 2, 5, 6), (0, 1, 4, 5), (2, 3, 6, 7), (0, 1, 2, 3), (4, 5, 6, 7)]
    x = np.vstack(
        [corners, *(corners[list(n)].mean(axis=0)[None] for n in (*edges, *faces)), corners.mean(axis=0)[None]]
    )
    x[:, 2] += 0.3 * x[:, 0] * (1 - x[:, 0])  # top and bottom are parallel: the volume stays
    one = meshio.Mesh(x, [("hexahedron27", np.arange(27)[None])], cell_sets={"body": [np.array([0])]})
    one.point_sets = {"top": np.flatnonzero(np.isclose(x[:, 2] - 0.3 * x[:, 0] * (1 - x[:, 0]), 1.0))}
    read = through(one)
    found = lengths(read)
    assert found["body"] == pytest.approx(1.0, rel=1e-12)
    # Length of the parabola of height 0.3/4 over 1: a, by its closed form.
    a = 0.3
    assert found["top"] == pytest.approx(0.5 * np.sqrt(1 + a**2) + np.arcsinh(a) / (2 * a), rel=1e-3)


def through(made, name="made.inp"):
    """A mesh as if meshio had read it from a file."""
    import meshio

    right = meshio.read
    with shared_folder() as folder:
        write(folder / name, "*HEADING\n")
        meshio.read = lambda path: made
        try:
            return di.read_mesh(folder / name)
        finally:
            meshio.read = right
            COMM.barrier()


def check_facets_of_all_kinds_of_cells():
    """Facets that all nodes hold are the boundary of one cell, each with as many nodes as its kind has; their numbers
    are those of Abaqus."""
    for kind, (_, dim, _) in meshio_reader._TYPES.items():
        if dim < 2 or kind not in meshio_reader._FACETS:
            continue
        count = 1 + max(map(max, meshio_reader._FACETS[kind]))
        cells = np.arange(count)[None]
        facets = meshio_reader._Facets(kind, cells)
        found = facets.within(np.ones(count, dtype=bool))
        assert len(found) == len(meshio_reader._FACETS[kind]), kind
        assert np.array_equal(facets.of_cells([(np.array([0]), 1)])[0], meshio_reader._FACETS[kind][1])
        assert meshio_reader.SetsMesh(np.zeros((count, 3)), kind, cells, np.zeros(1)).dim == dim


def check_exodus_blocks():
    """Blocks of Exodus, as meshio gives them, without names; node sets with theirs."""
    import meshio

    x = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0]], float)
    made = meshio.Mesh(
        x, [("quad", np.array([[0, 1, 4, 3]])), ("quad", np.array([[1, 2, 5, 4]]))], info=["made by hand"]
    )
    made.point_sets = {"foot": np.array([0, 1, 2])}
    read = through(made, "made.exo")
    assert read.cell_names == {"block 1": 1, "block 2": 2}
    assert lengths(read) == pytest.approx({"block 1": 1.0, "block 2": 1.0, "foot": 2.0}, rel=1e-12)


def check_what_is_refused():
    changed = {
        "overlap": (PLATE + "*NSET, NSET=base\n1, 2\n", ValueError, "the sets 'foot' and 'base' have facets in common"),
        "cells": (PLATE.replace("*NSET, NSET=foot", "*ELSET, ELSET=both\n10, 20\n*NSET, NSET=foot"), ValueError,
                  "have cells in common.*sets="),
        "numbers": (PLATE.replace("RIGHT, S2", "20, S2"), ValueError, "the surface 'end' is made of '20, S2'"),
        "kind": (PLATE.replace("CPS4", "CPS8"), ValueError, "meshio cannot read it"),
        "damaged": ("*NODE\n1, 0, 0, 0\n*ELEMENT, TYPE=CPS4\n1, 1, 2, 3, 4\n", ValueError, "meshio cannot read it"),
    }  # fmt: skip
    with shared_folder() as folder:
        for name, (text, error, words) in changed.items():
            write(folder / f"{name}.inp", text)
            with pytest.raises(error, match=words):
                di.read_mesh(folder / f"{name}.inp")
        write(folder / "plate.inp", PLATE)
        with pytest.raises(ValueError, match=r"no sets \['side'\]; there are LEFT, RIGHT"):
            di.read_mesh(folder / "plate.inp", sets=["side"])
        with pytest.raises(TypeError, match="sets must be a list of names"):
            di.read_mesh(folder / "plate.inp", sets="LEFT")
        with pytest.raises(ValueError, match="sets is for files that meshio reads"):
            di.read_mesh(folder / "plate.msh", sets=["LEFT"])
        with pytest.raises(FileNotFoundError, match="none.inp"):
            di.read_mesh(folder / "none.inp")


def check_without_meshio_or_what_it_needs():
    """A sentence on all ranks."""
    import sys

    with shared_folder() as folder:
        write(folder / "plate.inp", PLATE)
        write(folder / "plate.exo", "CDF")
        for module, name in (("meshio", "plate.inp"), ("netCDF4", "plate.exo")):
            kept = sys.modules.get(module)
            sys.modules[module] = None  # as if it were not installed
            try:
                with pytest.raises(RuntimeError, match=f"the Python module {module}.*not installed"):
                    di.read_mesh(folder / name)
            finally:
                if kept is None:
                    del sys.modules[module]
                else:
                    sys.modules[module] = kept
                COMM.barrier()
