# SPDX-License-Identifier: MIT
"""Fields for ParaView, frame by frame, on disks that may be full.

ADIOS2, which writes them, does not survive a disk that is full: a rank whose write fails leaves the others waiting, and
ends the process when the writer is given back. So it may write only where room for the frame was found before: a file
of that size is laid out beside it and removed again. Room for what is written at the end is held from the beginning.
"""

import ctypes
import os
import resource
import shutil

from dolfinx import io
from mpi4py import MPI

from ..common.collective import agree, attempt
from .hdf5 import reserve

END = 1 << 17  # bytes that ADIOS2 may need to close a file, and that it may add to every frame


class Frames:
    """A series of frames in a folder FILE.bp.

    Args:
        folder: RunFolder.
        name: of the file, ending in .bp.
        functions: list of fem.Function on one mesh, of one degree.

    Raises:
        RuntimeError: no room, or the folder cannot be written; on all ranks.
    """

    def __init__(self, folder, name, functions):
        self.folder, self.path, self.comm = folder, folder.file(name), folder.comm
        self._spare = folder.file(f".{name}.room")
        V = functions[0].function_space
        local = V.dofmap.index_map.size_local + V.dofmap.index_map.num_ghosts
        cells = V.mesh.topology.index_map(V.mesh.topology.dim)
        cells = (cells.size_local + cells.num_ghosts) * (8 * V.dofmap.list.shape[1] + 16)
        sizes = self.comm.allreduce(24 * local * len(functions) + END // 8, MPI.SUM)
        self._frame, self._mesh = sizes, self.comm.allreduce(cells + 64 * local, MPI.SUM)
        self._before = 0
        folder._write(name, lambda: shutil.rmtree(self.path, ignore_errors=True))
        self._hold(END)
        self._writer, error = attempt(io.VTXWriter, self.comm, self.path, functions, "BP4", io.VTXMeshPolicy.reuse)
        agree(self.comm, error and self._error(error), "fields")

    def _error(self, error):
        said = str(error).strip().splitlines()[0]
        return RuntimeError(f"{self.path} cannot be written ({said}): make room there, or name another folder")

    def _hold(self, size, more=0):
        """Find room for `size` bytes, which is kept, and for `more`, which is given back at once. Collective."""

        def work():
            try:
                with open(self._spare, "ab") as file:
                    reserve(file.fileno(), 0, size + more)
                    file.truncate(size)
            except OSError:
                if not more:
                    self._spare.unlink(missing_ok=True)
                raise

        self.folder._write(self.path.name, work)

    def _sizes(self):
        return [e.stat().st_size for e in os.scandir(self.path)] if self.path.exists() else []

    def _make_room(self):
        """Room for a frame. Collective."""

        def needed():
            sizes = self._sizes()
            total = sum(sizes)
            last, self._before = total - self._before, total
            need = max(3 * self._frame // 2, 2 * last) + END + (0 if total > self._mesh else 2 * self._mesh)
            limit = resource.getrlimit(resource.RLIMIT_FSIZE)[0]
            if limit != resource.RLIM_INFINITY and max(sizes, default=0) + need > limit:
                raise OSError(27, f"File too large: the process may write {limit} bytes into one", str(self.path))
            return need

        self._hold(END, self.folder._write(self.path.name, needed))

    def write(self, now):
        """Add a frame of the present values.

        Args:
            now: time [T].

        Raises:
            RuntimeError: no room; on all ranks. The frames before are complete; with room made the next can be written.
        """
        if self._writer is None:
            raise RuntimeError(f"{self.path} is closed")
        self._make_room()
        error = attempt(self._writer.write, now)[1]
        if error is not None:
            self._abandon()
        agree(self.comm, error and self._error(error), "fields")

    def _abandon(self):
        """A writer that has failed ends the process when it is given back: it never is."""
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(self._writer))
        self._writer = None

    def close(self):
        """No more frames. Collective."""
        if self.comm.rank == 0:
            self._spare.unlink(missing_ok=True)
        writer, error = self._writer, None
        if writer is not None:
            error = attempt(writer.close)[1]
            if error is not None:
                self._abandon()
            self._writer = None
        agree(self.comm, error and self._error(error), "fields")


def write_once(folder, name, functions, now):
    """One frame."""
    frames = Frames(folder, name, functions)
    try:
        frames.write(now)
    finally:
        frames.close()
