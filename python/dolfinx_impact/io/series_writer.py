# SPDX-License-Identifier: MIT
"""ADIOS2's writer of a series, whose destruction never ends the process.

The destructor of a VTXWriter that was not closed closes the file. It throws if that fails, for example because the
folder was removed, and a destructor that throws ends the process. On several ranks it also communicates, although each
rank collects garbage when it likes. Therefore a writer is destroyed here only after it was closed. One that nobody has
closed is closed when it is collected or when the process ends, and kept for ever if that fails.
"""

from __future__ import annotations

import atexit
import ctypes
import re
import time
import warnings
import weakref
from collections.abc import Sequence
from pathlib import Path

from dolfinx import fem, io
from mpi4py import MPI

from ..common.collective import attempt, channel

COLOURS = re.compile("\x1b\\[[0-9;]*m")  # of ADIOS2's messages
PATIENCE = 2.0  # s that a rank waits at its end for the others to end, too


def said(error: BaseException) -> str:
    """First line of what an error says, for a sentence.

    Args:
        error: error of ADIOS2 or of the system.

    Returns:
        Line without colours.
    """
    return COLOURS.sub("", str(error)).strip().split("\n")[0]


class SeriesWriter:
    """Writer of a series of frames for ParaView.

    Args:
        comm: communicator of the functions' mesh.
        path: folder of the series, ending in .bp.
        functions: functions on one mesh, of one degree.

    Raises:
        Exception: ADIOS2 cannot write there; on this rank.
    """

    def __init__(self, comm: MPI.Intracomm, path: Path, functions: Sequence[fem.Function]) -> None:
        global _ends
        writer = io.VTXWriter(comm, path, list(functions), "BP4", io.VTXMeshPolicy.reuse)
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(writer))  # released by `_close` alone
        self._writer: io.VTXWriter | None = writer
        self._path, self._collected = path, None
        if comm.size == 1:
            self._collected = weakref.finalize(self, _close_or_warn, writer, path)
        elif comm.size == MPI.COMM_WORLD.size:
            _ends = channel(comm)
            _unclosed[str(path)] = weakref.ref(self)

    def write(self, now: float) -> None:
        """Add a frame. Collective.

        Args:
            now: time of the frame [T].

        Raises:
            Exception: ADIOS2 cannot write, on this rank; nothing more can be written then.
        """
        assert self._writer is not None
        error = attempt(self._writer.write, now)[1]
        if error is not None:
            self.abandon()
            raise error

    def close(self) -> None:
        """Close the series. Collective.

        Raises:
            Exception: ADIOS2 cannot write, on this rank.
        """
        writer = self._writer
        self.abandon()
        if writer is not None:
            _close(writer)

    def abandon(self) -> None:
        """Leave the series as it is: frames that were written can be read. Does not communicate."""
        if self._collected is not None:
            self._collected.detach()
        _unclosed.pop(str(self._path), None)
        self._writer = None


_unclosed: dict[str, weakref.ref[SeriesWriter]] = {}  # on all ranks of several, by path
_ends: MPI.Comm | None = None  # communicator of the ranks' ends


def _close(writer: io.VTXWriter) -> None:
    """Close a writer, after which its destruction does nothing."""
    writer.close()
    ctypes.pythonapi.Py_DecRef(ctypes.py_object(writer))


def _warn(path: Path | str, error: BaseException) -> None:
    warnings.warn(f"{path} cannot be closed ({said(error)}): its end is missing", stacklevel=3)


def _close_or_warn(writer: io.VTXWriter, path: Path) -> None:
    """Close a writer that nobody has closed, on one rank."""
    error = attempt(_close, writer)[1] if path.is_dir() else FileNotFoundError("it was removed")
    if error is not None:
        _warn(path, error)


def _close_at_the_end() -> None:
    """Close what is open on all ranks when all of them end; a rank that ends alone closes nothing."""
    if _ends is None or MPI.Is_finalized():
        return
    request, end = _ends.Ibarrier(), time.monotonic() + PATIENCE
    while not request.Test():
        if time.monotonic() > end:
            return
        time.sleep(1e-3)
    here = {path for path, writer in _unclosed.items() if writer() is not None and Path(path).is_dir()}
    for path in sorted(set.intersection(*_ends.allgather(here))):
        writer = _unclosed[path]()
        error = attempt(writer.close)[1] if writer is not None else None
        if error is not None:
            _warn(path, error)


atexit.register(_close_at_the_end)
