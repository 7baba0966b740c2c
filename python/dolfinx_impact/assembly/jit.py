# SPDX-License-Identifier: MIT
"""From a UFL form to kernels: those built with the package when the form is one of them, else compiled now and cached.

The cache is a folder of shared libraries, safe under concurrent ranks and processes: a library is compiled under a name
of its own and renamed into place. Beside it stands a list of its kernels with the library's checksum: a file that was
cut short or spoilt is compiled again. What is loaded is code: folder and files must belong to the user and be writable
by nobody else.
"""

import functools
import hashlib
import os
import platform
import shlex
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import ufl
from mpi4py import MPI

from .. import _cpp
from ..common import arguments
from ..common.collective import guard
from ..forms.compiler import emit, frontend
from ..common.private_folder import check_file, check_private, make_private

INCLUDE = Path(__file__).parent.parent / "include"
FLAGS = ["-std=c++20", "-O3", "-march=native", "-ffp-contract=fast", "-fno-math-errno", "-fPIC", "-shared", "-w"]


@dataclass
class Compiled:
    """Kernels of a UFL form: one per integral, and the form's own objects in the order the kernels number them.

    Attributes:
        kernels: list of _cpp.kernels.Kernel.
        coefficients: list of UFL coefficients (form.coefficients()).
        constants: list of UFL constants.
        source: "package" or the path of the library in the cache.
    """

    kernels: list
    coefficients: list
    constants: list
    source: str


def cache_folder():
    """Folder of kernels compiled at run time: IMPACT_JIT_CACHE, else dolfinx_impact/kernels in the user's cache
    folder."""
    own = os.environ.get("IMPACT_JIT_CACHE")
    if own:
        return Path(own)
    base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    return Path(base) / "dolfinx_impact" / "kernels"


def compile_form(form, names=None, comm=None):
    """Kernels of a UFL form of rank 0, 1 or 2 over cells and exterior facets.

    Collective over `comm`.

    Args:
        form: UFL form; its functions and constants may be DOLFINx's or plain UFL.
        names: dict from coefficient or constant to a name; DOLFINx functions bring their own.
        comm: MPI communicator whose ranks compile together; None: the mesh's.

    Returns:
        Compiled.

    Raises:
        TypeError: `form` is not a UFL form.
        ValueError: two coefficients of one name, an integral or operator that kernels do not support.
        RuntimeError: no compiler, compilation failed, the cache cannot be written, or others can write in it; the same
            on all ranks.
    """
    with guard(comm or _comm(form), "compile_form") as ranks:
        if not isinstance(form, ufl.Form):
            raise TypeError(f"expected a UFL form, found {type(form).__name__}: {form!r:.80}")
        arguments.measures(form)
        names = _names(form, names)
        frontend.check_names(list(form.coefficients()) + list(form.constants()), names)
        key = emit.signature(frontend.form_signature(form))
        ranks.same(form=key)
    built_in = _cpp.kernels.find_signature(key)
    objects = list(form.coefficients()), list(form.constants())
    if built_in:
        return Compiled(built_in, *objects, "package")

    def integrals():
        return frontend.form_integrals(form, "form", names)

    kernels, path = _from_cache(key, integrals, comm or _comm(form))
    return Compiled(kernels, *objects, str(path))


def compile_expression(expression, points, names=None, comm=None):
    """Kernel that evaluates a UFL expression at reference points of a cell.

    Args:
        expression: UFL expression without test or trial functions.
        points: shape (num_points, tdim), reference coordinates [1].
        names, comm: as for compile_form.

    Returns:
        Compiled with one kernel of rank 0 and shape (points, components).
    """
    domain = ufl.domain.extract_unique_domain(expression) if isinstance(expression, ufl.core.expr.Expr) else None
    comm = comm or _comm(domain)
    with guard(comm, "compile_expression") as ranks:
        if not isinstance(expression, ufl.core.expr.Expr):
            raise TypeError(f"expected a UFL expression, found {type(expression).__name__}: {expression!r:.80}")
        key = emit.signature(frontend.expression_signature(expression, points))
        coefficients = ufl.algorithms.extract_coefficients(expression)
        constants = ufl.algorithms.analysis.extract_constants(expression)
        given = _names_of(list(coefficients) + list(constants), names)
        ranks.same(expression=key)

    def integrals():
        return [frontend.expression_integral(expression, points, "expression", given)]

    kernels, path = _from_cache(key, integrals, comm)
    return Compiled(kernels, coefficients, constants, str(path))


def _names_of(objects, names):
    given = dict(names or {})
    for o in objects:
        own = getattr(o, "name", None)
        if o not in given and isinstance(own, str) and own != "f":  # DOLFINx calls a function without a name "f"
            given[o] = own
    return given


def _names(form, names):
    return _names_of(list(form.coefficients()) + list(form.constants()), names)


def _comm(form_or_domain):
    """Communicator of a form's mesh; COMM_SELF without a mesh, None for what is no form."""
    domain = form_or_domain
    if isinstance(form_or_domain, ufl.Form):
        domains = form_or_domain.ufl_domains()
        domain = domains[0] if domains else None
        if domain is None:
            return MPI.COMM_SELF
    if not hasattr(domain, "ufl_cargo"):
        return None
    mesh = domain.ufl_cargo()
    return mesh.comm if mesh is not None else MPI.COMM_SELF


@functools.lru_cache(maxsize=None)
def _compiler():
    """(command, hash of everything that decides what is made: compiler, flags, processor, generator and headers)."""
    wanted = os.environ.get("CXX")
    command = shlex.split(wanted) if wanted else [c for c in ("c++", "g++", "clang++") if shutil.which(c)][:1]
    if not command or shutil.which(command[0]) is None:
        what = f"CXX={wanted}" if wanted else "none of c++, g++, clang++"
        raise RuntimeError(
            f"no C++ compiler was found ({what}): kernels of your own forms are compiled at run time. Install one "
            "(Debian: g++) or set CXX; forms of the catalogue's table work without"
        )
    version = _run([*command, "--version"]).stdout
    processor = platform.machine()
    try:
        processor += next(line for line in Path("/proc/cpuinfo").read_text().splitlines() if line.startswith("flags"))
    except (OSError, StopIteration):
        pass
    digest = hashlib.sha256("\n".join([*command, version, *FLAGS, processor, emit.VERSION]).encode())
    sources = [*Path(emit.__file__).parent.glob("*.py"), *INCLUDE.glob("dolfinx_impact/kernels/*.h")]
    for source in sorted(sources):
        digest.update(source.read_bytes())
    return command, digest.hexdigest()[:12]


def _run(command):
    """Run a compiler. What it says may be in another encoding than the locale's: names of folders, quotation marks."""
    return subprocess.run(command, capture_output=True, text=True, encoding="utf-8", errors="replace")


_LOADED = {}


def _load(path, names):
    """Kernels of a library in the cache, checked on every rank: folders of several machines may differ."""
    check_private(path.parent)
    check_file(path)
    return _cpp.kernels.load(os.fsencode(path), names)


def _from_cache(key, integrals, comm):
    """Load the library of `key`, compiling it first on rank 0 if need be; errors are raised on all ranks."""
    error, path, names = None, None, None
    if comm.rank == 0:
        try:
            path, names = _library(key, integrals)
        except Exception as e:  # told to all ranks below, whatever it is
            error = e
    error = comm.bcast(error, root=0)
    if error is not None:
        raise error
    path, names = comm.bcast((path, names), root=0)
    try:
        if path not in _LOADED:
            _LOADED[path] = _load(path, names)
    except (OSError, RuntimeError) as e:
        error = f"rank {comm.rank} of {comm.size}: {e}"
    errors = [e for e in comm.allgather(error) if e is not None]
    if errors:
        raise RuntimeError(f"{errors[0]}. The folder {path.parent} must be the same for all ranks (IMPACT_JIT_CACHE)")
    return _LOADED[path], path


def _cached(path, listing):
    """Names of the kernels in a cached library, or None unless it is whole.

    Raises:
        RuntimeError: somebody else may have written it.
    """
    for file in (path, listing):
        check_file(file)
    try:
        checksum, *names = listing.read_text(encoding="utf-8").split()
        return names if hashlib.sha256(path.read_bytes()).hexdigest() == checksum else None
    except (OSError, ValueError):
        return None


def _library(key, integrals):
    compiler, fingerprint = _compiler()
    folder = cache_folder()
    path = folder / f"{key}-{fingerprint}.so"
    listing = path.with_suffix(".txt")
    try:
        make_private(folder)
    except OSError as e:
        raise RuntimeError(_cache_message(folder, e)) from e
    names = _cached(path, listing)
    if names:
        return path, names
    text, names = emit.source(integrals(), f"impact_{key}")
    try:
        work = Path(tempfile.mkdtemp(prefix="build-", dir=folder))
    except OSError as e:
        raise RuntimeError(_cache_message(folder, e)) from e
    try:
        (work / "kernel.cpp").write_text(text, encoding="utf-8")
        files = [str(work / "kernel.cpp"), "-o", str(work / "kernel.so")]
        command = [*compiler, *FLAGS, f"-I{INCLUDE}", *files, "-lmvec", "-lm"]
        done = _run(command)
        if done.returncode != 0:
            raise RuntimeError(
                f"the compiler failed on a generated kernel ({shlex.join(command)}):\n{done.stderr[-3000:]}"
            )
        checksum = hashlib.sha256((work / "kernel.so").read_bytes()).hexdigest()
        (work / "kernel.txt").write_text("\n".join([checksum, *names]) + "\n", encoding="utf-8")
        for file in work.iterdir():  # whatever the umask is
            file.chmod(0o600)
        (work / "kernel.cpp").replace(path.with_suffix(".cpp"))
        (work / "kernel.txt").replace(listing)
        (work / "kernel.so").replace(path)
    except OSError as e:
        raise RuntimeError(_cache_message(folder, e)) from e
    finally:
        shutil.rmtree(work, ignore_errors=True)
    return path, names


def _cache_message(folder, error):
    return (
        f"kernels compiled at run time cannot be written to {folder} ({error.strerror or error}): make room there, or "
        "set IMPACT_JIT_CACHE to a folder that can be written"
    )
