# SPDX-License-Identifier: MIT
"""Reads meshes from files and checks them.

`read_mesh` reads gmsh .msh files and XDMF files written by DOLFINx, `check_mesh` checks any mesh. Both are collective,
and an error is the same on every rank. A bad file raises ValueError, a missing one FileNotFoundError.
"""

from __future__ import annotations

import os
import re
import warnings
import xml.etree.ElementTree as ElementTree
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

from mpi4py import MPI

import numpy as np
from dolfinx import io
from dolfinx.mesh import Mesh, MeshTags

from .. import compat
from ..common.collective import guard
from ..common.types import FilePath, IntArray
from . import meshio_reader
from .gather import together
from .mesh_check import SHOWN, MeshReport, check_mesh, label

__all__ = ["MeshInput", "MeshReport", "check_mesh", "read_mesh"]


# gmsh element type -> cell and degree, of those that DOLFINx reads and this package has kernels for
_GMSH = {
    2: ("triangle", 1), 3: ("quadrilateral", 1), 4: ("tetrahedron", 1), 5: ("hexahedron", 1),
    9: ("triangle", 2), 10: ("quadrilateral", 2), 11: ("tetrahedron", 2), 12: ("hexahedron", 2),
}  # fmt: skip
_FACET = {2: 1, 3: 1, 4: 2, 5: 3, 9: 8, 10: 8, 11: 9, 12: 10}  # type of a cell -> type of its facets
_ROWS = 1_000_000  # rows of a table that are in memory at the same time
_XDMF_DIMENSION = {
    "polyvertex": 0,
    "polyline": 1,
    "edge": 1,
    "triangle": 2,
    "quadrilateral": 2,
    "tetrahedron": 3,
    "hexahedron": 3,
}


@dataclass
class MeshInput:
    """A mesh with its tags; unpacks as (mesh, cell_tags, facet_tags).

    Attributes:
        mesh: mesh.
        cell_tags: tags of cells; None if the file has none.
        facet_tags: tags of facets; None if the file has none.
        cell_names: tags of cells by the names of the file's physical groups.
        facet_names: tags of facets by the names of the file's physical groups.
        report: what `check_mesh` found.
    """

    mesh: Mesh
    cell_tags: MeshTags | None
    facet_tags: MeshTags | None
    cell_names: dict[str, int] = field(default_factory=dict)
    facet_names: dict[str, int] = field(default_factory=dict)
    report: MeshReport | None = None

    def __iter__(self) -> Iterator[Any]:
        return iter((self.mesh, self.cell_tags, self.facet_tags))


def read_mesh(
    path: FilePath,
    comm: MPI.Intracomm = MPI.COMM_WORLD,
    gdim: int | None = None,
    required_cell_tags: Iterable[int | str] = (),
    required_facet_tags: Iterable[int | str] = (),
    sets: Sequence[str] | None = None,
) -> MeshInput:
    """Read and check a mesh with its cell and facet tags. Collective.

    Args:
        path: gmsh .msh file, XDMF file written by DOLFINx, or, where meshio is installed, a file of Abaqus (.inp), MED
            (.med) or Exodus (.e, .exo), whose sets of elements and nodes and surfaces become tags 1, 2, ... with names;
            cells in no set have the next tag, without a name.
        comm: communicator of the mesh.
        gdim: geometric dimension, 2 or 3; None: 2 for a flat mesh of triangles or quadrilaterals, otherwise 3 [1].
        required_cell_tags: tags of cells, or in a .msh file their names, that must not be empty.
        required_facet_tags: tags of facets, or in a .msh file their names, that must not be empty.
        sets: of files that meshio reads: names of the sets that become tags, which must not overlap; None: all.

    Returns:
        Mesh, tags, names and what was found.

    Raises:
        TypeError: an argument is of the wrong type.
        ValueError: the file is damaged, or its mesh is bad; on all ranks.
        FileNotFoundError: there is no such file; on all ranks.
        RuntimeError: gmsh or meshio is needed and is not there; on all ranks.

    Warns:
        UserWarning: parts of the file are left out.
    """
    if not isinstance(comm, MPI.Comm):
        raise TypeError(f"comm must be a communicator of mpi4py, found {type(comm).__name__}")
    with guard(comm, "read_mesh", path=path, gdim=gdim) as ranks:
        if not isinstance(path, (str, os.PathLike)):
            raise TypeError(f"path must be the name of a file, found {type(path).__name__}")
        path = Path(path)
        kinds = {".msh": "msh", ".xdmf": "xdmf", ".xmf": "xdmf"} | dict.fromkeys(meshio_reader.KINDS, "meshio")
        kind = kinds.get(path.suffix.lower())
        if gdim not in (None, 2, 3):
            raise ValueError(f"gdim = {gdim!r}: 2 or 3")
        if kind is None:
            raise ValueError(
                f"{path}: a mesh is read from a .msh (gmsh) or an .xdmf (DOLFINx) file, or by meshio from "
                f"{', '.join(meshio_reader.KINDS)}; convert it, e.g. with gmsh"
            )
        if sets is not None and (isinstance(sets, str) or not all(isinstance(name, str) for name in sets)):
            raise TypeError(f"sets must be a list of names, found {sets!r:.60}")
        if sets is not None and kind != "meshio":
            raise ValueError("sets is for files that meshio reads; of a .msh file all physical groups are tags")
        ranks.same(sets=None if sets is None else list(sets))
        ranks.same(required_cell_tags=list(required_cell_tags), required_facet_tags=list(required_facet_tags))
    if kind == "xdmf":
        result, tags_in_file, numbers = _read_xdmf(path, comm, gdim)
    elif kind == "msh":
        together(comm, lambda: _check_msh_text(path))
        result, tags_in_file, numbers = _read_gmsh(path, comm, gdim, lambda gmsh: _merge(gmsh, path))
    else:
        result, tags_in_file, numbers = _read_gmsh(path, comm, gdim, lambda gmsh: _fill(gmsh, path, sets))
    result.report = check_mesh(
        result.mesh, result.cell_tags, result.facet_tags, required_cell_tags, required_facet_tags,
        cell_names=result.cell_names, facet_names=result.facet_names, where=str(path), numbers=numbers,
    )  # fmt: skip
    for tag, expected in tags_in_file.items():
        found = result.report.facet_counts.get(tag, 0)
        if found != expected:
            raise ValueError(
                f"{path}: of the {expected} facets tagged {label(tag, result.facet_names)} only {found} are facets "
                "of a cell and in no other group; remesh so that tagged surfaces bound the bodies, and tag a facet once"
            )
    return result


def _exists(path: Path) -> None:
    """Raise FileNotFoundError or ValueError unless there is a file that is not empty."""
    if not path.exists():
        near = sorted(p.name for p in path.parent.glob(f"*{path.suffix}")) if path.parent.is_dir() else []
        raise FileNotFoundError(
            f"{path}: no such file; in that folder there are: {', '.join(near[:10]) or 'no such files'}"
        )
    if not path.is_file() or path.stat().st_size == 0:
        raise ValueError(f"{path}: {'is empty' if path.is_file() else 'is not a file'}; write the mesh again")


# --- gmsh -----------------------------------------------------------------------------------------------------------


def _merge(gmsh: ModuleType, path: Path) -> list[str]:
    """Read a gmsh file into gmsh's current model, on rank 0."""
    try:
        gmsh.merge(str(path))
    except Exception as error:
        said = "; ".join(line for line in gmsh.logger.get() if line.startswith("Error")) or str(error)
        raise ValueError(f"{path}: gmsh cannot read it ({said}); it is damaged, write it again") from error
    return []


def _fill(gmsh: ModuleType, path: Path, sets: Sequence[str] | None) -> list[str]:
    """Read another program's file into gmsh's current model, on rank 0.

    Returns:
        What was left out.
    """
    _exists(path)
    mesh = meshio_reader.read_sets(path, sets)
    meshio_reader.fill(gmsh, mesh)
    return mesh.notes


def _read_gmsh(
    path: Path, comm: MPI.Intracomm, gdim: int | None, fill: Callable[[ModuleType], list[str]]
) -> tuple[MeshInput, dict[int, int], IntArray | None]:
    """Read a mesh by way of gmsh. Collective.

    Args:
        path: file.
        comm: communicator of the mesh.
        gdim: geometric dimension that was asked for, or None [1].
        fill: function that brings the file into gmsh's current model, and returns what was left out; for rank 0.

    Returns:
        Mesh and tags, number of facets in the file by tag, and gmsh's numbers of the cells (on rank 0 only).
    """
    try:
        import gmsh
    except ImportError as error:
        raise RuntimeError(f"{path}: reading {path.suffix} files needs the Python module gmsh") from error
    state: dict[str, Any] = {}

    def load() -> tuple[int, dict[str, int], dict[str, int], dict[int, int], list[str]]:
        state["mine"] = not gmsh.isInitialized()
        if state["mine"]:
            gmsh.initialize(interruptible=False)
        state["terminal"] = gmsh.option.getNumber("General.Terminal")
        gmsh.option.setNumber("General.Terminal", 0)
        state["before"] = gmsh.model.getCurrent()
        gmsh.model.add("dolfinx_impact.io.mesh_reader")
        gmsh.logger.start()
        left_out = fill(gmsh)
        dimension, cell_names, facet_names, facets, notes = _check_msh_model(gmsh.model, path, gdim)
        state["numbers"] = _cell_numbers(gmsh.model)
        return dimension, cell_names, facet_names, facets, [*left_out, *notes]

    try:
        dimension, cell_names, facet_names, facets, notes = together(comm, load)
        for note in notes if comm.rank == 0 else ():
            warnings.warn(f"{path}: {note}", stacklevel=4)
        mesh, cell_tags, facet_tags = compat.model_to_mesh(gmsh.model, comm, 0, gdim=dimension)
    finally:
        if state:
            gmsh.logger.stop()
            gmsh.model.remove()
            gmsh.option.setNumber("General.Terminal", state["terminal"])
            if state["mine"]:
                gmsh.finalize()
            elif state["before"]:
                gmsh.model.setCurrent(state["before"])
    return MeshInput(mesh, cell_tags, facet_tags, cell_names, facet_names), facets, state.get("numbers")


def _cell_numbers(model: ModuleType) -> IntArray:
    """Gmsh's element numbers in the order in which DOLFINx reads the cells.

    Args:
        model: gmsh.model.
    """
    tdim = model.getDimension()
    groups = [tag for dim, tag in model.getPhysicalGroups() if dim == tdim]
    entities = [entity for tag in groups for entity in model.getEntitiesForPhysicalGroup(tdim, tag)]
    return np.concatenate([numbers for entity in entities for numbers in model.mesh.getElements(tdim, entity)[1]])


def _check_msh_text(path: Path) -> None:
    """Check that the file exists, is a gmsh file, and closes every section that it opens."""
    _exists(path)
    data = path.read_bytes()
    if not data.lstrip().startswith(b"$MeshFormat"):
        raise ValueError(f"{path}: not a gmsh mesh, it starts with {data[:20]!r} instead of $MeshFormat")
    # `(?m)^` matches at line starts only; binary files may contain "$" inside numbers.
    opened = [s.decode() for s in re.findall(rb"(?m)^\$((?!End)[A-Za-z]+)\r?$", data)]
    for section in dict.fromkeys(opened):
        if f"$End{section}".encode() not in data:
            raise ValueError(f"{path}: section ${section} has no $End{section}: the file is cut off, write it again")
    for section in ("Nodes", "Elements"):
        if section not in opened:
            raise ValueError(f"{path}: no section ${section}: it has no mesh; mesh the geometry before writing it")


def _check_msh_model(
    model: ModuleType, path: Path, gdim: int | None
) -> tuple[int, dict[str, int], dict[str, int], dict[int, int], list[str]]:
    """Check a gmsh model before DOLFINx reads it.

    Args:
        model: gmsh.model.
        path: file, for messages.
        gdim: geometric dimension that was asked for, or None [1].

    Returns:
        Geometric dimension, tags of cells by name, tags of facets by name, number of facets by tag, and notes about
        parts of the file that are left out.
    """
    nodes, x, _ = model.mesh.getNodes()
    x = x.reshape(-1, 3)
    types = {dim: model.mesh.getElements(dim)[0] for dim in (1, 2, 3)}
    tdim = max((dim for dim in types if len(types[dim])), default=0)
    if tdim < 2:
        raise ValueError(
            f"{path}: has no triangles, quadrilaterals, tetrahedra or hexahedra; mesh the surfaces or volumes"
        )
    if not np.all(np.isfinite(x)):
        raise ValueError(
            f"{path}: nodes {nodes[~np.isfinite(x).all(axis=1)][:SHOWN].tolist()} have coordinates nan or inf"
        )
    groups = model.getPhysicalGroups()
    names = {dim: {model.getPhysicalName(d, t) or str(t): t for d, t in groups if d == dim} for dim in (tdim - 1, tdim)}
    if not names[tdim]:
        there = ", ".join(f"{t} of dimension {d}" for d, t in groups) or "none at all"
        raise ValueError(
            f"{path}: no physical group of dimension {tdim} holds the cells (there are {there}); in gmsh: "
            f'Physical {"Surface" if tdim == 2 else "Volume"}("body", 1) = {{...}};'
        )
    counts: Counter[int] = Counter()  # cells by gmsh element type
    owner: dict[tuple[int, int], int] = {}  # dimension and entity -> tag
    used: list[tuple[int, IntArray]] = []  # tag and nodes of cells
    facets: dict[int, int] = {}
    notes: list[str] = []
    facet_kinds: set[int] = set()
    for dim, tag in groups:
        for entity in model.getEntitiesForPhysicalGroup(dim, tag):
            kinds, tags, connectivity = model.mesh.getElements(dim, entity)
            what = f"physical group {tag} (dimension {dim}), entity {entity}"
            if len(kinds) == 0:
                raise ValueError(f"{path}: {what} has no elements; mesh it, or take it out of the group")
            if len(kinds) > 1:
                kinds = [model.mesh.getElementProperties(kind)[0] for kind in kinds]
                raise ValueError(f"{path}: {what} has mixed elements, {kinds}; recombine all surfaces or none")
            if dim not in (tdim - 1, tdim):
                continue
            if (dim, entity) in owner:
                raise ValueError(
                    f"{path}: the elements of entity {entity} (dimension {dim}) are in the physical groups "
                    f"{label(owner[(dim, entity)], names[dim])} and {label(tag, names[dim])}; "
                    "a cell or facet has one tag"
                )
            owner[(dim, entity)] = tag
            if dim == tdim:
                counts[kinds[0]] += len(tags[0])
                used.append((tag, connectivity[0]))
            else:
                facets[tag] = facets.get(tag, 0) + len(tags[0])
                facet_kinds.add(kinds[0])
    _check_types(model, path, counts, facet_kinds)
    everything = np.unique(np.concatenate([joined for _, joined in used]))
    loose = len(nodes) - len(everything)
    if loose:
        first = np.setdiff1d(nodes, everything)[:SHOWN].tolist()
        notes.append(f"{loose} nodes belong to no cell (first: {first}) and are left out")
    outside = sum(len(t) for t in model.mesh.getElements(tdim)[1]) - sum(counts.values())
    if outside:
        notes.append(f"{outside} cells are in no physical group and are left out")
    place = dict(zip(nodes.tolist(), range(len(nodes))))
    size = max(np.ptp(x, axis=0).max(), 1e-300)
    for tag in {tag for tag, _ in used}:
        mine = np.unique(np.concatenate([joined for t, joined in used if t == tag]))
        rounded = np.round(x[[place[n] for n in mine.tolist()]] / (1e-10 * size))
        double = len(mine) - len(np.unique(rounded, axis=0))
        if double:
            notes.append(
                f"{double} nodes of {label(tag, names[tdim])} lie on another node of it: a crack, if not wanted"
            )
    flat = np.ptp(x[[place[n] for n in everything.tolist()]][:, 2]) <= 1e-9 * size
    if gdim is None:
        gdim = 2 if tdim == 2 and flat else 3
    if gdim < tdim:
        raise ValueError(f"{path}: gdim = {gdim}, but the cells are three-dimensional; leave gdim out or give 3")
    if gdim == 2 and not flat:
        low, high = x[:, 2].min(), x[:, 2].max()
        raise ValueError(
            f"{path}: gdim = 2, but z goes from {low:.6g} to {high:.6g}; rotate the mesh into a plane z = constant"
        )
    return gdim, names[tdim], names[tdim - 1], facets, notes


def _check_types(model: ModuleType, path: Path, counts: Mapping[int, int], facet_kinds: set[int]) -> None:
    """Raise ValueError unless all cells are of one supported type, with facets of theirs."""
    said = {kind: model.mesh.getElementProperties(kind)[0] for kind in counts}
    listing = ", ".join(f"{n} of {said[kind]!r}" for kind, n in counts.items())
    for kind in counts:
        if kind not in _GMSH:
            what = "triangles, quadrilaterals, tetrahedra and hexahedra of degree 1 or 2 (complete: 9 or 27 nodes)"
            raise ValueError(
                f"{path}: cells {listing}; supported are {what}: set Mesh.ElementOrder, Mesh.SecondOrderIncomplete = 0"
            )
    if len(counts) > 1:
        raise ValueError(f"{path}: mixed cells, {listing}; one kind is needed: recombine all surfaces or none")
    wrong = facet_kinds - {_FACET[kind] for kind in counts}
    if wrong:
        found = [model.mesh.getElementProperties(kind)[0] for kind in wrong]
        raise ValueError(f"{path}: tagged facets {found} are not the facets of cells {listing}; remesh the whole model")


# --- XDMF -----------------------------------------------------------------------------------------------------------


def _read_xdmf(path: Path, comm: MPI.Intracomm, gdim: int | None) -> tuple[MeshInput, dict[int, int], IntArray | None]:
    """Read an XDMF file. Collective.

    Returns:
        As `_read_msh`, without numbers of facets and cells.
    """
    mesh_name, dimension, tag_grids = together(comm, lambda: _check_xdmf_text(path))
    problem = None
    tags: dict[int, MeshTags] = {}
    try:
        with io.XDMFFile(comm, path, "r") as file:
            mesh = file.read_mesh(name=mesh_name)
            tdim = mesh.topology.dim
            for dim in (tdim - 1, tdim):
                mesh.topology.create_connectivity(dim, tdim)
            for name, dim in tag_grids:
                if dim in (tdim - 1, tdim) and dim not in tags:
                    tags[dim] = file.read_meshtags(mesh, name=name)
                elif dim in (tdim - 1, tdim) and comm.rank == 0:
                    warnings.warn(f"{path}: tags {name!r} are not read, {tags[dim].name!r} come first", stacklevel=4)
    except RuntimeError as error:
        problem = f"{path}: DOLFINx cannot read it ({error}); write it again with XDMFFile.write_mesh"
    problems = [p for p in comm.allgather(problem) if p is not None]
    if problems:
        raise ValueError(problems[0])
    if gdim is not None and gdim != mesh.geometry.dim:
        raise ValueError(f"{path}: gdim = {gdim}, but the file's coordinates have {mesh.geometry.dim} components")
    return MeshInput(mesh, tags.get(tdim), tags.get(tdim - 1)), {}, None


def _check_xdmf_text(path: Path) -> tuple[str, int, list[tuple[str, int]]]:
    """Check that the file is an XDMF file with a mesh, and that its data files have its data.

    Returns:
        Name and dimension of the grid with the mesh, and names and dimensions of the grids with tags.
    """
    _exists(path)
    try:
        root = ElementTree.parse(path).getroot()
    except ElementTree.ParseError as error:
        raise ValueError(f"{path}: not an XDMF file, or cut off ({error}); write it again") from error
    grids: list[tuple[str, int, ElementTree.Element | None, ElementTree.Element | None, ElementTree.Element]] = []
    for grid in root.iter("Grid"):
        topology = grid.find("Topology")
        if topology is None:
            continue
        kind = (topology.get("TopologyType") or topology.get("Type") or "").lower().split("_")[0]
        if kind == "mixed":
            raise ValueError(f"{path}: mixed cells in grid {grid.get('Name')!r}; one kind is needed")
        parts = grid.find("Geometry"), grid.find("Attribute"), topology
        grids.append((grid.get("Name", ""), _XDMF_DIMENSION.get(kind, -1), *parts))
    meshes = [g for g in grids if g[2] is not None and g[3] is None] or [g for g in grids if g[2] is not None]
    if not meshes or meshes[0][1] < 2:
        raise ValueError(f"{path}: no grid with cells and coordinates; write it with XDMFFile.write_mesh")
    for item in root.iter("DataItem"):
        text = (item.text or "").strip()
        if item.get("Format") == "HDF" and ":" in text:
            _check_dataset(path, *text.split(":", 1))
    for name, _, _, _, topology in grids:
        _check_numbers(path, name, topology, meshes[0][2])
    return meshes[0][0], meshes[0][1], [(g[0], g[1]) for g in grids if g is not meshes[0]]


def _check_numbers(path: Path, name: str, topology: ElementTree.Element, geometry: ElementTree.Element | None) -> None:
    """Check that the nodes of a grid's cells exist; DOLFINx does not, and the process would end.

    Args:
        path: file.
        name: name of the grid, for messages.
        topology: element of the grid's cells.
        geometry: element of the coordinates.
    """
    assert geometry is not None  # _check_xdmf_text has found it
    places = [(part.findtext("DataItem") or "").strip() for part in (topology, geometry)]
    if not all(":" in place for place in places):
        return
    try:
        import h5py
    except ImportError:
        return
    (file, cells), (other, points) = (place.split(":", 1) for place in places)
    with h5py.File(path.parent / file, "r") as data, h5py.File(path.parent / other, "r") as there:
        count, dataset = len(there[points]), data[cells]
        for first in range(0, len(dataset), _ROWS):
            rows = dataset[first : first + _ROWS]
            wrong = (rows < 0) | (rows >= count)
            if np.any(wrong):
                row = int(np.argmax(np.any(wrong.reshape(len(rows), -1), axis=1)))
                raise ValueError(
                    f"{path}: row {first + row} of grid {name!r} names the node {rows[wrong].flat[0]}, but there are "
                    f"{count} nodes, numbered from 0; the file is damaged, write it again"
                )


def _check_dataset(path: Path, name: str, dataset: str) -> None:
    """Check that a data file exists and has a dataset.

    Args:
        path: XDMF file.
        name: name of the data file.
        dataset: path of the dataset in it.
    """
    try:
        import h5py
    except ImportError:
        return
    data = path.parent / name
    if not data.exists():
        raise FileNotFoundError(f"{path}: its data file {data} is missing; keep the .xdmf and the .h5 file together")
    try:
        with h5py.File(data, "r") as file:
            there = dataset in file
    except OSError as error:
        raise ValueError(f"{path}: its data file {data} is damaged ({error}); write it again") from error
    if not there:
        raise ValueError(f"{path}: its data file {data} has no dataset {dataset}; write both files again")
