# SPDX-License-Identifier: MIT
"""Meshes of other programs, read by meshio: Abaqus' .inp, Salome's .med, Exodus. Their sets become tags with names."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from ..common.types import AnyArray, FloatArray, IntArray

#: Endings of the files, and what they are called.
KINDS = {
    ".inp": "Abaqus", ".med": "MED (Salome, Code_Aster)", ".e": "Exodus", ".exo": "Exodus", ".ex2": "Exodus",
    ".exii": "Exodus",
}  # fmt: skip
# meshio's type -> gmsh's, dimension, and order of its nodes where gmsh's is another one.
_TYPES: dict[str, tuple[int, int, list[int] | None]] = {
    "line": (1, 1, None), "line3": (8, 1, None), "triangle": (2, 2, None), "triangle6": (9, 2, None),
    "quad": (3, 2, None), "quad9": (10, 2, None), "tetra": (4, 3, None), "hexahedron": (5, 3, None),
    "tetra10": (11, 3, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]),
    "hexahedron27": (12, 3, [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 16, 9, 17, 10, 18, 19, 12, 15, 13, 14, 24, 22, 20, 21, 23,
                             25, 26]),
}  # fmt: skip
# Corners of the facets of a cell, in VTK's and Abaqus' order of nodes; and the nodes between them at degree 2.
_FACETS: dict[str, list[list[int]]] = {
    "triangle": [[0, 1], [1, 2], [2, 0]],
    "triangle6": [[0, 1, 3], [1, 2, 4], [2, 0, 5]],
    "quad": [[0, 1], [1, 2], [2, 3], [3, 0]],
    "quad9": [[0, 1, 4], [1, 2, 5], [2, 3, 6], [3, 0, 7]],
    "tetra": [[0, 1, 2], [0, 1, 3], [1, 2, 3], [0, 2, 3]],
    "tetra10": [[0, 1, 2, 4, 5, 6], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [0, 2, 3, 6, 9, 7]],
    "hexahedron": [[0, 1, 2, 3], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]],
    "hexahedron27": [[0, 1, 2, 3, 8, 9, 10, 11, 24], [4, 5, 6, 7, 12, 13, 14, 15, 25], [0, 1, 5, 4, 8, 17, 12, 16, 22],
                     [1, 2, 6, 5, 9, 18, 13, 17, 21], [2, 3, 7, 6, 10, 19, 14, 18, 23],
                     [3, 0, 4, 7, 11, 16, 15, 19, 20]],
}  # fmt: skip
_FACET_TYPE = {"triangle": "line", "triangle6": "line3", "quad": "line", "quad9": "line3", "tetra": "triangle",
               "tetra10": "triangle6", "hexahedron": "quad", "hexahedron27": "quad9"}  # fmt: skip


@dataclass
class SetsMesh:
    """A mesh with disjoint sets, as gmsh takes it.

    Attributes:
        points: points, (n, 3) [L].
        kind: type of the cells, in meshio's words.
        cells: their nodes, (num_cells, nodes per cell).
        cell_values: tag of each cell; zero: in no set.
        cell_names: tags of cells by names of sets.
        facets: nodes of tagged facets, (num_facets, nodes per facet).
        facet_values: their tags.
        facet_names: tags of facets by names of sets.
        notes: what was left out.
    """

    points: FloatArray
    kind: str
    cells: IntArray
    cell_values: IntArray
    cell_names: dict[str, int] = field(default_factory=dict)
    facets: IntArray = field(default_factory=lambda: np.zeros((0, 1), dtype=np.int64))
    facet_values: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    facet_names: dict[str, int] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    @property
    def dim(self) -> int:
        """Dimension of the cells."""
        return _TYPES[self.kind][1]


def read_sets(path: Path, sets: Sequence[str] | None) -> SetsMesh:
    """Read a file and make disjoint tags of its sets, on one rank.

    Args:
        path: file.
        sets: names of the sets that become tags; None: all, of node sets those that hold facets.

    Returns:
        The mesh.

    Raises:
        RuntimeError: meshio, or what it needs for this kind of file, is not installed.
        ValueError: the file is damaged, its cells are of several kinds or of one that is not supported, sets overlap,
            or a name is unknown.
    """
    mesh = _read(path)
    blocks = [(block.type, np.asarray(block.data, dtype=np.int64)) for block in mesh.cells]
    dim = max((_TYPES[kind][1] for kind, _ in blocks if kind in _TYPES), default=0)
    unknown = sorted({kind for kind, _ in blocks if kind not in _TYPES and kind != "vertex"})
    kinds = sorted({kind for kind, _ in blocks if kind in _TYPES and _TYPES[kind][1] == dim})
    if unknown or dim < 2 or len(kinds) != 1:
        what = "triangles, quadrilaterals, tetrahedra and hexahedra of degree 1 or 2 (complete: 9 or 27 nodes)"
        raise ValueError(
            f"{path}: cells of the kinds {', '.join([*kinds, *unknown]) or 'none'}; one kind is needed, of {what}"
        )
    kind = kinds[0]
    named = _sets_of_blocks(mesh, blocks)
    cell_sets: dict[str, IntArray] = {}
    facet_sets: dict[str, IntArray] = {}
    first = np.cumsum([0, *(len(data) if k == kind else 0 for k, data in blocks)])
    for name, parts in named.items():
        rows_here = [start + rows for (k, _), start, rows in zip(blocks, first, parts) if k == kind]
        rows_there = [data[rows] for (k, data), rows in zip(blocks, parts) if k == _FACET_TYPE[kind]]
        if sum(map(len, rows_here)):
            cell_sets[name] = np.unique(np.concatenate(rows_here))
        if sum(map(len, rows_there)):
            facet_sets[name] = np.concatenate(rows_there)
    cells: IntArray = np.concatenate([data for k, data in blocks if k == kind])
    points = np.zeros((len(mesh.points), 3))
    points[:, : mesh.points.shape[1]] = mesh.points
    out = SetsMesh(points, kind, cells, np.zeros(len(cells), dtype=np.int64))
    found = _Facets(kind, cells)
    surfaces, of_elements = _surfaces(path, cell_sets) if path.suffix.lower() == ".inp" else ({}, set())
    for name, pairs in surfaces.items():
        facet_sets[name] = found.of_cells(pairs)
    cell_sets = {name: rows for name, rows in cell_sets.items() if name not in of_elements}
    alone = _names_of_nodes(mesh, len(points))
    for name, nodes in alone.items():
        if name not in facet_sets and len(faces := found.within(nodes)):
            facet_sets[name] = faces
        elif name not in facet_sets:
            out.notes.append(f"the node set {name!r} holds no facet of the boundary and is left out")
    if sets is not None:
        there = [*cell_sets, *(name for name in facet_sets if name not in cell_sets)]
        missing = [name for name in sets if name not in there]
        if missing:
            raise ValueError(f"{path}: no sets {missing}; there are {', '.join(there) or 'none'}")
        cell_sets, facet_sets = ({n: given[n] for n in sets if n in given} for given in (cell_sets, facet_sets))
    out.cell_names = _tag_cells(path, cell_sets, out.cell_values)
    _tag_facets(path, facet_sets, out)
    return out


def fill(gmsh: ModuleType, mesh: SetsMesh) -> None:
    """Put a mesh into gmsh's current model, with a physical group for each tag.

    Args:
        gmsh: the module.
        mesh: the mesh.
    """
    model, numbers = gmsh.model, np.arange(1, len(mesh.points) + 1)
    kind, dim, order = _TYPES[mesh.kind]
    facet_kind = _TYPES[_FACET_TYPE[mesh.kind]][0]
    parts = [(dim, kind, mesh.cells if order is None else mesh.cells[:, order], mesh.cell_values, mesh.cell_names)]
    parts.append((dim - 1, facet_kind, mesh.facets, mesh.facet_values, mesh.facet_names))
    first, placed = 1, False
    for of, gmsh_kind, rows, values, names in parts:
        known = {tag: name for name, tag in names.items()}
        for tag in np.unique(values):
            mine = rows[values == tag]
            entity = model.addDiscreteEntity(of)
            if not placed:  # all nodes belong to one entity: gmsh asks only that each has one
                model.mesh.addNodes(of, entity, numbers, mesh.points.ravel())
                placed = True
            model.mesh.addElementsByType(entity, gmsh_kind, np.arange(first, first + len(mine)), mine.ravel() + 1)
            first += len(mine)
            # Cells in no set must be in a group, too: gmsh's groups have positive numbers.
            group = int(tag) if tag > 0 else 1 + max([0, *names.values()])
            model.addPhysicalGroup(of, [entity], group, known.get(int(tag), ""))


def _read(path: Path) -> Any:
    """What meshio reads."""
    what = KINDS[path.suffix.lower()]
    try:
        import meshio
    except ImportError as error:
        raise RuntimeError(
            f"{path}: reading {what} files needs the Python module meshio, which is not installed: install meshio "
            "(Debian: python3-meshio), or convert the file to .msh"
        ) from error
    try:
        return meshio.read(path)
    except ImportError as error:
        raise RuntimeError(
            f"{path}: meshio needs the Python module {error.name} for {what} files, which is not installed: install "
            "it, or convert the file to .msh"
        ) from error
    except SystemExit as error:  # meshio ends the process where a file is none of the kind
        raise ValueError(f"{path}: meshio cannot read it as {what}; it is damaged, or of another kind") from error
    except Exception as error:
        raise ValueError(
            f"{path}: meshio cannot read it ({type(error).__name__}: {error}); it is damaged, or has parts that meshio "
            "does not know"
        ) from error


def _sets_of_blocks(mesh: Any, blocks: Sequence[tuple[str, IntArray]]) -> dict[str, list[IntArray]]:
    """Rows of each block by the names of sets of elements."""
    none: IntArray = np.zeros(0, dtype=np.int64)
    out: dict[str, list[IntArray]] = {}
    for name, parts in mesh.cell_sets.items():
        rows = [none if part is None else np.asarray(part, dtype=np.int64) for part in parts]
        out[str(name)] = [*rows, *[none] * (len(blocks) - len(rows))]
    families = getattr(mesh, "cell_tags", None) or {}
    if "cell_tags" in mesh.cell_data:  # of MED: each family has the names of its groups
        for family, names in families.items():
            for name in names:
                parts = out.setdefault(str(name), [none] * len(blocks))
                for k, values in enumerate(mesh.cell_data["cell_tags"]):
                    parts[k] = np.union1d(parts[k], np.flatnonzero(np.asarray(values) == family))
    if not out and len(blocks) > 1 and mesh.info:  # Exodus: blocks without names
        out = {
            f"block {k + 1}": [np.arange(len(data)) if j == k else none for j in range(len(blocks))]
            for k, (_, data) in enumerate(blocks)
        }
    return out


def _names_of_nodes(mesh: Any, count: int) -> dict[str, AnyArray]:
    """Masks of nodes by the names of sets of nodes."""
    out: dict[str, AnyArray] = {}
    for name, nodes in mesh.point_sets.items():
        out[str(name)] = np.zeros(count, dtype=bool)
        out[str(name)][np.asarray(nodes, dtype=np.int64)] = True
    families = getattr(mesh, "point_tags", None) or {}
    if "point_tags" in mesh.point_data:
        for family, names in families.items():
            for name in names:
                mask = out.setdefault(str(name), np.zeros(count, dtype=bool))
                mask |= np.asarray(mesh.point_data["point_tags"]) == family
    return out


class _Facets:
    """Facets of cells of one kind.

    Args:
        kind: type of the cells, in meshio's words.
        cells: their nodes.
    """

    def __init__(self, kind: str, cells: IntArray) -> None:
        self._places = np.array(_FACETS[kind])
        self._all = cells[:, self._places]  # (num_cells, facets per cell, nodes per facet)

    def of_cells(self, pairs: Iterable[tuple[IntArray, int]]) -> IntArray:
        """Facets by the rows of cells and the number of the facet in each."""
        rows = [self._all[cells, number] for cells, number in pairs]
        return np.concatenate(rows)

    def within(self, nodes: AnyArray) -> IntArray:
        """Facets on the boundary all of whose nodes have a mark."""
        flat = self._all.reshape(-1, self._all.shape[2])
        chosen = flat[np.all(nodes[flat], axis=1)]
        _, first, count = np.unique(np.sort(chosen, axis=1), axis=0, return_index=True, return_counts=True)
        found: IntArray = chosen[np.sort(first[count == 1])]
        return found


def _surfaces(path: Path, cell_sets: Mapping[str, IntArray]) -> tuple[dict[str, list[tuple[IntArray, int]]], set[str]]:
    """Surfaces of an Abaqus file, *SURFACE of sets of elements and faces, which meshio leaves out.

    Returns:
        Pairs (rows of cells, number of the facet) by name, and the sets of elements that they are made of alone.
    """
    out: dict[str, list[tuple[IntArray, int]]] = {}
    used: set[str] = set()
    by_name = {name.upper(): name for name in cell_sets}
    name = None
    for line in path.read_text(errors="replace").splitlines():
        text = line.strip()
        if text.startswith("**") or not text:
            continue
        if text.startswith("*"):
            words = [word.strip() for word in text[1:].split(",")]
            options = dict(word.upper().split("=", 1) for word in words[1:] if "=" in word)
            options = {key.strip(): value.strip() for key, value in options.items()}
            given = {w.split("=")[0].strip().upper(): w.split("=", 1)[1].strip() for w in words[1:] if "=" in w}
            is_surface = words[0].upper() == "SURFACE" and options.get("TYPE", "ELEMENT") == "ELEMENT"
            name = given.get("NAME") if is_surface else None
            continue
        if name is None:
            continue
        of, _, face = (part.strip() for part in text.partition(","))
        number = face.upper().removeprefix("S")
        if of.upper() not in by_name or not number.isdigit():
            raise ValueError(
                f"{path}: the surface {name!r} is made of {text!r}: what is read are sets of elements and faces S1, "
                "S2, ...; write it so, or as a set of nodes"
            )
        out.setdefault(name, []).append((np.asarray(cell_sets[by_name[of.upper()]]), int(number) - 1))
        if of.startswith("_"):  # made by Abaqus/CAE for the surface
            used.add(by_name[of.upper()])
    return out, used


def _tag_cells(path: Path, sets: Mapping[str, IntArray], values: IntArray) -> dict[str, int]:
    """Tags 1, 2, ... of sets of cells, which must not overlap."""
    names: dict[str, int] = {}
    for tag, (name, rows) in enumerate(sets.items(), 1):
        before = np.unique(values[rows][values[rows] > 0])
        if len(before):
            other = next(n for n, t in names.items() if t == before[0])
            raise ValueError(_overlap(path, "cells", other, name))
        values[rows], names[name] = tag, tag
    return names


def _tag_facets(path: Path, sets: Mapping[str, IntArray], out: SetsMesh) -> None:
    """Tags 1, 2, ... of sets of facets, which must not overlap."""
    if not sets:
        return
    rows = {
        name: faces[np.unique(np.sort(faces, axis=1), axis=0, return_index=True)[1]] for name, faces in sets.items()
    }
    out.facet_names = {name: tag for tag, name in enumerate(rows, 1)}
    out.facets = np.concatenate(list(rows.values()))
    out.facet_values = np.repeat(np.arange(1, len(rows) + 1), [len(faces) for faces in rows.values()])
    _, inverse, counts = np.unique(np.sort(out.facets, axis=1), axis=0, return_inverse=True, return_counts=True)
    twice = np.flatnonzero(counts > 1)
    if len(twice):
        first, second = out.facet_values[inverse.ravel() == twice[0]][:2]
        names = list(rows)
        raise ValueError(_overlap(path, "facets", names[first - 1], names[second - 1]))


def _overlap(path: Path, what: str, one: str, other: str) -> str:
    return (
        f"{path}: the sets {one!r} and {other!r} have {what} in common, and a cell or facet has one tag: choose sets "
        "that do not overlap, sets=[...]"
    )
