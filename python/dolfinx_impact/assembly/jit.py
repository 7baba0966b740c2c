# SPDX-License-Identifier: MIT
"""From a UFL form to kernels: kernels built with the package are found, others are compiled at run time and cached.

The cache is a folder of shared libraries. It is safe under concurrent ranks and processes: a library is compiled under
a name of its own and renamed into place. A text file beside each library lists its kernels and its checksum; a library
with another checksum is compiled again. Libraries are code: folder and files must belong to the user, and no other user
may have the permission to write them.
"""

import functools
import hashlib
import os
import platform
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import ufl
from mpi4py import MPI

from .. import _cpp
from ..common import arguments
from ..common.collective import guard
from ..common.messages import progress_is_shown
from ..common.private_folder import check_file, check_private, make_private
from ..common.types import FloatArray
from ..forms.compiler import emit, frontend
from ..forms.point_law import PointLaw

# One law for all cells, or one by cell tag.
Laws: TypeAlias = PointLaw | Mapping[int, PointLaw]

INCLUDE = Path(__file__).parent.parent / "include"
# Instructions of this processor, but scheduled for none in particular, as in the package's own kernels: GCC takes up to
# half a minute to schedule a long kernel for the pipelines of a recent processor, and the kernel is not faster for it.
TARGET = ["-march=native", "-mtune=generic"]
FLAGS = ["-std=c++20", "-O3", *TARGET, "-ffp-contract=fast", "-fno-math-errno", "-fPIC", "-shared", "-w"]
# Of GCC, for kernels with internal variables (cpp/cmake/dolfinx_impactKernels.cmake says why).
LAW_FLAGS = [
    "-fschedule-insns",
    "-fsched-pressure",
    "-fno-tree-pre",
    "-fno-gcse",
    "-fno-tree-loop-im",
    "-fira-loop-pressure",
    "-fno-tree-ter",
]

SILENT = 5.0  # compilations that are likely to take longer are announced [s]


@dataclass
class Compiled:
    """Kernels of a UFL form, and the form's coefficients and constants in the order in which the kernels number them.

    Attributes:
        kernels: one kernel per integral.
        coefficients: form.coefficients(); with a point law those of its expressions, too, but the local unknowns.
        constants: form.constants(), likewise.
        source: "package", or the path of the library in the cache.
    """

    kernels: list[_cpp.kernels.Kernel]
    coefficients: list[ufl.Coefficient]
    constants: list[ufl.Constant]
    source: str


def cache_folder() -> Path:
    """Folder of the kernels that are compiled at run time.

    Returns:
        IMPACT_JIT_CACHE, or else dolfinx_impact/kernels in the user's cache folder.
    """
    own = os.environ.get("IMPACT_JIT_CACHE")
    if own:
        return Path(own)
    base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    return Path(base) / "dolfinx_impact" / "kernels"


def compile_form(
    form: ufl.Form,
    names: Mapping[ufl.Coefficient | ufl.Constant, str] | None = None,
    comm: MPI.Comm | None = None,
    law: Laws | None = None,
) -> Compiled:
    """Kernels of a UFL form of rank 0, 1 or 2 over cells and facets. Collective over `comm`.

    Args:
        form: UFL form; its functions and constants may be those of DOLFINx or of UFL.
        names: names of coefficients and constants; DOLFINx functions have names of their own.
        comm: communicator whose ranks compile together; None: that of the mesh.
        law: internal variables and local equations of all cells, or by cell tag (forms/point_law.py); None: none.

    Returns:
        The kernels, one per integral.

    Raises:
        TypeError: `form` is not a UFL form, or `law` not a PointLaw.
        ValueError: two coefficients have one name, the law does not fit the form, or kernels do not support an integral
            or operator of the form.
        RuntimeError: no compiler was found, compilation failed, the cache cannot be written, or other users can write
            into it; on all ranks.
    """
    comm = comm or _comm(form)
    with guard(comm, "compile_form") as ranks:
        if not isinstance(form, ufl.Form):
            raise TypeError(f"expected a UFL form, found {type(form).__name__}: {form!r:.80}")
        arguments.measures(form)
        history = frontend.history_of(law)
        objects = frontend.objects_of(form, law)
        given = _names_of([*objects[0], *objects[1]], names) | history
        frontend.check_names([*objects[0], *objects[1]], given, history)
        key = emit.signature(frontend.form_signature(form, law))
        ranks.same(form=key)
    built_in = _built_in(form, law, key, *objects)
    if built_in:
        return Compiled(built_in, objects[0], objects[1], "package")

    def integrals() -> list[frontend.Integral]:
        return frontend.form_integrals(form, "form", given, law=law)

    assert comm is not None  # forms without a mesh have COMM_SELF
    kernels, path = _from_cache(key, integrals, comm)
    return Compiled(kernels, objects[0], objects[1], str(path))


def compile_expression(
    expression: ufl.core.expr.Expr,
    points: FloatArray,
    names: Mapping[ufl.Coefficient | ufl.Constant, str] | None = None,
    comm: MPI.Comm | None = None,
) -> Compiled:
    """Kernel that evaluates a UFL expression at reference points of a cell. Collective over `comm`.

    Args:
        expression: UFL expression without test or trial functions.
        points: reference coordinates, (num_points, tdim) [1].
        names: names of coefficients and constants; DOLFINx functions have names of their own.
        comm: communicator whose ranks compile together; None: that of the mesh.

    Returns:
        One kernel of rank 0 and shape (num_points, num_components).

    Raises:
        TypeError: `expression` is not a UFL expression.
        ValueError: kernels do not support the expression, or it has no mesh and `comm` is None.
        RuntimeError: as compile_form; on all ranks.
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
        if comm is None:
            raise ValueError("the expression has no mesh: give the communicator whose ranks compile it")

    def integrals() -> list[frontend.Integral]:
        return [frontend.expression_integral(expression, points, "expression", given)]

    kernels, path = _from_cache(key, integrals, comm)
    return Compiled(kernels, coefficients, constants, str(path))


def find_form(form: ufl.Form) -> Compiled | None:
    """Kernels of a UFL form that were built with the package; None: there are none, and the form is not compiled.

    Args:
        form: UFL form; its functions and constants may be those of DOLFINx or of UFL.
    """
    objects = frontend.objects_of(form)
    kernels = _built_in(form, None, emit.signature(frontend.form_signature(form)), *objects)
    return Compiled(kernels, objects[0], objects[1], "package") if kernels else None


def _built_in(
    form: ufl.Form, law: Laws | None, key: str, coefficients: list[ufl.Coefficient], constants: list[ufl.Constant]
) -> list[_cpp.kernels.Kernel]:
    """Kernels built with the package of a form, or of each of its integrals: of materials by cell tags, or loads on
    tagged facets. Empty if one has none, or several integrals belong to the same cells or facets: compiled together
    they are faster.

    Args:
        form: UFL form.
        law: its internal variables and local equations.
        key: its signature.
        coefficients: those that its kernels read, in its order.
        constants: likewise.
    """
    whole = _cpp.kernels.find_signature(key)
    if whole:
        return whole
    places = [(i.integral_type(), i.subdomain_id()) for i in form.integrals()]
    everywhere = {kind for kind, tag in places if tag == "everywhere"}
    tagged = {kind for kind, tag in places if tag != "everywhere"}
    if len(set(places)) < len(places) or everywhere & tagged or any(tag == "otherwise" for _, tag in places):
        return []
    laws = frontend.laws_of(law)
    place = {o: number for listed in (coefficients, constants) for number, o in enumerate(listed)}
    named: dict[str, ufl.Coefficient] = {}
    kernels: list[_cpp.kernels.Kernel] = []
    for integral in form.integrals():
        tag = integral.subdomain_id()
        tags = [-1] if tag == "everywhere" else [int(t) for t in (tag if isinstance(tag, tuple) else (tag,))]
        own = {laws.get(t, laws.get(None)) for t in tags} if integral.integral_type() == "cell" else {None}
        if len(own) > 1:
            return []
        (one,) = own
        part = ufl.Form([integral.reconstruct(subdomain_id="everywhere")])
        read = frontend.objects_of(part, one)
        found = _cpp.kernels.find_signature(emit.signature(frontend.form_signature(part, one)))
        if len(found) != 1:
            return []
        (kernel,) = found
        kept = {o["coefficient"] for o in kernel.outputs}
        for number, c in enumerate(kernel.coefficients):  # kernels have one name for one function
            function = read[0][c["position"]]
            if number not in kept and named.setdefault(c["name"], function) != function:
                return []
        of_functions = [place[read[0][c["position"]]] for c in kernel.coefficients]
        of_constants = [place[read[1][c["position"]]] for c in kernel.constants]
        kernels.append(kernel.placed(tags, of_functions, of_constants))
    return kernels


def _names_of(
    objects: Iterable[ufl.Coefficient | ufl.Constant], names: Mapping[ufl.Coefficient | ufl.Constant, str] | None
) -> dict[ufl.Coefficient | ufl.Constant, str]:
    """Names of coefficients and constants: given ones, and those of DOLFINx functions."""
    given = dict(names or {})
    for o in objects:
        own = getattr(o, "name", None)
        if o not in given and isinstance(own, str) and own != "f":  # DOLFINx calls a function without a name "f"
            given[o] = own
    return given


def _comm(form_or_domain: Any) -> MPI.Comm | None:
    """Communicator of the mesh of a form or UFL domain; COMM_SELF without a mesh, None for other objects."""
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
def _compiler() -> tuple[list[str], str]:
    """Command of the compiler, and hash of all that its result depends on: version, flags, processor, generator and
    headers."""
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
    digest = hashlib.sha256("\n".join([*command, version, *FLAGS, *LAW_FLAGS, processor, emit.VERSION]).encode())
    sources = [*Path(emit.__file__).parent.glob("*.py"), *INCLUDE.glob("dolfinx_impact/kernels/*.h")]
    for source in sorted(sources):
        digest.update(source.read_bytes())
    return command, digest.hexdigest()[:12]


def _flags(compiler: list[str], integrals: list[frontend.Integral]) -> list[str]:
    """Flags for the kernels of some integrals."""
    has_history = any(o.history >= 0 for i in integrals if i.law is not None for o in i.law.outputs)
    if not has_history or "Free Software Foundation" not in _run([*compiler, "--version"]).stdout:
        return FLAGS
    return [*FLAGS, *LAW_FLAGS]


def _run(command: list[str]) -> subprocess.CompletedProcess[str]:
    """Run a compiler. Its output may have another encoding than the locale: names of folders, quotation marks."""
    return subprocess.run(command, capture_output=True, text=True, encoding="utf-8", errors="replace")


_LOADED: dict[Path, list[_cpp.kernels.Kernel]] = {}


def _load(path: Path, names: list[str]) -> list[_cpp.kernels.Kernel]:
    """Load kernels of a library in the cache. Every rank checks the folder: those of several machines may differ."""
    check_private(path.parent)
    check_file(path)
    return _cpp.kernels.load(os.fsencode(path), names)


def _from_cache(
    key: str, integrals: Callable[[], list[frontend.Integral]], comm: MPI.Comm
) -> tuple[list[_cpp.kernels.Kernel], Path]:
    """Load the library of `key`; rank 0 compiles it first if it is not in the cache. Errors are raised on all ranks."""
    error: Exception | None = None
    made: tuple[Path, list[str]] | None = None
    if comm.rank == 0:
        try:
            made = _library(key, integrals)
        except Exception as e:  # raised on all ranks below
            error = e
    error = comm.bcast(error, root=0)
    if error is not None:
        raise error
    path, names = comm.bcast(made, root=0)
    fault = None
    try:
        if path not in _LOADED:
            _LOADED[path] = _load(path, names)
    except (OSError, RuntimeError) as e:
        fault = f"rank {comm.rank} of {comm.size}: {e}"
    faults = [f for f in comm.allgather(fault) if f is not None]
    if faults:
        raise RuntimeError(f"{faults[0]}. The folder {path.parent} must be the same for all ranks (IMPACT_JIT_CACHE)")
    return _LOADED[path], path


def _cached(path: Path, listing: Path) -> list[str] | None:
    """Names of the kernels in a cached library, or None if it is missing or incomplete.

    Raises:
        RuntimeError: another user may have written it.
    """
    for file in (path, listing):
        check_file(file)
    try:
        checksum, *names = listing.read_text(encoding="utf-8").split()
        return names if hashlib.sha256(path.read_bytes()).hexdigest() == checksum else None
    except (OSError, ValueError):
        return None


def _library(key: str, integrals: Callable[[], list[frontend.Integral]]) -> tuple[Path, list[str]]:
    """Path of a library in the cache, compiled if it is missing or incomplete, and the names of its kernels."""
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
    found = integrals()
    text, names = emit.source(found, f"impact_{key}")
    seconds = sum(emit.compile_seconds(i, text) for i in found) / len(found)
    if seconds > SILENT and progress_is_shown():
        print(f"compiling {_in_words(found)}, about {seconds:.0f} seconds", file=sys.stderr, flush=True)
    try:
        work = Path(tempfile.mkdtemp(prefix="build-", dir=folder))
    except OSError as e:
        raise RuntimeError(_cache_message(folder, e)) from e
    try:
        (work / "kernel.cpp").write_text(text, encoding="utf-8")
        files = [str(work / "kernel.cpp"), "-o", str(work / "kernel.so")]
        command = [*compiler, *_flags(compiler, found), f"-I{INCLUDE}", *files, "-lm"]
        done = _run(command)
        if done.returncode != 0:
            raise RuntimeError(
                f"the compiler failed on a generated kernel ({shlex.join(command)}):\n{done.stderr[-3000:]}"
            )
        checksum = hashlib.sha256((work / "kernel.so").read_bytes()).hexdigest()
        (work / "kernel.txt").write_text("\n".join([checksum, *names]) + "\n", encoding="utf-8")
        for file in work.iterdir():  # independent of the umask
            file.chmod(0o600)
        (work / "kernel.cpp").replace(path.with_suffix(".cpp"))
        (work / "kernel.txt").replace(listing)
        (work / "kernel.so").replace(path)
    except OSError as e:
        raise RuntimeError(_cache_message(folder, e)) from e
    finally:
        shutil.rmtree(work, ignore_errors=True)
    return path, names


def _in_words(integrals: list[frontend.Integral]) -> str:
    """What is compiled: kind of form, its functions, its points."""
    first = integrals[0]
    what = "an expression" if first.integral_type == "expression" else f"a form of rank {first.rank}"
    names = list(dict.fromkeys(c.name for i in integrals for c in i.coefficients))
    of = f" in {', '.join(names)}" if names else ""
    points = sum(integral.points_of_rules for integral in integrals)
    return f"{what}{of}: {points} points"


def _cache_message(folder: Path, error: OSError) -> str:
    return (
        f"kernels compiled at run time cannot be written to {folder} ({error.strerror or error}): make room there, or "
        "set IMPACT_JIT_CACHE to a folder that can be written"
    )
