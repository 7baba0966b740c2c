# SPDX-License-Identifier: MIT
"""Checkpoints of explicit runs in one HDF5 file, written by all ranks together, readable on any number of ranks.

Nodal values are stored by the numbers that nodes had when the file was written, with a table of each cell's nodes by
the cell's number in the mesh's input: that number is the same on any ranks. A file is written under another name and
renamed when it is complete, so that whatever happens the last checkpoint opens. Every byte is under a checksum
(seal.py), and everything is looked at before anything of it is used.
"""

import contextlib
import os
import shutil
from pathlib import Path

import numpy as np
from mpi4py import MPI

from ..common.cell_numbers import has_input
from . import seal
from .hdf5 import Sketch, reserve, write_at
from .signature import signature, supports

FORMAT = 7
SAME = 1e-9  # of sums over nodes and of their places: another mesh differs by more, another sum of the same by less
CELLS = ("cells/input", "cells/nodes")


def nodes_of(space):
    """Global number of this rank's first node, and of the nodes of its owned cells (num_cells, nodes per cell)."""
    index_map = space.dofmap.index_map
    tdim = space.mesh.topology.dim
    num_cells = space.mesh.topology.index_map(tdim).size_local
    cells = space.dofmap.list[:num_cells]
    return index_map.local_range[0], index_map.local_to_global(cells.ravel()).reshape(cells.shape)


def input_cells(mesh):
    """Numbers of this rank's owned cells in the mesh's input.

    Raises:
        RuntimeError: a submesh, which has no such numbers: its cells could not be told on other ranks.
    """
    if not has_input(mesh.topology):
        raise RuntimeError(
            "a checkpoint tells cells by their numbers in the mesh's input, which a submesh does not have: make the "
            "mesh with create_mesh, or read it from a file"
        )
    return mesh.topology.original_cell_index[: mesh.topology.index_map(mesh.topology.dim).size_local]


def places(space):
    """Reference positions of this rank's owned nodes, (n, gdim) [L]."""
    return space.tabulate_dof_coordinates()[: space.dofmap.index_map.size_local, : space.mesh.geometry.dim].copy()


def _together(comm, work):
    """Do the work, which must not communicate, on all ranks; what the lowest rank raised, as texts, or None."""
    error = None
    try:
        work()
    except Exception as e:  # whatever it is, the other ranks must hear of it
        error = (type(e).__name__, str(e))
    return next((e for e in comm.allgather(error) if e), None)


def lay_out(attributes, tables):
    """An HDF5 file with attributes and room for tables.

    Args:
        attributes: dict of numbers and texts.
        tables: dict name -> (shape, dtype).

    Returns:
        Sketch of what is in the file already; dict name -> offset of the table's rows (None where it has none).
    """
    import h5py

    sketch, offsets = Sketch(), {}
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
            offsets[name] = table.get_offset() if np.prod(shape) else None
    return sketch, offsets


def write(path, problem, arrays, nodal, ranks, attributes):
    """Write a checkpoint. Collective.

    Args:
        arrays: dict name -> owned rows by node.
        nodal: dict name -> (nodes, rows): values at some owned nodes. ranks:
            dict name -> vector of this rank.
        attributes: dict of numbers and texts.

    Raises:
        RuntimeError: on all ranks: the folder cannot be written, no space is left; an earlier file is as it was.
    """
    comm, path = problem.comm, Path(path)
    part = path.with_name(path.name + ".part")
    begin, cells = nodes_of(problem.space)
    mine = dict(zip(CELLS, (input_cells(problem.space.mesh), cells)))
    x = places(problem.space)
    mine |= {f"nodes/{name}": rows for name, rows in {"x": x, **arrays}.items()}
    for name, (nodes, rows) in {"supports": supports(problem), **nodal}.items():
        mine[f"some/{name}/nodes"] = np.asarray(nodes, dtype=np.int64) + begin
        mine[f"some/{name}/values"] = rows
    mine |= {f"ranks/{name}": np.asarray(row)[None] for name, row in ranks.items()}
    mine = {name: np.ascontiguousarray(rows) for name, rows in mine.items()}
    counts = comm.allgather([len(rows) for rows in mine.values()])
    attributes = {"format": FORMAT, "ranks": comm.size, **signature(problem, x), **attributes}
    sketch = offsets = None

    def place():
        nonlocal sketch, offsets
        if comm.rank == 0:
            totals = np.sum(counts, axis=0)
            tables = {name: ((int(n), *rows.shape[1:]), rows.dtype) for (name, rows), n in zip(mine.items(), totals)}
            sketch, offsets = lay_out(attributes, tables)

    def pieces():
        """(offset, rows) of this rank."""
        for k, (name, rows) in enumerate(mine.items()):
            if rows.nbytes:
                before = sum(count[k] for count in counts[: comm.rank])
                yield offsets[name] + before * (rows.nbytes // len(rows)), rows

    def prepare():
        if comm.rank == 0:
            path.parent.mkdir(parents=True, exist_ok=True)
            sealed = seal.table([s for part in sums for s in part], sketch.bytes, sketch.size)
            size = sketch.size + len(sealed)
            free = shutil.disk_usage(path.parent).free
            if free < size:
                raise OSError(f"no space left: {size / 1e6:.3g} MB are needed, {free / 1e6:.3g} MB free")
            with open(part, "wb") as file:
                reserve(file.fileno(), 0, size)
                for offset, data in sketch.writes():
                    write_at(file.fileno(), data, offset)
                write_at(file.fileno(), sealed, sketch.size)

    def save():
        file = os.open(part, os.O_WRONLY)
        try:
            for offset, rows in pieces():
                write_at(file, rows, offset)
            os.fsync(file)
        finally:
            os.close(file)

    def publish():
        if comm.rank == 0:
            os.replace(part, path)

    for work in (place, prepare, save, publish):
        error = _together(comm, work)
        if error:
            if comm.rank == 0:
                with contextlib.suppress(OSError):
                    part.unlink()
            said = ": ".join(error)
            raise RuntimeError(f"the checkpoint {path} could not be written ({said}); what was there is untouched")
        if work is place:
            offsets = comm.bcast(offsets, root=0)
            sums = comm.gather([s for offset, rows in pieces() for s in seal.sections(offset, rows)], root=0)


class Reader:
    """A checkpoint opened for a problem, read and looked at as a whole. Collective.

    Args:
        arrays, nodal, ranks: dicts name -> number of columns: the tables that the problem needs.
        attributes: names of
            the attributes.

    Attributes:
        attributes: dict.
        arrays: dict name -> rows of this rank's owned nodes.

    Raises:
        RuntimeError: it cannot be read, or is damaged. ValueError: it is that of another mesh, material, ...; on all
            ranks.
    """

    def __init__(self, path, problem, arrays, nodal, ranks, attributes):
        self.problem, self.comm, self.path = problem, problem.comm, Path(path)
        self._nodal_columns = {"supports": 3 * problem.space.dofmap.index_map_bs, **nodal}
        self._array_columns, self._rank_columns = {"x": problem.space.mesh.geometry.dim, **arrays}, ranks
        here = signature(problem, places(problem.space))
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

    def _guarded(self, work):
        error = _together(self.comm, work)
        if error:
            said = error[1] if error[0] == seal.Damaged.__name__ else ": ".join(error)
            raise RuntimeError(f"the checkpoint {self.path} cannot be read ({said})")

    def _open(self):
        """The file's structure, where its tables are, its attributes."""
        import h5py

        try:
            self._sealed = seal.Sealed(self.path)
        except seal.Damaged:
            self._format_before_seals()
            raise
        self._mark, self._tables = self._sealed.mark, {}
        with h5py.File(self.path, "r") as file:
            self.attributes = dict(file.attrs)

            def note(name, thing):
                if isinstance(thing, h5py.Dataset):
                    self._tables[name] = (thing.id.get_offset() if thing.size else 0, thing.shape, thing.dtype)

            file.visititems(note)

    def _format_before_seals(self):
        import h5py

        found = None
        with contextlib.suppress(Exception), h5py.File(self.path, "r") as file:
            found = int(file.attrs["format"])
        if found not in (None, FORMAT):
            raise seal.Damaged(f"it has format {found}, this version reads {FORMAT}")

    def _compare(self, here, attributes):
        found = self.attributes
        if found.get("format") != FORMAT:
            raise ValueError(f"{self.path} has format {found.get('format')}, this version reads {FORMAT}")
        for name, value in here.items():
            there = found.get(name)
            if name.startswith("sums"):
                same = np.shape(there) == np.shape(value)
                if not same or not np.all(np.abs(there - value) <= SAME * np.abs(value).max(initial=0.0)):
                    what = "mesh or density" if "mass" in name else "load"
                    raise ValueError(f"{self.path} is of another problem, with another {what}: {name} differ")
            elif there != value:
                hint = "; constant.value may be changed again after restore" if name == "loads" else ""
                raise ValueError(f"{self.path} is of another problem: {name} is {there!r}, here {value!r}{hint}")
        missing = [name for name in attributes if name not in found]
        if missing:
            raise ValueError(f"{self.path} lacks {', '.join(missing)}")

    def _table(self, name, dtype, columns=None, rows=None, low=0, high=None):
        """Rows low to high of a table of known type, verified.

        Args:
            columns: number of them; None: a vector.
            rows: how many the whole table must have; None: any number.
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

    def _read_cells(self):
        V, a = self.problem.space, self.attributes
        num_cells, num_nodes = int(a["num_cells"]), int(a["num_nodes"])
        inputs = self._table(CELLS[0], np.int64, rows=num_cells)
        cells = self._table(CELLS[1], np.int64, V.dofmap.list.shape[1], num_cells)
        if np.any(np.sort(inputs) != np.arange(num_cells)):
            raise seal.Damaged(f"the table {CELLS[0]} does not have every cell once")
        if cells.size and not 0 <= cells.min() <= cells.max() < num_nodes:
            raise seal.Damaged(f"the table {CELLS[1]} has nodes that do not exist")
        mine = input_cells(V.mesh)
        nodes = cells[np.argsort(inputs)[mine]]
        num_local = V.dofmap.index_map.size_local + V.dofmap.index_map.num_ghosts
        self._then = np.full(num_local, -1, dtype=np.int64)  # numbers that nodes had when the file was written
        self._then[V.dofmap.list[: len(mine)].ravel()] = nodes.ravel()

    def _owned(self):
        """Numbers then of this rank's owned nodes; those of nodes without an owned cell here come from other ranks.
        Also whether cells that share a node agree on its number. Collective."""
        from dolfinx import la

        index_map = self.problem.space.dofmap.index_map
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

    def _read_values(self, agreed):
        a, n = self.attributes, len(self._owned_then)
        num_nodes, low = int(a["num_nodes"]), int(self._owned_then.min(initial=0))
        high = int(self._owned_then.max(initial=-1)) + 1
        self.arrays = {}
        for name, columns in self._array_columns.items():
            rows = self._table(f"nodes/{name}", np.float64, columns, num_nodes, low if n else 0, high if n else 0)
            self.arrays[name] = rows[self._owned_then - low]
        x = places(self.problem.space)
        size = np.abs(x).max(initial=0.0)
        if not agreed or not np.all(np.abs(self.arrays.pop("x") - x) <= SAME * size):
            raise seal.Damaged("its nodes lie elsewhere: it is of another mesh, or its cells are numbered anew")
        self.nodal = {}
        for name, columns in self._nodal_columns.items():
            nodes = self._table(f"some/{name}/nodes", np.int64)
            values = self._table(f"some/{name}/values", np.float64, columns, len(nodes))
            if len(np.unique(nodes)) < len(nodes) or (len(nodes) and not 0 <= nodes.min() <= nodes.max() < num_nodes):
                raise seal.Damaged(f"the table some/{name}/nodes has nodes twice or nodes that do not exist")
            self.nodal[name] = (nodes, values)
        ranks = int(a["ranks"])
        self.ranks = {
            name: self._table(f"ranks/{name}", np.float64, columns, ranks)
            for name, columns in self._rank_columns.items()
        }
        wanted = {*CELLS, *(f"nodes/{n}" for n in self._array_columns), *(f"ranks/{n}" for n in self._rank_columns)}
        wanted |= {f"some/{n}/{part}" for n in self._nodal_columns for part in ("nodes", "values")}
        unknown = sorted(set(self._tables) - wanted)
        if unknown:
            raise seal.Damaged(f"it has tables that the problem does not know: {', '.join(unknown)}")
        self._sealed.close()

    def at(self, name, nodes):
        """Values of a nodal group at this rank's owned nodes, and which of them were found."""
        numbers, values = self.nodal[name]
        order = np.argsort(numbers)
        wanted = self._owned_then[nodes]
        place = np.minimum(np.searchsorted(numbers[order], wanted), max(len(numbers) - 1, 0))
        if not len(numbers):
            return np.zeros((len(nodes), *values.shape[1:])), np.zeros(len(nodes), dtype=bool)
        rows = order[place]
        return values[rows], numbers[rows] == wanted

    def all_at(self, name, nodes):
        """Values of a nodal group that has exactly these nodes of all ranks. Collective.

        Raises:
            ValueError: it has others; on all ranks.
        """
        values, found = self.at(name, nodes)
        here, missing = self.comm.allreduce(np.array([len(nodes), np.count_nonzero(~found)]), MPI.SUM)
        if missing or here != len(self.nodal[name][0]):
            raise ValueError(
                f"{self.path} is of another problem: {name} has {len(self.nodal[name][0])} nodes, here {here}, of "
                f"which {missing} are others"
            )
        return values

    def rank(self, name, additive):
        """This rank's vector: its own if there are as many ranks as there were; else rank 0 has the sums.

        Args:
            additive: do the entries add up over ranks? Else they are the same on all.
        """
        table = self.ranks[name]
        if len(table) == self.comm.size:
            return table[self.comm.rank]
        if not additive:
            return table[0]
        return table.sum(axis=0) if self.comm.rank == 0 else np.zeros(table.shape[1:])
