# SPDX-License-Identifier: MIT
"""Forms compiled by DOLFINx's own just-in-time compiler, also after a process was killed while it compiled.

FFCx makes X.c in its cache, compiles, and makes X.c.cached; whoever finds X.c alone waits for the other file. A process
that is killed (or stopped with Ctrl-C) in between leaves X.c alone for good, so that all later runs that need this
kernel end with a TimeoutError. Here each process holds a shared lock of the cache while it compiles: where nobody holds
it, X.c alone is a leftover.
"""

from __future__ import annotations

import contextlib
import os
import re
import shlex
import shutil
import sysconfig
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import ufl
from cffi import VerificationError
from dolfinx import fem, jit

from ..common.collective import common
from ..forms.cell_maximum import CellMax
from ..forms.compiler import geometry, words
from .interior_facets import check_neighbours, has_interior_facets

with contextlib.suppress(ImportError):  # not on Windows
    import fcntl

GRACE = 60.0
"""Seconds for which an unfinished file is left alone: a process of DOLFINx without this package may compile it."""

PATIENCE = 600.0
"""Seconds for which to wait while others hold the lock."""

LOCK = "dolfinx_impact.lock"


def advice(error: TimeoutError) -> str:
    """One sentence about the error of FFCx that waits for a kernel in vain.

    Args:
        error: as FFCx raises it.
    """
    path = _unfinished(str(error))
    what = "the unfinished file in the cache of DOLFINx" if path is None else path
    return (
        "a kernel is not ready: another process compiles it, or was killed while it did; start again, and if that does "
        f"not help remove {what}"
    )


def ffcx_form(form: ufl.Form, jit_options: dict[str, Any] | None = None) -> fem.Form:
    """The form as dolfinx.fem.form compiles it; leftovers of killed processes are removed. Collective.

    Args:
        form: UFL form.
        jit_options: as dolfinx.fem.form takes them.

    Returns:
        The compiled form.

    Raises:
        TimeoutError: another process compiles the kernel still, or the cache has no locks; on all ranks.
        RuntimeError: the kernel cannot be compiled; on all ranks.
        ValueError: FFCx does not know an operator of the form, or integrals over interior facets lack cells of other
            ranks; on all ranks.
    """
    _check(form)
    mesh = form.ufl_domain().ufl_cargo()
    comm = mesh.comm
    if has_interior_facets(form):
        check_neighbours(mesh)
    folder = Path(jit.get_options(jit_options)["cache_dir"])
    for attempt in range(3):
        failed: Exception | None = None
        with _compiling(folder):
            try:
                return fem.form(geometry.with_facet_areas(form), jit_options=jit_options)
            except (TimeoutError, RuntimeError, VerificationError) as error:  # on several ranks a RuntimeError of all
                failed = error
        timeout = comm.bcast(str(failed) if "JIT compilation timed out" in str(failed) else None)
        if timeout is None:
            missing = comm.bcast(missing_for_forms())  # rank 0 compiles
            if missing:
                raise RuntimeError(missing) from failed
            raise failed
        path = _unfinished(timeout)
        again = comm.bcast(path is not None and _remove_leftover(path, folder) if comm.rank == 0 else None)
        if attempt == 2 or not again:
            break
    raise TimeoutError(timeout) from failed


def missing_for_forms() -> str:
    """What FFCx lacks to compile forms on this machine.

    Returns:
        A sentence; empty if nothing that can be seen here is missing.
    """
    command = shlex.split(os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc")
    if shutil.which(command[0]) is None:
        return (
            f"no C compiler was found ({command[0]}): DOLFINx compiles this form at run time, a residual of your "
            "own or a load that varies. Install one (Debian: gcc, python3-dev) or set CC; materials of the catalogue's "
            "table under constant loads work without"
        )
    header = Path(sysconfig.get_path("include"), "Python.h")
    if not header.exists():
        return (
            f"Python's headers were not found ({header}): DOLFINx compiles this form at run time, a residual of your "
            "own or a load that varies. Install them (Debian: python3-dev); materials of the catalogue's table under "
            "constant loads work without"
        )
    return ""


def _check(form: ufl.Form) -> None:
    """Refuse, in the user's words, operators that FFCx ends with an empty assertion for."""
    try:
        geometry.check_sizes("the form", form)
    except ValueError as error:
        raise common(error)
    for integral in form.integrals():
        unknown: tuple[type, ...] = (ufl.classes.CellAvg, ufl.classes.FacetAvg, CellMax)
        if not integral.ufl_domain().is_piecewise_linear_simplex_domain():
            unknown += (ufl.classes.CellVolume,)
        found = words.find(integral.integrand(), unknown)
        if found is not None:
            raise common(
                ValueError(
                    f"FFCx, which compiles this form, does not know {words.in_words(found)}: residuals over dx may "
                    "have averages over cells, with the velocity in explicit problems alone; loads may not"
                )
            )


def _unfinished(message: str) -> Path | None:
    """The file that FFCx's message names."""
    file = re.search(r"remove (\S.*\.c)\)", message)
    return None if file is None else Path(file[1])


@contextlib.contextmanager
def _compiling(folder: Path) -> Iterator[None]:
    """Shared lock of the cache; none where the cache cannot be written or the file system has no locks."""
    with _opened(folder) as file:
        with contextlib.suppress(OSError, NameError):
            if file is not None:
                fcntl.flock(file, fcntl.LOCK_SH)
        yield


@contextlib.contextmanager
def _opened(folder: Path) -> Iterator[int | None]:
    file = None
    with contextlib.suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        file = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        yield file
    finally:
        if file is not None:
            os.close(file)


def _remove_leftover(path: Path, folder: Path) -> bool:
    """Wait until the kernel is there or is known to be a leftover, which is removed.

    Args:
        path: the C file that no file "cached" follows.
        folder: the cache.

    Returns:
        Whether to compile again.
    """
    end = time.monotonic() + PATIENCE
    with _opened(folder) as file:
        while time.monotonic() < end:
            if not path.exists() or path.with_suffix(".c.cached").exists():
                return True
            try:
                if file is None:
                    return False
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except (BlockingIOError, PermissionError):  # others compile, perhaps this kernel
                time.sleep(1.0)
                continue
            except (OSError, NameError):  # there are no locks
                return False
            # Held alone: nobody of this package compiles, and nobody begins before the file is gone.
            with contextlib.suppress(FileNotFoundError):
                if time.time() - path.stat().st_mtime > GRACE:
                    path.replace(path.with_suffix(".c.failed"))
                    return True
            fcntl.flock(file, fcntl.LOCK_UN)
            time.sleep(1.0)
    return False
