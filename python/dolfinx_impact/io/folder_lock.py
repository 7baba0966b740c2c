# SPDX-License-Identifier: MIT
"""Lock of a folder: one run at a time writes there. The lock names its owner; that of a dead process does not count."""

from __future__ import annotations

import contextlib
import errno
import json
import os
import socket
import time
from pathlib import Path
from typing import Any

with contextlib.suppress(ImportError):  # not on Windows
    import fcntl

NAME = "run.lock"


def start_of(pid: int) -> str | None:
    """When a process of this machine was started, in the kernel's ticks since its start.

    Args:
        pid: number of the process.

    Returns:
        The time as a text; empty where the kernel does not tell; None if there is no such process.
    """
    try:
        with open(f"/proc/{pid}/stat", "rb") as file:
            fields = file.read().rpartition(b")")[2].split()
        return None if fields[0] in (b"Z", b"X") else fields[19].decode()
    except (OSError, IndexError):
        pass
    if os.path.exists("/proc/self/stat"):
        return None
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return None
    except OSError:
        pass
    return ""


class FolderLock:
    """Lock of a folder, held from its making to `release` or the end of the process.

    Args:
        folder: that is locked.

    Attributes:
        path: file of the lock; it has the owner's process, machine and start in JSON.

    Raises:
        RuntimeError: another run holds it; the text names its process.
        OSError: the file cannot be written.
    """

    def __init__(self, folder: Path) -> None:
        self.path, self._file = Path(folder) / NAME, -1
        while True:
            file = os.open(self.path, os.O_RDWR | os.O_CREAT, 0o644)
            try:
                free = self._try_lock(file)
                # Whoever held the file before may have removed it meanwhile.
                with contextlib.suppress(FileNotFoundError):
                    if os.fstat(file).st_ino == os.stat(self.path).st_ino:
                        self._check_owner(file, free)
                        self._write(file)
                        self._file, file = file, -1
                        return
            finally:
                if file >= 0:
                    os.close(file)

    @staticmethod
    def _try_lock(file: int) -> bool | None:
        """Whether the kernel gives the lock; None where the file system has no locks."""
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            return False if error.errno in (errno.EAGAIN, errno.EACCES) else None
        except NameError:
            return None
        return True

    def _check_owner(self, file: int, free: bool | None) -> None:
        owner = _owner(os.pread(file, 4096, 0))
        here = socket.gethostname()
        who = f"process {owner.get('pid', '?')} on {owner.get('host', '?')}, since {owner.get('since', '?')}"
        if free is False:
            raise RuntimeError(
                f"another run writes to {self.path.parent} ({who}): wait for its end, end it, or give another folder"
            )
        if not owner:
            return  # a new lock, or one whose owner was killed while it wrote: the kernel gave it
        if owner.get("host") != here:
            raise RuntimeError(
                f"a run on another machine writes to {self.path.parent}, or was killed ({who}): give another folder, "
                f"or remove {self.path} if that run has ended"
            )
        started = start_of(int(owner["pid"]))
        if started is not None and started == owner.get("start") and not (free and int(owner["pid"]) == os.getpid()):
            raise RuntimeError(
                f"another run writes to {self.path.parent} ({who}): wait for its end, end it, or give another folder"
            )

    @staticmethod
    def _write(file: int) -> None:
        pid = os.getpid()
        owner = {
            "pid": pid, "host": socket.gethostname(), "start": start_of(pid),
            "since": time.strftime("%Y-%m-%d %H:%M:%S"),
        }  # fmt: skip
        os.ftruncate(file, 0)
        os.pwrite(file, (json.dumps(owner) + "\n").encode(), 0)

    def release(self) -> None:
        """Give the folder free."""
        if self._file >= 0:
            with contextlib.suppress(OSError):
                self.path.unlink()
            os.close(self._file)
            self._file = -1

    def __del__(self) -> None:
        if getattr(self, "_file", -1) >= 0:
            self.release()


def _owner(data: bytes) -> dict[str, Any]:
    """What the file of a lock says; empty if it says nothing."""
    try:
        found = json.loads(data)
        return {**found, "pid": int(found["pid"])}
    except (ValueError, KeyError, TypeError):
        return {}
