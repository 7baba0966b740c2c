"""Checkpoints of explicit runs in one HDF5 file, written by all ranks together, readable on any number of ranks.

Nodal values are stored by the numbers that nodes had when the file was written, with a table of each cell's nodes by
the cell's number in the mesh's input: that number is the same on any ranks. A file is written under another name and
renamed when it is complete, so that whatever happens the last checkpoint opens.
"""

import contextlib
import os
import shutil
from pathlib import Path

import numpy as np
from mpi4py import MPI

FORMAT = 1
SAME = 1e-9  # of masses and their moments: another mesh differs by more, another sum of the same by less


class Writer:
    """Datasets of all ranks one after the other, in the order of the ranks.

    Args:
        file: h5py File. comm: of the ranks that write together.
    """

    def __init__(self, file, comm):
        self.file, self.comm = file, comm

    def rows(self, name, values):
        """Write this rank's rows; returns where they begin. Collective."""
        values = np.ascontiguousarray(values)
        counts = self.comm.allgather(len(values))
        begin, shape = sum(counts[: self.comm.rank]), (sum(counts), *values.shape[1:])
        dataset = self.file.create_dataset(name, shape, values.dtype)
        if len(values):
            dataset[begin : begin + len(values)] = values
        return begin


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
    """Do the work on all ranks; RuntimeError on all if any failed."""
    error = ""
    try:
        work()
    except (OSError, RuntimeError, ValueError, KeyError) as e:
        error = f"{type(e).__name__}: {e}"
    errors = [e for e in comm.allgather(error) if e]
    return errors[0] if errors else ""


def write(path, problem, arrays, nodal, ranks, attributes):
    """Write a checkpoint. Collective.

    Args:
        arrays: dict name -> owned rows by node. nodal: dict name -> (nodes, rows): values at some owned nodes. ranks:
            dict name -> vector of this rank. attributes: dict of numbers and texts.

    Raises:
        RuntimeError: on all ranks: the folder cannot be written, no space is left; an earlier file is as it was.
    """
    import h5py

    comm, path = problem.comm, Path(path)
    part = path.with_name(path.name + ".part")
    size = sum(np.asarray(a).nbytes for a in arrays.values()) + sum(r.nbytes for _, r in nodal.values())
    begin, cells = nodes_of(problem.space)
    size = comm.allreduce(size + 2 * cells.nbytes, MPI.SUM)

    def prepare():
        if comm.rank == 0:
            path.parent.mkdir(parents=True, exist_ok=True)
            with open(part, "wb"):
                pass
            free = shutil.disk_usage(path.parent).free
            if free < size:
                part.unlink()
                raise OSError(f"no space left: {size / 1e6:.3g} MB are needed, {free / 1e6:.3g} MB free")

    def save():
        parallel = {"driver": "mpio", "comm": comm} if comm.size > 1 else {}
        if parallel and not h5py.get_config().mpi:
            raise RuntimeError("h5py is built without MPI: install the parallel one (python3-h5py-mpi)")
        with h5py.File(part, "w", **parallel) as file:
            writer = Writer(file, comm)
            file.attrs["format"] = FORMAT
            for name, value in {**signature(problem), **attributes}.items():
                file.attrs[name] = value
            writer.rows("cells/input", input_cells(problem.space.mesh))
            writer.rows("cells/nodes", cells)
            for name, rows in arrays.items():
                writer.rows(f"nodes/{name}", rows)
            for name, (nodes, rows) in nodal.items():
                writer.rows(f"some/{name}/nodes", np.asarray(nodes, dtype=np.int64) + begin)
                writer.rows(f"some/{name}/values", rows)
            for name, row in ranks.items():
                writer.rows(f"ranks/{name}", np.asarray(row)[None])

    def publish():
        if comm.rank == 0:
            with open(part, "rb") as f:
                os.fsync(f.fileno())
            os.replace(part, path)

    for work in (prepare, save, publish):
        error = _together(comm, work)
        if error:
            if comm.rank == 0:
                with contextlib.suppress(OSError):
                    part.unlink()
            raise RuntimeError(f"the checkpoint {path} could not be written ({error}); what was there is untouched")


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
                raise RuntimeError(f"the checkpoint {self.path} cannot be read ({error})")

        guarded(lambda file: setattr(self, "attributes", dict(file.attrs)))
        self._check()
        guarded(self._read_cells)
        self._owned_then = self._owned()
        guarded(self._read_values)

    def _check(self):
        found = self.attributes
        if found.get("format") != FORMAT:
            raise ValueError(f"{self.path} has format {found.get('format')}, this version reads {FORMAT}")
        for name, value in signature(self.problem).items():
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
