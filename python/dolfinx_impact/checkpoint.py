"""Checkpoints of explicit runs in one HDF5 file, written by all ranks together, readable on any number of ranks.

Nodal values are stored by the numbers that nodes had when the file was written, with a table of each cell's nodes by
the cell's number in the mesh's input: that number is the same on any ranks. A file is written under another name and
renamed when it is complete, so that whatever happens the last checkpoint opens. HDF5 only lays the file out, in memory:
a write that fails inside HDF5 leaves it, and with it the process, in no state to go on.
"""

import contextlib
import io
import os
import shutil
from pathlib import Path

import numpy as np
from mpi4py import MPI

FORMAT = 2
SAME = 1e-9  # of masses and their moments: another mesh differs by more, another sum of the same by less


def nodes_of(space):
    """Global number of this rank's first node, and of the nodes of its owned cells (num_cells, nodes per cell)."""
    index_map = space.dofmap.index_map
    tdim = space.mesh.topology.dim
    num_cells = space.mesh.topology.index_map(tdim).size_local
    cells = space.dofmap.list[:num_cells]
    return index_map.local_range[0], index_map.local_to_global(cells.ravel()).reshape(cells.shape)


def input_cells(mesh):
    """Numbers of this rank's owned cells in the mesh's input."""
    return mesh.topology.original_cell_index[: mesh.topology.index_map(mesh.topology.dim).size_local]


def signature(problem):
    """What tells one problem from another, the same on any number of ranks: dict of numbers and texts. Collective."""
    V, mesh = problem.space, problem.space.mesh
    n, bs = V.dofmap.index_map.size_local, V.dofmap.index_map_bs
    mass = problem.mass.array[: n * bs].reshape(n, bs)[:, 0]
    x = V.tabulate_dof_coordinates()[:n]
    moments = np.concatenate([[mass.sum()], mass @ x, mass @ x**2])
    contacts = [f"{type(c).__name__} {c.pair.name} friction {c.pair.friction:g} {c.options}" for c in problem.contact]
    return {
        "cell": mesh.topology.cell_name(),
        "degree": int(V.element.basix_element.degree),
        "num_cells": int(mesh.topology.index_map(mesh.topology.dim).size_global),
        "num_nodes": int(V.dofmap.index_map.size_global),
        "material": problem.describe(),
        "scheme": problem.scheme,
        "contact": "; ".join(contacts),
        "moments": problem.comm.allreduce(moments, MPI.SUM),
    }


def _together(comm, work):
    """Do the work, which must not communicate, on all ranks; what the lowest rank raised, as texts, or None."""
    error = None
    try:
        work()
    except Exception as e:  # whatever it is, the other ranks must hear of it
        error = (type(e).__name__, str(e))
    return next((e for e in comm.allgather(error) if e), None)


class _Sketch(io.RawIOBase):
    """A file in memory that has only what was written into it, page by page; the rest is zero."""

    page = 4096

    def __init__(self):
        super().__init__()
        self.pages, self.size, self._at = {}, 0, 0

    def seek(self, offset, whence=os.SEEK_SET):
        self._at = offset + {os.SEEK_SET: 0, os.SEEK_CUR: self._at, os.SEEK_END: self.size}[whence]
        return self._at

    def tell(self):
        return self._at

    def _parts(self, count):
        """(place in the buffer, page, place in the page, length) of a range from here on; moves behind it."""
        done = 0
        while done < count:
            number, first = divmod(self._at, self.page)
            length = min(count - done, self.page - first)
            yield done, number, first, length
            done, self._at = done + length, self._at + length

    def write(self, data):
        data = memoryview(data).cast("B")
        for place, number, first, length in self._parts(len(data)):
            page = self.pages.setdefault(number, bytearray(self.page))
            page[first : first + length] = data[place : place + length]
        self.size = max(self.size, self._at)
        return len(data)

    def readinto(self, data):
        data = memoryview(data).cast("B")
        for place, number, first, length in self._parts(len(data)):
            page = self.pages.get(number, bytes(self.page))
            data[place : place + length] = page[first : first + length]
        return len(data)

    def truncate(self, size):
        self.size = size


def lay_out(attributes, tables):
    """An HDF5 file with attributes and room for tables.

    Args:
        attributes: dict of numbers and texts. tables: dict name -> (shape, dtype).

    Returns:
        Dict offset -> bytes that are in the file already; its size; dict name -> offset of the table's rows (None where
        it has none).
    """
    import h5py

    sketch, offsets = _Sketch(), {}
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
    pages = {number * sketch.page: bytes(page) for number, page in sketch.pages.items()}
    return pages, sketch.size, offsets


def _write_at(file, data, offset):
    """All of the data; a file system that is full takes a part first and says so at the next call."""
    data = memoryview(np.ascontiguousarray(data)).cast("B")
    while len(data):
        count = os.pwrite(file, data, offset)
        data, offset = data[count:], offset + count


def write(path, problem, arrays, nodal, ranks, attributes):
    """Write a checkpoint. Collective.

    Args:
        arrays: dict name -> owned rows by node. nodal: dict name -> (nodes, rows): values at some owned nodes. ranks:
            dict name -> vector of this rank. attributes: dict of numbers and texts.

    Raises:
        RuntimeError: on all ranks: the folder cannot be written, no space is left; an earlier file is as it was.
    """
    comm, path = problem.comm, Path(path)
    part = path.with_name(path.name + ".part")
    begin, cells = nodes_of(problem.space)
    mine = {"cells/input": input_cells(problem.space.mesh), "cells/nodes": cells}
    mine |= {f"nodes/{name}": rows for name, rows in arrays.items()}
    for name, (nodes, rows) in nodal.items():
        mine[f"some/{name}/nodes"] = np.asarray(nodes, dtype=np.int64) + begin
        mine[f"some/{name}/values"] = rows
    mine |= {f"ranks/{name}": np.asarray(row)[None] for name, row in ranks.items()}
    counts = comm.allgather([len(rows) for rows in mine.values()])
    attributes = {"format": FORMAT, **signature(problem), **attributes}
    laid_out = None

    def prepare():
        nonlocal laid_out
        if comm.rank == 0:
            path.parent.mkdir(parents=True, exist_ok=True)
            totals = np.sum(counts, axis=0)
            tables = {name: ((int(n), *rows.shape[1:]), rows.dtype) for (name, rows), n in zip(mine.items(), totals)}
            pages, size, offsets = lay_out(attributes, tables)
            free = shutil.disk_usage(path.parent).free
            if free < size:
                raise OSError(f"no space left: {size / 1e6:.3g} MB are needed, {free / 1e6:.3g} MB free")
            laid_out = offsets
            with open(part, "wb") as file:
                os.posix_fallocate(file.fileno(), 0, size)
                for offset, data in pages.items():
                    _write_at(file.fileno(), np.frombuffer(data, dtype=np.uint8)[: size - offset], offset)

    def save():
        file = os.open(part, os.O_WRONLY)
        try:
            for k, (name, rows) in enumerate(mine.items()):
                if len(rows):
                    before = sum(count[k] for count in counts[: comm.rank])
                    _write_at(file, rows, offsets[name] + before * (rows.nbytes // len(rows)))
            os.fsync(file)
        finally:
            os.close(file)

    def publish():
        if comm.rank == 0:
            os.replace(part, path)

    offsets = None
    for work in (prepare, save, publish):
        error = _together(comm, work)
        if error:
            if comm.rank == 0:
                with contextlib.suppress(OSError):
                    part.unlink()
            said = ": ".join(error)
            raise RuntimeError(f"the checkpoint {path} could not be written ({said}); what was there is untouched")
        if work is prepare:
            offsets = comm.bcast(laid_out, root=0)


class Reader:
    """A checkpoint opened for a problem.

    Raises:
        RuntimeError: it cannot be read. ValueError: it is that of another mesh, material, ...; on all ranks.
    """

    def __init__(self, path, problem):
        import h5py

        self.problem, self.comm, self.path = problem, problem.comm, Path(path)

        def guarded(work):
            def read():
                with h5py.File(self.path, "r") as file:
                    work(file)

            error = _together(self.comm, read)
            if error:
                raise RuntimeError(f"the checkpoint {self.path} cannot be read ({': '.join(error)})")

        guarded(lambda file: setattr(self, "attributes", dict(file.attrs)))
        here = signature(problem)
        error = _together(self.comm, lambda: self._check(here))
        if error:
            raise ValueError(error[1])
        guarded(self._read_cells)
        self._owned_then = self._owned()
        guarded(self._read_values)

    def _check(self, here):
        found = self.attributes
        if found.get("format") != FORMAT:
            raise ValueError(f"{self.path} has format {found.get('format')}, this version reads {FORMAT}")
        for name, value in here.items():
            there = found.get(name)
            if name == "moments":
                same = np.shape(there) == np.shape(value)
                if not same or np.any(np.abs(there - value) > SAME * np.abs(value).max()):
                    raise ValueError(f"{self.path} is of another mesh or density: masses or places of nodes differ")
            elif there != value:
                raise ValueError(f"{self.path} is of another problem: {name} is {there!r}, here {value!r}")

    def _read_cells(self, file):
        V = self.problem.space
        inputs = file["cells/input"][:]
        order = np.argsort(inputs)
        mine = input_cells(V.mesh)
        nodes = _rows(file["cells/nodes"], order[np.searchsorted(inputs[order], mine)])
        num_local = V.dofmap.index_map.size_local + V.dofmap.index_map.num_ghosts
        self._then = np.full(num_local, -1, dtype=np.int64)  # numbers that nodes had when the file was written
        self._then[V.dofmap.list[: len(mine)].ravel()] = nodes.ravel()

    def _read_values(self, file):
        self.arrays = {name: _rows(d, self._owned_then) for name, d in file["nodes"].items()}
        some = file.get("some", {})
        self.nodal = {name: (group["nodes"][:], group["values"][:]) for name, group in some.items()}
        self.ranks = {name: d[:] for name, d in file["ranks"].items()}

    def _owned(self):
        """Numbers then of this rank's owned nodes; those of nodes without an owned cell here come from other ranks.
        Collective."""
        from dolfinx import la

        index_map = self.problem.space.dofmap.index_map
        number, count = (la.vector(index_map, 1) for _ in range(2))
        number.array[:] = np.maximum(self._then, 0)
        count.array[:] = self._then >= 0
        for v in (number, count):
            v.scatter_reverse(la.InsertMode.add)
        n = index_map.size_local
        return np.rint(number.array[:n] / count.array[:n]).astype(np.int64)

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

    def rank(self, name, additive):
        """This rank's vector: its own if there are as many ranks as there were; else rank 0 has the sums.

        Args:
            additive: mask of the entries that add up over ranks; the others are the same on all.
        """
        table = self.ranks[name]
        if len(table) == self.comm.size:
            return table[self.comm.rank]
        out = table.sum(axis=0) if self.comm.rank == 0 else np.zeros(table.shape[1:])
        return np.where(additive, out, table[0])


def _rows(dataset, rows):
    """Rows of a dataset, in any order, read in one piece where they are most of it."""
    if not len(rows):
        return np.zeros((0, *dataset.shape[1:]), dtype=dataset.dtype)
    low, high = int(rows.min()), int(rows.max()) + 1
    return dataset[low:high][rows - low]
