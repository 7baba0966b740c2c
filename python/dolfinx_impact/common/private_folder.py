# SPDX-License-Identifier: MIT
"""Folders whose files are loaded as code; only their owner may have the permission to write into them."""

import os
import stat
from pathlib import Path
from typing import NoReturn

OTHERS = stat.S_IWGRP | stat.S_IWOTH  # permissions of users other than the owner to write


def _user(number: int) -> str:
    """Number and, where it is known, name of a user."""
    try:
        import pwd

        return f"{pwd.getpwuid(number).pw_name} (uid {number})"
    except (ImportError, KeyError):
        return f"uid {number}"


def _refuse(path: Path, why: str, remedy: str) -> NoReturn:
    """Raise RuntimeError with the reason and the remedy; setting IMPACT_JIT_CACHE always helps."""
    raise RuntimeError(
        f"compiled kernels are code, and those in {path} are not loaded: {why}. {remedy}, or set IMPACT_JIT_CACHE to a "
        "folder that only you can write"
    )


def make_private(folder: Path) -> None:
    """Make a folder that only this user can read and write, unless it exists, and check it.

    Args:
        folder: the folder; missing parents are made with the same permissions.

    Raises:
        OSError: the folder cannot be made.
        RuntimeError: as check_private.
    """
    missing: list[Path] = []
    for path in (folder, *folder.parents):
        if path.exists():
            break
        missing.append(path)
    for path in reversed(missing):
        try:
            path.mkdir(mode=0o700)
        except FileExistsError:  # another process has made it meanwhile
            pass
    check_private(folder)


def check_private(folder: Path) -> None:
    """Refuse a folder that other users may write into or replace.

    The folder must belong to the effective user: root may read the folders of all users, but must not run what is in
    them. No other user may have the permission to write into it. In a parent that everybody may write into without the
    sticky bit, everybody may rename the folder and put another one in its place.

    Args:
        folder: the folder.

    Raises:
        RuntimeError: another user may write into the folder or replace it.
        OSError: the folder cannot be read, or is not a folder.
    """
    folder = Path(os.path.realpath(folder))
    if not hasattr(os, "geteuid"):
        return
    status = os.stat(folder)
    if not stat.S_ISDIR(status.st_mode):
        raise NotADirectoryError(20, "Not a directory", str(folder))
    if status.st_uid != os.geteuid():
        why = f"the folder belongs to {_user(status.st_uid)}, this process runs as {_user(os.geteuid())}"
        _refuse(folder, why, "Run as its owner")
    if status.st_mode & OTHERS:
        why = f"others may write in it (mode {stat.S_IMODE(status.st_mode):04o})"
        _refuse(folder, why, "Delete what you did not put there and run chmod -R go-w on it")
    for parent in folder.parents:
        mode = os.stat(parent).st_mode
        if mode & stat.S_IWOTH and not mode & stat.S_ISVTX:
            why = f"everybody may write in {parent} (mode {stat.S_IMODE(mode):04o}) and replace what is in it"
            _refuse(folder, why, f"Run chmod o-w or chmod +t on {parent}")


def check_file(path: Path) -> None:
    """Refuse a file that another user may have written; a missing file is accepted.

    Args:
        path: the file.

    Raises:
        RuntimeError: the file is not a regular file, belongs to another user, or other users may write it.
    """
    try:
        status = os.lstat(path)
    except OSError:
        return
    if not hasattr(os, "geteuid"):
        return
    if not stat.S_ISREG(status.st_mode):
        _refuse(path, "it is no regular file", "Delete it")
    if status.st_uid != os.geteuid():
        why = f"the file belongs to {_user(status.st_uid)}, this process runs as {_user(os.geteuid())}"
        _refuse(path, why, "Delete it")
    if status.st_mode & OTHERS:
        why = f"others may write the file (mode {stat.S_IMODE(status.st_mode):04o})"
        _refuse(path, why, "Delete it, it is compiled again")
