# SPDX-License-Identifier: MIT
"""Folders whose files are loaded as code: nobody but their user may be able to put something into them."""

import os
import stat
from pathlib import Path

OTHERS = stat.S_IWGRP | stat.S_IWOTH  # who may write besides the owner


def _user(number):
    """A user's number and, where it is known, name."""
    try:
        import pwd

        return f"{pwd.getpwuid(number).pw_name} (uid {number})"
    except (ImportError, KeyError):
        return f"uid {number}"


def _refuse(path, why, remedy):
    """Raise RuntimeError. IMPACT_JIT_CACHE is a remedy for everything."""
    raise RuntimeError(
        f"compiled kernels are code, and those in {path} are not loaded: {why}. {remedy}, or set IMPACT_JIT_CACHE to a "
        "folder that only you can write"
    )


def make_private(folder):
    """Make a folder that only this user can read and write, unless it is there; then check it.

    Args:
        folder: Path; parents that are missing are made with the same permissions.

    Raises:
        OSError: it cannot be made. RuntimeError: as check_private.
    """
    missing = []
    for path in (folder, *folder.parents):
        if path.exists():
            break
        missing.append(path)
    for path in reversed(missing):
        try:
            path.mkdir(mode=0o700)
        except FileExistsError:  # another process was faster
            pass
    check_private(folder)


def check_private(folder):
    """Refuse a folder that somebody else may write in or put in another one's place.

    The folder must belong to the effective user: root may read the folders of all users, but must not run what is in
    them. Nobody else may have the permission to write in it. In a parent that everybody may write in without the sticky
    bit, everybody may rename the folder and put another one there.

    Raises:
        RuntimeError: says which folder and what to do. OSError: it cannot be looked at.
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


def check_file(path):
    """Refuse a file that somebody else may have written; one that is missing is none of them.

    Raises:
        RuntimeError: says why and what to do.
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
