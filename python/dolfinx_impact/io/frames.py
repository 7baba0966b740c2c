# SPDX-License-Identifier: MIT
"""Fields for ParaView in frames, on disks that may be full.

ADIOS2 writes the fields (series_writer.py). On a full disk, a rank whose write fails leaves the other ranks waiting.
Therefore room for a frame is reserved before ADIOS2 writes it, by a file of its size that is then removed. Room for the
end of the file is reserved from the beginning.
"""

from __future__ import annotations

import os
import resource
import shutil
from collections.abc import Sequence

from dolfinx import fem, io
from mpi4py import MPI

from ..common.collective import agree, attempt, common, is_common
from .hdf5 import reserve
from .output_folder import OutputFolder
from .series_writer import SeriesWriter, said

END = 1 << 17  # room for what ADIOS2 may write when it closes a file, and may add to every frame [bytes]


class Frames:
    """Series of frames in a folder NAME.bp.

    Args:
        folder: folder that the series is written into.
        name: name of the series, ending in .bp.
        functions: functions on one mesh, of one degree.

    Attributes:
        path: path of the series.

    Raises:
        RuntimeError: no room, the folder cannot be written, or there is no ADIOS2; on all ranks.
    """

    def __init__(self, folder: OutputFolder, name: str, functions: Sequence[fem.Function]) -> None:
        self.folder, self.path, self.comm = folder, folder.file(name), folder.comm
        if not hasattr(io, "VTXWriter"):  # alike on all ranks
            raise common(RuntimeError(
                f"{name} cannot be written: this DOLFINx was built without ADIOS2. XDMF with HDF5 needs none: "
                'record(..., ending=".xdmf"), or OutputFolder.fields(..., xdmf=True)'
            ))  # fmt: skip
        self._spare = folder.file(f".{name}.room")
        V = functions[0].function_space
        local = V.dofmap.index_map.size_local + V.dofmap.index_map.num_ghosts
        cell_map = V.mesh.topology.index_map(V.mesh.topology.dim)
        cells = (cell_map.size_local + cell_map.num_ghosts) * (8 * V.dofmap.list.shape[1] + 16)
        sizes = self.comm.allreduce(24 * local * len(functions) + END // 8, MPI.SUM)
        self._frame, self._mesh = sizes, self.comm.allreduce(cells + 64 * local, MPI.SUM)
        self._before = 0
        folder.write(name, lambda: shutil.rmtree(self.path, ignore_errors=True))
        self._hold(END)
        self._writer: SeriesWriter | None
        self._writer, error = attempt(SeriesWriter, self.comm, self.path, functions)
        agree(self.comm, error and self._error(error), "fields")

    def _error(self, error: BaseException) -> RuntimeError:
        return RuntimeError(f"{self.path} cannot be written ({said(error)}): make room there, or name another folder")

    def _hold(self, size: int, more: int = 0) -> None:
        """Reserve room on the disk. Collective.

        Args:
            size: room that stays reserved [bytes].
            more: further room that must be there, and is released at once [bytes].
        """

        def work() -> None:
            try:
                with open(self._spare, "ab") as file:
                    reserve(file.fileno(), 0, size + more)
                    file.truncate(size)
            except OSError:
                if not more:
                    self._spare.unlink(missing_ok=True)
                raise

        self.folder.write(self.path.name, work)

    def _sizes(self) -> list[int]:
        """Sizes of the files of the series [bytes]."""
        return [e.stat().st_size for e in os.scandir(self.path)]

    def _make_room(self) -> None:
        """Check that there is room for a frame. Collective."""

        def needed() -> int:
            sizes = self._sizes()
            total = sum(sizes)
            last, self._before = total - self._before, total
            need = max(3 * self._frame // 2, 2 * last) + END + (0 if total > self._mesh else 2 * self._mesh)
            limit = resource.getrlimit(resource.RLIMIT_FSIZE)[0]
            if limit != resource.RLIM_INFINITY and max(sizes, default=0) + need > limit:
                raise OSError(27, f"File too large: the process may write {limit} bytes into one", str(self.path))
            return need

        self._hold(END, self.folder.write(self.path.name, needed))

    def write(self, now: float) -> None:
        """Add a frame with the present values. Collective.

        Args:
            now: time of the frame [T].

        Raises:
            FolderGone: the series was removed; on all ranks.
            RuntimeError: no room; on all ranks. Earlier frames are complete, and later ones can be written when there
                is room.
        """
        if self._writer is None:
            raise RuntimeError(f"{self.path} is closed")
        self._make_room()
        error = attempt(self._writer.write, now)[1]
        if error is not None:
            self._writer = None
        agree(self.comm, error and self._error(error), "fields")

    def close(self) -> None:
        """Close the series. Collective.

        Raises:
            FolderGone: the series was removed; on all ranks.
            RuntimeError: the end of the series cannot be written; on all ranks.
        """
        writer, self._writer = self._writer, None
        if writer is None:
            return

        def look() -> None:
            self._spare.unlink(missing_ok=True)
            self._sizes()

        try:
            self.folder.write(self.path.name, look)
        except RuntimeError:
            writer.abandon()
            raise
        error = attempt(writer.close)[1]
        agree(self.comm, error and self._error(error), "fields")


def write_once(folder: OutputFolder, name: str, functions: Sequence[fem.Function], now: float) -> None:
    """Write a series of one frame. Collective.

    Args:
        folder: folder that the series is written into.
        name: name of the series, ending in .bp.
        functions: functions on one mesh, of one degree.
        now: time of the frame [T].

    Raises:
        RuntimeError: no room, or the folder cannot be written; on all ranks.
    """
    frames = Frames(folder, name, functions)
    try:
        frames.write(now)
    except BaseException as error:
        if is_common(frames.comm, error):
            frames.close()
        raise
    frames.close()
