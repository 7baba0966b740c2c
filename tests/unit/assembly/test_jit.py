# SPDX-License-Identifier: MIT
"""The run-time route: what is compiled, what is found again, and what happens when the cache or the compiler is not
fit."""

import functools
import os
import re
import shutil
import stat
import subprocess
import sys

import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.assembly import jit


@pytest.fixture
def cache(tmp_path, monkeypatch):
    folder = tmp_path / "cache"
    monkeypatch.setenv("IMPACT_JIT_CACHE", str(folder))
    monkeypatch.setattr(jit, "_LOADED", {})
    return folder


def small_form(factor=1.0):
    """A form that is not in the table and quick to compile; every factor makes another one."""
    domain = mesh.create_unit_square(MPI.COMM_SELF, 1, 1)
    v = ufl.TestFunction(fem.functionspace(domain, ("Lagrange", 1)))
    return factor * v * ufl.dx


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """Path of the library of small_form() in a cache of its own: compiled once, not to be changed."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("IMPACT_JIT_CACHE", str(tmp_path_factory.mktemp("compiled") / "cache"))
        patch.setattr(jit, "_LOADED", {})
        return jit.Path(jit.compile_form(small_form()).source)


@pytest.fixture
def library(compiled, cache):
    """Path of the library of small_form() in the test's cache, a copy."""
    shutil.copytree(compiled.parent, cache)  # with the modes of folder and files
    return cache / compiled.name


# Compiles small_form, applies it, and prints what came of it.
SCRIPT = """
import sys, ufl
from dolfinx import fem, mesh
from mpi4py import MPI
import dolfinx_impact as di
domain = mesh.create_unit_square(MPI.COMM_WORLD, 4, 4)
v = ufl.TestFunction(fem.functionspace(domain, ("Lagrange", 1)))
form = float(sys.argv[1]) * v * ufl.dx
try:
    b = di.InternalForce(form).apply()
except RuntimeError as e:
    everywhere = MPI.COMM_WORLD.gather(str(e))  # one rank prints: lines of several may run into each other
    if MPI.COMM_WORLD.rank == 0:
        print(*(f"refused: {text}" for text in everywhere), sep="\\n")
    sys.exit(0)
total = MPI.COMM_WORLD.allreduce(float(b.array[: b.index_map.size_local].sum()))
assert abs(total - float(sys.argv[1])) < 1e-12, total  # the area of the square, 1
print("computed")
"""


def run(cache, factor, expect, environment=None, code=SCRIPT):
    """The script in a process of its own, which must end well; returns what it printed."""
    surroundings = {**os.environ, "IMPACT_JIT_CACHE": str(cache), **(environment or {})}
    done = subprocess.run(
        [sys.executable, "-c", code, factor], env=surroundings, capture_output=True, text=True, timeout=100
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert done.stdout.startswith(expect), done.stdout
    return done.stdout


@pytest.fixture
def run_here(monkeypatch, capsys):
    """As run, in the process of the tests, with nothing loaded and no compiler known: a start takes 2 s.

    A library must not have been loaded from the same path in this process before.
    """

    def run(cache, factor, expect, environment=None):
        with monkeypatch.context() as patch:
            for name, value in {"IMPACT_JIT_CACHE": str(cache), **(environment or {})}.items():
                patch.setenv(name, value)
            patch.setattr(jit, "_LOADED", {})
            patch.setattr(jit, "_compiler", functools.lru_cache(jit._compiler.__wrapped__))
            patch.setattr(sys, "argv", ["script", factor])
            capsys.readouterr()
            try:
                exec(compile(SCRIPT, "script", "exec"), {"__name__": "__main__"})
            except SystemExit as ended:
                assert not ended.code
            output = capsys.readouterr().out
        assert output.startswith(expect), output
        return output

    return run


def test_compiled_once_and_found_again(cache):
    first = jit.compile_form(small_form())
    stamp = {p.name: p.stat().st_mtime_ns for p in cache.iterdir()}
    assert sorted(p.suffix for p in cache.iterdir()) == [".cpp", ".so", ".txt"]  # and no folder of a build is left
    again = jit.compile_form(small_form())
    assert again.source == first.source and stamp == {p.name: p.stat().st_mtime_ns for p in cache.iterdir()}


def test_another_form_is_another_library(cache):
    assert jit.compile_form(small_form(1.0)).source != jit.compile_form(small_form(2.0)).source


def test_forms_of_the_table_need_no_cache(cache):
    domain = mesh.create_unit_cube(MPI.COMM_SELF, 1, 1, 1, mesh.CellType.hexahedron)
    u = fem.Function(fem.functionspace(domain, ("Lagrange", 1, (3,))), name="u")
    material = di.LinearElastic(1.0, 0.3)
    compiled = jit.compile_form(di.operators.internal_force_form(u, ufl.TestFunction(u.function_space), material))
    assert compiled.source == "package" and not cache.exists()


@pytest.mark.long_rows(where=lambda damage: damage not in ("truncated", "list spoilt"))
@pytest.mark.parametrize("damage", ["truncated", "overwritten", "empty", "missing", "no list", "list spoilt"])
def test_spoilt_library_is_compiled_again(cache, library, damage):
    """In a process of its own: one that loaded half a library would be killed."""
    path, whole = library, library.read_bytes()
    assert jit._cached(path, path.with_suffix(".txt"))
    if damage in ("truncated", "overwritten", "empty"):
        copy = path.with_suffix(".copy")
        spoilt = whole[: len(whole) // 2] if damage == "truncated" else b"x" * len(whole) if damage != "empty" else b""
        copy.write_bytes(spoilt)
        copy.replace(path)
    elif damage == "missing":
        path.unlink()
    else:
        listing = path.with_suffix(".txt")
        listing.unlink() if damage == "no list" else listing.write_text("nonsense\n")
    run(cache, "1.0", expect="computed")
    assert jit._cached(path, path.with_suffix(".txt"))


@pytest.mark.parametrize(
    "environment, words",
    [
        ({"CXX": "/nonexistent"}, "no C.. compiler.*CXX=/nonexistent.*Install"),
        ({"CXX": "", "PATH": ""}, "no C.. compiler.*g.."),
    ],
    ids=["CXX wrong", "PATH empty"],
)
def test_no_compiler(cache, environment, words, run_here):
    assert re.search(words, run_here(cache, "3.0", "refused", environment), re.S)


def test_compiler_that_fails(cache, run_here):
    assert "the compiler failed" in run_here(cache, "3.0", "refused", {"CXX": "false"})
    assert not list(cache.glob("*"))  # nothing half-made stays behind


def test_new_folders_are_private(cache, monkeypatch):
    """Whatever the umask is; parents that were missing as well."""
    below = cache / "more" / "kernels"
    monkeypatch.setenv("IMPACT_JIT_CACHE", str(below))
    before = os.umask(0)
    try:
        jit.compile_form(small_form())
    finally:
        os.umask(before)
    assert [stat.S_IMODE(p.stat().st_mode) for p in (cache, cache / "more", below)] == [0o700] * 3
    assert {stat.S_IMODE(p.stat().st_mode) for p in below.iterdir()} == {0o600}


def _foreign(path):
    os.chown(path, 12345, -1)


def _open_to(mode):
    return lambda path: path.chmod(mode)


@pytest.mark.parametrize(
    "spoil, words",
    [
        (_open_to(0o777), "mode 0777.*chmod -R go-w"),
        (_open_to(0o770), "mode 0770.*chmod -R go-w"),
        (_foreign, "belongs to uid 12345, this process runs as root"),
    ],
    ids=["world", "group", "foreign"],
)
@pytest.mark.parametrize("what", ["folder", "library", "list"])
def test_what_others_may_have_written_is_not_loaded(cache, library, spoil, words, what, run_here):
    if spoil is _foreign and os.geteuid() != 0:
        pytest.skip("only root can give files away")
    path = library
    spoil({"folder": cache, "library": path, "list": path.with_suffix(".txt")}[what])
    text = run_here(cache, "1.0", "refused")
    assert "IMPACT_JIT_CACHE" in text and str(cache) in text
    if what == "folder" or spoil is _foreign:
        assert re.search(words, text), text
    else:
        assert "others may write the file" in text and "Delete it" in text
        path.unlink()
        path.with_suffix(".txt").unlink()
        run_here(cache, "1.0", "computed")


def test_parents_that_everybody_may_write_in(tmp_path, run_here):
    """Without the sticky bit everybody may put another folder there; with it, as in /tmp, not."""
    parent = tmp_path / "open"
    parent.mkdir()
    parent.chmod(0o777)
    text = run_here(parent / "kernels", "3.0", "refused")
    assert "everybody may write in" in text and "chmod +t" in text
    parent.chmod(0o1777)
    run_here(parent / "kernels", "3.0", "computed")


def test_a_link_counts_as_what_it_leads_to(tmp_path, run_here):
    (tmp_path / "open").mkdir()
    (tmp_path / "open").chmod(0o777)
    (tmp_path / "link").symlink_to(tmp_path / "open")
    assert "others may write in it" in run_here(tmp_path / "link", "3.0", "refused")


UNICODE, LATIN = "K\u00f6rper \u63a5\u89e6", b"latin \xe4"


@pytest.mark.parametrize("name", ["a b  c", UNICODE, LATIN], ids=["blanks", "unicode", "bytes"])
@pytest.mark.long_rows(where=lambda name, locale: (name, locale) != (UNICODE, "C"))
@pytest.mark.parametrize("locale", ["C.UTF-8", "C"])
def test_names_of_folders(tmp_path, name, locale):
    """Compiled and found again, in a locale that knows no letters but ASCII's as well."""
    folder = os.fsencode(tmp_path) + b"/" + (name if isinstance(name, bytes) else name.encode())
    plain = {"LC_ALL": locale, "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    for _ in range(2):
        run(os.fsdecode(folder), "3.0", "computed", plain)
    assert sorted(os.path.splitext(f)[1] for f in os.listdir(folder)) == [b".cpp", b".so", b".txt"]


def test_compiler_with_arguments(cache, run_here):
    run_here(cache, "3.0", "computed", {"CXX": "g++ -O1"})


def test_cache_below_a_file(cache, run_here):
    cache.write_text("a file, not a folder")
    text = run_here(cache, "3.0", "refused")
    assert str(cache) in text and "IMPACT_JIT_CACHE" in text
    assert "IMPACT_JIT_CACHE" in run_here(cache / "below", "3.0", "refused")


def test_cache_that_cannot_be_written(tmp_path, run_here):
    assert "IMPACT_JIT_CACHE" in run_here("/proc/impact_kernels", "3.0", "refused")


def test_cache_without_room(cache):
    """A file size limit stands for a full disk."""
    limit = "import resource\nresource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))\n"
    text = run(cache, "3.0", "refused", code=SCRIPT.replace("\ntry:", "\n" + limit + "try:"))
    assert str(cache) in text and "IMPACT_JIT_CACHE" in text
    assert not list(cache.glob("*"))


@pytest.mark.mpi
@pytest.mark.long_rows(where=lambda ranks: ranks != 3)
@pytest.mark.parametrize("ranks", [1, 2, 3])
def test_ranks_compile_together(cache, mpirun, ranks):
    output = mpirun(ranks, SCRIPT, "5.0", env={"IMPACT_JIT_CACHE": str(cache)})
    assert output.count("computed") == ranks and len(list(cache.glob("*.so"))) == 1


@pytest.mark.mpi
@pytest.mark.long_rows(where=lambda environment: "CXX" not in environment)
@pytest.mark.parametrize(
    "environment",
    [{"CXX": "/nonexistent"}, {"IMPACT_JIT_CACHE": "/proc/impact_kernels"}],
    ids=["no compiler", "no cache"],
)
def test_ranks_fail_together(cache, mpirun, environment):
    refused_together(cache, mpirun, environment)


@pytest.mark.mpi
def test_ranks_refuse_together(cache, mpirun):
    cache.mkdir()
    cache.chmod(0o777)
    refused_together(cache, mpirun, {})


def refused_together(cache, mpirun, environment):
    output = mpirun(2, SCRIPT, "5.0", env={"IMPACT_JIT_CACHE": str(cache), **environment})
    refusals = [line for line in output.splitlines() if line.startswith("refused")]
    assert len(refusals) == 2 and len(set(refusals)) == 1


def test_processes_compile_at_the_same_time(cache):
    surroundings = {**os.environ, "IMPACT_JIT_CACHE": str(cache)}
    command = [sys.executable, "-c", SCRIPT, "7.0"]
    running = [subprocess.Popen(command, env=surroundings, stdout=subprocess.PIPE, text=True) for _ in range(3)]
    assert [p.communicate(timeout=100)[0].strip() for p in running] == ["computed"] * 3
    assert sorted(p.suffix for p in cache.iterdir()) == [".cpp", ".so", ".txt"]


@pytest.mark.parametrize("wrong", ["u*v*dx", None, 3, ufl.Identity(2)], ids=["text", "None", "number", "tensor"])
def test_not_a_form(wrong):
    with pytest.raises(TypeError, match="expected a UFL form, found"):
        jit.compile_form(wrong)


def test_one_name_for_two(cache):
    domain = mesh.create_unit_square(MPI.COMM_SELF, 1, 1)
    V = fem.functionspace(domain, ("Lagrange", 1))
    f, g = fem.Function(V, name="heat"), fem.Function(V, name="heat")
    form = f * g * ufl.TestFunction(V) * ufl.dx
    for _ in range(2):
        with pytest.raises(ValueError, match="two coefficients.*heat"):
            jit.compile_form(form)
    jit.compile_form(form, names={g: "other"})  # the cache now holds the form, and the first names are still wrong
    with pytest.raises(ValueError, match="two coefficients.*heat"):
        jit.compile_form(form)


def test_vertices(cache):
    domain = mesh.create_unit_square(MPI.COMM_SELF, 1, 1)
    v = ufl.TestFunction(fem.functionspace(domain, ("Lagrange", 1)))
    with pytest.raises(ValueError, match="over ufl.dP is not supported in kernels, which integrate over dx, ds and dS"):
        jit.compile_form(v * ufl.dP)
