# SPDX-License-Identifier: MIT
"""Checkpoints of runs in one HDF5 file, written by all ranks together, readable on any number of ranks.

Nodal values are stored by the global numbers that the nodes have when the file is written. A table has the nodes of
each cell by the cell's number in the mesh's input, which does not depend on the ranks. A file is written under another
name and renamed when it is complete, so that the last checkpoint can always be opened. Checksums cover all bytes
(seal.py), and the whole file is checked before any of it is used.
"""

from __future__ import annotations

import contextlib
import os
import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
from dolfinx.fem import FunctionSpace
from dolfinx.mesh import Mesh
from mpi4py import MPI

from ..assembly.fields import fields_of, is_mixed
from ..common.cell_numbers import has_input
from ..common.collective import agree
from ..common.types import AnyArray, BoolArray, FilePath, FloatArray, IntArray
from . import seal
from .hdf5 import Sketch, reserve, write_at
from .signature import Signature

FORMAT = 11
SAME = 1e-9  # relative tolerance of sums over nodes and of coordinates: round-off is less, another mesh differs by more
CELLS = ("cells/input", "cells/nodes")

Attribute: TypeAlias = str | int | float | AnyArray


@dataclass(frozen=True)
class Subject:
    """A problem as a checkpoint sees it.

    Attributes:
        space: displacement space; nodes are the blocks of its degrees of freedom.
        signature: by what the problem is recognised, of its present arguments, a function that takes the undeformed
            coordinates of this rank's owned nodes, (num_nodes, gdim). Collective.
        supports: owned nodes with prescribed components, (n), and rows of numbers of them, (n, 3 * components): see
            signature.supports.
    """

    space: FunctionSpace
    signature: Callable[[FloatArray], Signature]
    supports: Callable[[], tuple[IntArray, FloatArray]]


def nodes_of(space: FunctionSpace) -> tuple[int, IntArray]:
    """Global numbers of this rank's nodes.

    Args:
        space: displacement space.

    Returns:
        Number of this rank's first node, and numbers of the nodes of its owned cells, (num_cells, nodes per cell).
    """
    index_map = space.dofmap.index_map
    tdim = space.mesh.topology.dim
    num_cells = space.mesh.topology.index_map(tdim).size_local
    cells = space.dofmap.list[:num_cells]
    return index_map.local_range[0], index_map.local_to_global(cells.ravel()).reshape(cells.shape)


def input_cells(mesh: Mesh) -> IntArray:
    """Numbers of this rank's owned cells in the mesh's input.

    Args:
        mesh: mesh.

    Returns:
        Numbers, (num_cells).

    Raises:
        RuntimeError: the mesh is a submesh, which has no input: its cells cannot be identified on other ranks.
    """
    if not has_input(mesh.topology):
        raise RuntimeError(
            "a checkpoint tells cells by their numbers in the mesh's input, which a submesh does not have: make the "
            "mesh with create_mesh, or read it from a file"
        )
    return mesh.topology.original_cell_index[: mesh.topology.index_map(mesh.topology.dim).size_local]


def without_nodes(space: FunctionSpace) -> str:
    """Describe a field whose values are not those at nodes.

    Args:
        space: displacement space.

    Returns:
        The first of them, or an empty text.
    """
    if is_mixed(space):
        return next((str(field) for field in fields_of(space) if not field.is_lagrange), "")
    element = space.ufl_element()
    scalar = element.sub_elements[0] if element.block_size > 1 else element
    return "" if scalar.family_name == "P" else f"element {scalar.family_name}"


def places(space: FunctionSpace) -> FloatArray:
    """Undeformed coordinates of this rank's owned nodes.

    Args:
        space: displacement space.

    Returns:
        Coordinates, (num_nodes, gdim) [L].
    """
    num, gdim = space.dofmap.index_map.size_local, space.mesh.geometry.dim
    if not is_mixed(space):
        return space.tabulate_dof_coordinates()[:num, :gdim].copy()
    x = np.zeros((num + space.dofmap.index_map.num_ghosts, gdim))
    for field in fields_of(space):
        of_field, dofs = space.sub(field.number).collapse()
        x[dofs] = np.repeat(of_field.tabulate_dof_coordinates()[:, :gdim], of_field.dofmap.index_map_bs, axis=0)
    return x[:num].copy()


def _together(comm: MPI.Intracomm, work: Callable[[], object]) -> tuple[str, str] | None:
    """Call a function, which must not communicate, on all ranks. Collective.

    Returns:
        Type and text of the exception on the lowest rank that raised one, or None.
    """
    error = None
    try:
        work()
    except Exception as e:  # whatever it is, the other ranks must get it
        error = (type(e).__name__, str(e))
    return next((e for e in comm.allgather(error) if e), None)


def lay_out(
    attributes: Mapping[str, Attribute], tables: Mapping[str, tuple[tuple[int, ...], np.dtype[Any]]]
) -> tuple[Sketch, dict[str, int]]:
    """Lay out an HDF5 file with attributes and room for tables.

    Args:
        attributes: numbers, texts and arrays by name.
        tables: shapes and types by name.

    Returns:
        Sketch with the structure of the file, and offset of each table's rows (0 for a table without rows) [bytes].
    """
    import h5py

    sketch = Sketch()
    offsets: dict[str, int] = {}
    with h5py.File(sketch, "w") as file:
        for name, value in attributes.items():
            file.attrs[name] = value
        properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        properties.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
        properties.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
        for name, (shape, dtype) in tables.items():
            group, _, last = name.rpartition("/")
            kind, space = h5py.h5t.py_create(dtype), h5py.h5s.create_simple(shape)
            table = h5py.h5d.create(file.require_group(group).id, last.encode(), kind, space, properties)
            offsets[name] = table.get_offset() if np.prod(shape) else 0
    return sketch, offsets


def write(
    path: FilePath,
    subject: Subject,
    arrays: Mapping[str, FloatArray],
    nodal: Mapping[str, tuple[IntArray, FloatArray]],
    cellwise: Mapping[str, FloatArray],
    ranks: Mapping[str, FloatArray],
    attributes: Mapping[str, Attribute],
    facets: Mapping[str, tuple[IntArray, FloatArray]] | None = None,
) -> None:
    """Write a checkpoint. Collective.

    Args:
        path: file to write.
        subject: problem whose state is written.
        arrays: values at all owned nodes by name, rows by node.
        nodal: some owned nodes and the values at them by name, rows by node.
        cellwise: values of all owned cells by name, rows by cell.
        ranks: vector of this rank by name.
        attributes: numbers, texts and arrays by name, the same on all ranks.
        facets: some facets, by numbers that do not depend on the ranks (surface.Facets.id), and the values at them by
            name, rows by facet; None: there are none.

    Raises:
        RuntimeError: the folder cannot be written, or no space is left; on all ranks. An earlier file is as it was.
    """
    comm, target = subject.space.mesh.comm, Path(path)
    part = target.with_name(target.name + ".part")
    begin, cells = nodes_of(subject.space)
    mine: dict[str, AnyArray] = dict(zip(CELLS, (input_cells(subject.space.mesh), cells)))
    x = places(subject.space)
    mine |= {f"nodes/{name}": rows for name, rows in {"x": x, **arrays}.items()}
    for name, (nodes, rows) in {"supports": subject.supports(), **nodal}.items():
        mine[f"some/{name}/nodes"] = np.asarray(nodes, dtype=np.int64) + begin
        mine[f"some/{name}/values"] = rows
    for name, (numbers, rows) in (facets or {}).items():
        mine[f"facets/{name}/numbers"] = np.asarray(numbers, dtype=np.int64)
        mine[f"facets/{name}/values"] = rows
    mine |= {f"cells/values/{name}": rows for name, rows in cellwise.items()}
    mine |= {f"ranks/{name}": np.asarray(row)[None] for name, row in ranks.items()}
    mine = {name: np.ascontiguousarray(rows) for name, rows in mine.items()}
    counts = comm.allgather([len(rows) for rows in mine.values()])
    attributes = {"format": FORMAT, "ranks": comm.size, **subject.signature(x), **attributes}
    sketch, offsets = Sketch(), dict[str, int]()
    sums: list[list[seal.Section]] | None = None  # checksums of all ranks' rows, on rank 0

    def place() -> None:
        nonlocal sketch, offsets
        if comm.rank == 0:
            totals = np.sum(counts, axis=0)
            tables = {name: ((int(n), *rows.shape[1:]), rows.dtype) for (name, rows), n in zip(mine.items(), totals)}
            sketch, offsets = lay_out(attributes, tables)

    def pieces() -> Iterator[tuple[int, AnyArray]]:
        """Offset in the file and rows of each of this rank's tables."""
        for k, (name, rows) in enumerate(mine.items()):
            if rows.nbytes:
                before = sum(count[k] for count in counts[: comm.rank])
                yield offsets[name] + before * (rows.nbytes // len(rows)), rows

    def prepare() -> None:
        if comm.rank == 0:
            assert sums is not None
            target.parent.mkdir(parents=True, exist_ok=True)
            sealed = seal.table([s for part in sums for s in part], sketch.content, sketch.size)
            size = sketch.size + len(sealed)
            free = shutil.disk_usage(target.parent).free
            if free < size:
                raise OSError(f"no space left: {size / 1e6:.3g} MB are needed, {free / 1e6:.3g} MB free")
            with open(part, "wb") as file:
                reserve(file.fileno(), 0, size)
                for offset, data in sketch.writes():
                    write_at(file.fileno(), data, offset)
                write_at(file.fileno(), sealed, sketch.size)

    def save() -> None:
        file = os.open(part, os.O_WRONLY)
        try:
            for offset, rows in pieces():
                write_at(file, rows, offset)
            os.fsync(file)
        finally:
            os.close(file)

    def publish() -> None:
        if comm.rank == 0:
            os.replace(part, target)

    for work in (place, prepare, save, publish):
        error = _together(comm, work)
        if error:
            if comm.rank == 0:
                with contextlib.suppress(OSError):
                    part.unlink()
            said = ": ".join(error)
            raise RuntimeError(f"the checkpoint {target} could not be written ({said}); what was there is untouched")
        if work is place:
            offsets = comm.bcast(offsets, root=0)
            sums = comm.gather([s for offset, rows in pieces() for s in seal.sections(offset, rows)], root=0)


class Reader:
    """Reads and checks a whole checkpoint for a problem. Collective.

    Args:
        path: file to read.
        subject: problem that the state is for.
        arrays: number of columns by name of the values at all nodes.
        nodal: number of columns by name of the values at some nodes.
        cellwise: number of columns by name of the values of all cells.
        ranks: length by name of the ranks' vectors.
        attributes: names of the attributes.
        facets: number of columns by name of the values at some facets; None: there are none.

    Attributes:
        attributes: attributes by name.
        arrays: values at this rank's owned nodes by name, rows by node.
        nodal: nodes, by their numbers in the file, and the values at them by name, of all ranks.
        facets: facets, by their numbers, and the values at them by name, of all ranks.
        cellwise: values of this rank's owned cells by name, rows by cell.
        ranks: vectors of all ranks that wrote the file by name, rows by rank.

    Raises:
        RuntimeError: the file cannot be read, or is damaged; on all ranks.
        ValueError: the file belongs to another mesh, material, ...; on all ranks.
    """

    def __init__(
        self,
        path: FilePath,
        subject: Subject,
        arrays: Mapping[str, int],
        nodal: Mapping[str, int],
        cellwise: Mapping[str, int],
        ranks: Mapping[str, int],
        attributes: Iterable[str],
        facets: Mapping[str, int] | None = None,
    ) -> None:
        self._facet_columns = dict(facets or {})
        self.subject, self.comm, self.path = subject, subject.space.mesh.comm, Path(path)
        self._nodal_columns = {"supports": 3 * subject.space.dofmap.index_map_bs, **nodal}
        self._cell_columns = dict(cellwise)
        self._array_columns, self._rank_columns = {"x": subject.space.mesh.geometry.dim, **arrays}, ranks
        here = subject.signature(places(subject.space))
        self._guarded(self._open)
        error = _together(self.comm, lambda: self._compare(here, attributes))
        if error:
            raise ValueError(error[1])
        marks = self.comm.allgather(self._mark)
        if len(set(marks)) > 1:
            other = next(rank for rank, mark in enumerate(marks) if mark != marks[0])
            raise RuntimeError(f"the checkpoint {self.path} on rank {other} is another file than that on rank 0")
        self._guarded(self._read_cells)
        self._owned_then, agreed = self._owned()
        self._guarded(lambda: self._read_values(agreed))

    def _guarded(self, work: Callable[[], object]) -> None:
        """Call a function on all ranks; raise RuntimeError on all ranks if it fails on any. Collective."""
        error = _together(self.comm, work)
        if error:
            said = error[1] if error[0] == seal.Damaged.__name__ else ": ".join(error)
            raise RuntimeError(f"the checkpoint {self.path} cannot be read ({said})")

    def _open(self) -> None:
        """Read the attributes, and the places and types of the tables."""
        import h5py

        try:
            self._sealed = seal.Sealed(self.path)
        except seal.Damaged:
            self._format_before_seals()
            raise
        self._mark = self._sealed.mark
        self._tables: dict[str, tuple[int, tuple[int, ...], np.dtype[Any]]] = {}  # offset, shape and type
        with h5py.File(self.path, "r") as file:
            self.attributes: dict[str, Any] = dict(file.attrs)  # numbers, texts and arrays

            def note(name: str, thing: h5py.Group | h5py.Dataset) -> None:
                if isinstance(thing, h5py.Dataset):
                    self._tables[name] = (thing.id.get_offset() if thing.size else 0, thing.shape, thing.dtype)

            file.visititems(note)

    def _format_before_seals(self) -> None:
        """Raise Damaged with the format of a file from before files had seals."""
        import h5py

        found = None
        with contextlib.suppress(Exception), h5py.File(self.path, "r") as file:
            found = int(file.attrs["format"])
        if found not in (None, FORMAT):
            raise seal.Damaged(f"it has format {found}, this version reads {FORMAT}")

    def _compare(self, here: Signature, attributes: Iterable[str]) -> None:
        """Raise ValueError unless the signature is that of the problem and all attributes are there."""
        found = self.attributes
        if found.get("format") != FORMAT:
            raise ValueError(f"{self.path} has format {found.get('format')}, this version reads {FORMAT}")
        for name, value in here.items():
            there: Any = found.get(name)
            if name.startswith("sums"):
                same = np.shape(there) == np.shape(value)
                if not same or not np.all(np.abs(there - value) <= SAME * np.abs(value).max(initial=0.0)):
                    what = "mesh or density" if "mass" in name else name.removeprefix("sums of ")
                    raise ValueError(f"{self.path} is of another problem, with another {what}: {name} differ")
            elif there != value:
                hint = "; constant.value may be changed again after restore" if name.startswith("loads[") else ""
                raise ValueError(f"{self.path} is of another problem: {name} is {there!r}, here {value!r}{hint}")
        missing = [name for name in attributes if name not in found]
        if missing:
            raise ValueError(f"{self.path} lacks {', '.join(missing)}")

    def _table(
        self,
        name: str,
        dtype: npt.DTypeLike,
        columns: int | None = None,
        rows: int | None = None,
        low: int = 0,
        high: int | None = None,
    ) -> AnyArray:
        """Read and verify rows of a table.

        Args:
            name: name of the table.
            dtype: type that it must have.
            columns: number of columns that it must have; None: it must be a vector.
            rows: number of rows that it must have; None: any number.
            low: first row to read.
            high: row behind the last one to read; None: read up to the end.

        Returns:
            The rows, (high - low, columns) or (high - low).
        """
        if name not in self._tables:
            raise seal.Damaged(f"the table {name} is missing")
        offset, shape, found = self._tables[name]
        wanted = () if columns is None else (columns,)
        if found != np.dtype(dtype) or shape[1:] != wanted or (rows is not None and shape[:1] != (rows,)):
            raise seal.Damaged(f"the table {name} has shape {shape} and type {found}: it is that of another problem")
        high = shape[0] if high is None else high
        width = np.dtype(dtype).itemsize * int(np.prod(wanted, dtype=int))
        data = self._sealed.read(f"the table {name}", offset + low * width, (high - low) * width)
        values = np.frombuffer(data, dtype=dtype).reshape(high - low, *wanted)
        # Gaps of nodes without a master are infinite, and so is a step that nothing limits.
        bad = np.isnan if name.startswith("some/results") or name == "ranks/common" else lambda v: ~np.isfinite(v)
        if np.issubdtype(values.dtype, np.floating) and np.any(bad(values)):
            raise seal.Damaged(f"the table {name} has values that are no numbers")
        return values

    def _read_cells(self) -> None:
        """Read the numbers that the nodes of this rank's owned cells have in the file."""
        V, a = self.subject.space, self.attributes
        num_cells, num_nodes = int(a["num_cells"]), int(a["num_nodes"])
        inputs = self._table(CELLS[0], np.int64, rows=num_cells)
        cells = self._table(CELLS[1], np.int64, V.dofmap.list.shape[1], num_cells)
        if np.any(np.sort(inputs) != np.arange(num_cells)):
            raise seal.Damaged(f"the table {CELLS[0]} does not have every cell once")
        if cells.size and not 0 <= cells.min() <= cells.max() < num_nodes:
            raise seal.Damaged(f"the table {CELLS[1]} has nodes that do not exist")
        mine = input_cells(V.mesh)
        self._rows = np.argsort(inputs)[mine]  # of this rank's cells in the file
        nodes = cells[self._rows]
        num_local = V.dofmap.index_map.size_local + V.dofmap.index_map.num_ghosts
        self._then = np.full(num_local, -1, dtype=np.int64)  # numbers of this rank's nodes in the file
        self._then[V.dofmap.list[: len(mine)].ravel()] = nodes.ravel()

    def _owned(self) -> tuple[IntArray, bool]:
        """Exchange the numbers of nodes whose cells belong to other ranks. Collective.

        Returns:
            Numbers of this rank's owned nodes in the file, and whether cells that share a node agree on its number.
        """
        from dolfinx import la

        index_map = self.subject.space.dofmap.index_map
        number, count = (la.vector(index_map, 1) for _ in range(2))
        number.array[:] = np.maximum(self._then, 0)
        count.array[:] = self._then >= 0
        for v in (number, count):
            v.scatter_reverse(la.InsertMode.add)
        n = index_map.size_local
        number.array[:n] = np.rint(number.array[:n] / np.maximum(count.array[:n], 1.0))
        number.scatter_forward()
        agreed = np.all((self._then < 0) | (self._then == number.array)) and np.all(count.array[:n] > 0)
        return number.array[:n].astype(np.int64), bool(agreed)

    def _read_values(self, agreed: bool) -> None:
        """Read and check all values; `agreed` is the second result of `_owned`."""
        a, n = self.attributes, len(self._owned_then)
        num_nodes, low = int(a["num_nodes"]), int(self._owned_then.min(initial=0))
        high = int(self._owned_then.max(initial=-1)) + 1
        self.arrays: dict[str, FloatArray] = {}
        for name, columns in self._array_columns.items():
            rows = self._table(f"nodes/{name}", np.float64, columns, num_nodes, low if n else 0, high if n else 0)
            self.arrays[name] = rows[self._owned_then - low]
        x = places(self.subject.space)
        size = np.abs(x).max(initial=0.0)
        if not agreed or not np.all(np.abs(self.arrays.pop("x") - x) <= SAME * size):
            raise seal.Damaged("its nodes lie elsewhere: it is of another mesh, or its cells are numbered anew")
        self.nodal: dict[str, tuple[IntArray, FloatArray]] = {}
        for name, columns in self._nodal_columns.items():
            nodes = self._table(f"some/{name}/nodes", np.int64)
            values = self._table(f"some/{name}/values", np.float64, columns, len(nodes))
            if len(np.unique(nodes)) < len(nodes) or (len(nodes) and not 0 <= nodes.min() <= nodes.max() < num_nodes):
                raise seal.Damaged(f"the table some/{name}/nodes has nodes twice or nodes that do not exist")
            self.nodal[name] = (nodes, values)
        self.facets: dict[str, tuple[IntArray, FloatArray]] = {}
        for name, columns in self._facet_columns.items():
            numbers = self._table(f"facets/{name}/numbers", np.int64)
            if len(np.unique(numbers)) < len(numbers):
                raise seal.Damaged(f"the table facets/{name}/numbers has facets twice")
            self.facets[name] = (numbers, self._table(f"facets/{name}/values", np.float64, columns, len(numbers)))
        self.cellwise: dict[str, FloatArray] = {}
        first, last = int(self._rows.min(initial=int(a["num_cells"]))), int(self._rows.max(initial=-1)) + 1
        for name, columns in self._cell_columns.items():
            span = (first, last) if len(self._rows) else (0, 0)
            rows = self._table(f"cells/values/{name}", np.float64, columns, int(a["num_cells"]), *span)
            self.cellwise[name] = rows[self._rows - span[0]]
        ranks = int(a["ranks"])
        self.ranks: dict[str, FloatArray] = {
            name: self._table(f"ranks/{name}", np.float64, columns, ranks)
            for name, columns in self._rank_columns.items()
        }
        wanted = {*CELLS, *(f"nodes/{n}" for n in self._array_columns), *(f"ranks/{n}" for n in self._rank_columns)}
        wanted |= {f"cells/values/{n}" for n in self._cell_columns}
        wanted |= {f"some/{n}/{part}" for n in self._nodal_columns for part in ("nodes", "values")}
        wanted |= {f"facets/{n}/{part}" for n in self._facet_columns for part in ("numbers", "values")}
        unknown = sorted(set(self._tables) - wanted)
        if unknown:
            raise seal.Damaged(f"it has tables that the problem does not know: {', '.join(unknown)}")
        self._sealed.close()

    def check_supports(self) -> None:
        """Raise ValueError on all ranks unless the supports are those of the checkpoint. Collective."""
        nodes, wanted = self.subject.supports()
        found = self.all_at("supports", nodes)
        other = np.flatnonzero(np.any(found != wanted, axis=1))
        error = None
        if len(other):
            place = places(self.subject.space)[nodes[other[0]]].tolist()
            error = ValueError(f"{self.path} is of another problem: supports differ, the first at {place}")
        agree(self.comm, error, "restore")

    def at(self, name: str, nodes: IntArray) -> tuple[FloatArray, BoolArray]:
        """Values of `nodal` at nodes of this rank.

        Args:
            name: name of the values.
            nodes: owned nodes, (n).

        Returns:
            Values, (n, columns), and whether the file has values at each node, (n).
        """
        numbers, values = self.nodal[name]
        order = np.argsort(numbers)
        wanted = self._owned_then[nodes]
        place = np.minimum(np.searchsorted(numbers[order], wanted), max(len(numbers) - 1, 0))
        if not len(numbers):
            return np.zeros((len(nodes), *values.shape[1:])), np.zeros(len(nodes), dtype=bool)
        rows = order[place]
        return values[rows], numbers[rows] == wanted

    def all_at(self, name: str, nodes: IntArray) -> FloatArray:
        """Values of `nodal` at nodes of this rank, if the file has values at the nodes of all ranks and no others.
        Collective.

        Args:
            name: name of the values.
            nodes: owned nodes, (n).

        Returns:
            Values, (n, columns).

        Raises:
            ValueError: the file has values at other nodes; on all ranks.
        """
        values, found = self.at(name, nodes)
        here, missing = self.comm.allreduce(np.array([len(nodes), np.count_nonzero(~found)]), MPI.SUM)
        if missing or here != len(self.nodal[name][0]):
            raise ValueError(
                f"{self.path} is of another problem: {name} has {len(self.nodal[name][0])} nodes, here {here}, of "
                f"which {missing} are others"
            )
        return values

    def at_facets(self, name: str, numbers: IntArray) -> FloatArray:
        """Values at facets of this rank, if the file has values at the facets of all ranks and no others. Collective.

        Args:
            name: name of the values.
            numbers: numbers of the facets, (n).

        Returns:
            Values, (n, columns).

        Raises:
            ValueError: the file has values at other facets; on all ranks.
        """
        known, values = self.facets[name]
        order = np.argsort(known)
        place = np.minimum(np.searchsorted(known[order], numbers), max(len(known) - 1, 0))
        found = known[order][place] == numbers if len(known) else np.zeros(len(numbers), dtype=bool)
        here, missing = self.comm.allreduce(np.array([len(numbers), np.count_nonzero(~found)]), MPI.SUM)
        if missing or here != len(known):
            raise ValueError(
                f"{self.path} is of another problem: {name} has {len(known)} facets, here {here}, of which {missing} "
                "are others"
            )
        return values[order[place]]

    def rank(self, name: str, additive: bool) -> FloatArray:
        """Vector of this rank.

        Args:
            name: name of the vector.
            additive: whether the entries are summed over ranks; otherwise they are equal on all ranks.

        Returns:
            The vector that this rank wrote, if the number of ranks is that of the file. Otherwise, for additive
            entries, their sums on rank 0 and zeros elsewhere.
        """
        table = self.ranks[name]
        if len(table) == self.comm.size:
            return table[self.comm.rank]
        if not additive:
            return table[0]
        return table.sum(axis=0) if self.comm.rank == 0 else np.zeros(table.shape[1:])
