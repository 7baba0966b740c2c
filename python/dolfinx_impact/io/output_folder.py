# SPDX-License-Identifier: MIT
"""A folder that the ranks of a run write into: rank 0 does, and an error is raised on all of them."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import TypeVar

from mpi4py import MPI

from ..common.types import FilePath
from .folder_lock import FolderLock
from .gather import together

T = TypeVar("T")
Folder = TypeVar("Folder", bound="OutputFolder")


class FolderGone(RuntimeError):
    """The folder of a run, or a file in it to which the run adds, was removed."""


class OutputFolder:
    """Folder that files of a run are written into. Collective.

    Args:
        path: folder, created if it does not exist; that of rank 0 is taken.
        comm: communicator of the run.
        alone: lock the folder, until `close`, the end of a `with` block or of the process: no other run that does so
            writes there.

    Attributes:
        path: absolute path of the folder.
        comm: as given.

    Raises:
        RuntimeError: the folder cannot be created or written, or another run has locked it; on all ranks.
    """

    def __init__(self, path: FilePath, comm: MPI.Intracomm = MPI.COMM_WORLD, alone: bool = False) -> None:
        self._lock: FolderLock | None = None
        self._alone = alone
        self.comm = comm
        self.path = Path(comm.bcast(str(Path(path).absolute()), root=0))
        together(comm, self._make)

    def __enter__(self: Folder) -> Folder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Unlock the folder, if it is locked."""
        if self._lock is not None:
            self._lock.release()
            self._lock = None

    def _make(self) -> None:
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=self.path) as probe:
                probe.write(b"probe")
            if self._alone:
                self._lock = FolderLock(self.path)
        except OSError as error:
            raise RuntimeError(
                f"results cannot be written to {self.path} ({error.strerror or error}): make room there, or name a "
                "folder that can be written (demos: --output DIR or the variable IMPACT_OUTPUT)"
            ) from error

    def write(self, what: FilePath, work: Callable[[], T]) -> T:
        """Run work() on rank 0 and return its result; a failure to write is the same error on all ranks. Collective.

        Args:
            what: name of the file, for messages.
            work: function without arguments; it must not communicate.

        Returns:
            What the function returned.

        Raises:
            FolderGone: the folder, or the file to which `work` adds, was removed.
            RuntimeError: the file cannot be written.
        """

        def guarded() -> T:
            try:
                return work()
            except OSError as error:
                path, reason = self.path / what, error.strerror or error
                if not self.path.is_dir():
                    path = self.path
                elif not (isinstance(error, FileNotFoundError) and str(error.filename) == str(path)):
                    raise RuntimeError(
                        f"{path} cannot be written ({reason}): make room there, or name another folder; what was "
                        "written before is untouched"
                    ) from error
                raise FolderGone(
                    f"{path} is gone: it was removed while the run wrote into it; record into a folder that stays"
                ) from error

        return together(self.comm, guarded)

    def file(self, name: FilePath) -> Path:
        """Full path of a file in the folder.

        Args:
            name: name of the file.

        Returns:
            Path.
        """
        return self.path / name
