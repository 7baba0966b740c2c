# SPDX-License-Identifier: MIT
"""The gates of `make lint` stop a broken file; the helpers of conftest stop a broken run."""

import functools
import os
import pathlib
import re
import shutil
import subprocess

import pytest

GOOD = {
    "cpp/a.cpp": "int value = 1;\n",
    "a.py": '"""Documented."""\n\nvalue = 1\n',
    "typed.py": '"""Documented."""\n\n\ndef twice(x: float) -> float:\n    return 2 * x\n',
}
BROKEN = {
    "clang-format": ("cpp/a.cpp", "int  value=1;\n"),
    "clang-format in a header": ("cpp/deep/er/a.h", "struct A{int  a;};\n"),
    "black": ("a.py", "value=1\n"),
    "black, line length": ("a.py", "value = dict(" + ", ".join(f"name_{i}={i}" for i in range(12)) + ")\n"),
    "flake8, unused import": ("a.py", "import os\n"),
    "flake8, undefined name": ("a.py", "print(undefined)\n"),
    "flake8, long comment": ("a.py", "#" + " xx" * 45 + "\n"),
    "mypy, no annotation": ("typed.py", "def twice(x):\n    return 2 * x\n"),
    "mypy, wrong type": ("typed.py", "def twice(x: float) -> str:\n    return 2 * x\n"),
}


@pytest.fixture(scope="module")
def library_types(tmp_path_factory):
    """Folder for what mypy keeps of the standard library: it is read once for all tests."""
    return tmp_path_factory.mktemp("types")


@pytest.fixture
def lint(checkout, library_types):
    """lint(folder, files, *target): run make in a checkout of these files alone, the gates if no target is given."""
    return functools.partial(run_make, checkout, library_types)


def run_make(checkout, library_types, folder, files, *target):
    folder.mkdir(exist_ok=True)
    for name in ("Makefile", ".clang-format", ".flake8", "pyproject.toml"):
        shutil.copy(checkout / name, folder)
    settings = folder / "pyproject.toml"  # mypy checks the list of files that is written there
    text, count = re.subn(r"^files = \[\n.*?^\]", 'files = ["typed.py"]', settings.read_text(), flags=re.M | re.S)
    assert count == 1
    settings.write_text(text)
    (folder / "demos").mkdir()
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        os.utime(path, (1e9, 1e9))
    # Types are checked with DOLFINx 0.9 alone, and these files ask for none.
    not_ours = ("ARGS", "MAKEFLAGS", "MAKELEVEL", "MFLAGS", "PYTEST", "IMPACT_DOLFINX")
    environment = {k: v for k, v in os.environ.items() if k not in not_ours} | {"IMPACT_CACHE": str(library_types)}
    command = ["make", *(target or ["lint-here"])]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)


def test_the_gates_pass_good_files(lint, tmp_path):
    done = lint(tmp_path, GOOD)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.long_rows(where=lambda what: what in ("clang-format", "black, line length", "flake8, unused import"))
@pytest.mark.parametrize("what", BROKEN)
def test_the_gates_stop_a_broken_file(lint, tmp_path, what):
    """Its own gate, for most; `make lint` has them all."""
    name, text = BROKEN[what]
    whole = what in ("black", "mypy, wrong type")
    gate = "lint-here" if whole else "types-here" if name == "typed.py" else "formats-here"
    done = lint(tmp_path, {**GOOD, name: text}, gate)
    assert done.returncode != 0
    assert name in done.stdout + done.stderr  # stopped for this file, not for another reason


def test_types_begin_with_what_another_checkout_left(lint, tmp_path):
    """A file that fits is not checked anew. Another one is, though size and time of change are the same."""
    good = "def twice(x: int) -> int:\n    return 2 * x\n"
    wrong = good.replace("-> int", "-> str")

    def types(name, text):
        """Exit status, output, time of change of what mypy keeps about the file."""
        done = lint(tmp_path / name, {"typed.py": text}, "types-here", f"IMPACT_CACHE={tmp_path / 'cache'}")
        made = (tmp_path / name / "build" / "mypy").rglob("typed.data.json")
        return done.returncode, done.stdout, [path.stat().st_mtime_ns for path in made]

    (tmp_path / "cache").mkdir()
    status, output, made = types("first", good)
    assert status == 0 and len(made) == 1, output
    assert types("second", good) == (0, "", made)
    status, output, _ = types("third", wrong)
    assert status != 0 and "typed.py:2" in output
    assert types("fourth", good) == (0, "", made), "what is kept is that of a check that passed"


def test_make_test_stops_at_the_formatters(checkout):
    """They come first, and make goes no further when one stops."""
    plan = subprocess.run(
        ["make", "--dry-run", "test"], cwd=checkout, capture_output=True, text=True
    ).stdout.splitlines()
    formats_line = next(i for i, line in enumerate(plan) if "formats-here" in line)
    test_line = next(i for i, line in enumerate(plan) if "test-here" in line)
    assert formats_line < test_line


# Stands for make and env/run: says its call, and fails where FAILS names it.
STAND_IN = """#!/bin/sh
echo "called $*"
[ "$*" = test ] && printf '%s\\n' "FAILED tests/test_a.py::test_b - assert 1 > 2" \\
  "1 failed, 20 passed, 3 skipped in 9.51s" "400 passed in 61.20s (0:01:01)"
case " $FAILS " in *" $1 "*) exit 2 ;; esac
"""


@pytest.mark.parametrize("fails", ("", "test", "sanitize dolfinx-impact"))
def test_ci_runs_all_three_and_says_how_each_ended(checkout, tmp_path, fails):
    """What fails keeps none of the others from running; the last line has the numbers of tests of both processes."""
    for name in (".ci/run", "env/run", "make"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(STAND_IN)
        (tmp_path / name).chmod(0o755)
    shutil.copy(checkout / ".ci" / "run", tmp_path / ".ci" / "run")
    environment = os.environ | {"PATH": f"{tmp_path}:{os.environ['PATH']}", "FAILS": fails}
    done = subprocess.run([tmp_path / ".ci" / "run"], env=environment, capture_output=True, text=True, cwd="/")
    calls = [line for line in done.stdout.splitlines() if line.startswith("called")]
    assert calls == ["called test", "called sanitize", "called dolfinx-impact verify --json results/verify.json"]
    assert done.returncode == (1 if fails else 0) and done.stderr == ""
    *stages, which, verdict, tests = done.stdout.splitlines()[-6:]
    for name, line in zip(("test", "sanitize", "dolfinx-impact"), stages):
        assert name in line and line.endswith(" s") and ("failed with status 2" in line) == (name in fails)
    assert which == "FAILED tests/test_a.py::test_b - assert 1 > 2"
    assert verdict.startswith("ci: failed: " if fails else "ci: all passed")
    assert tests == "tests: 1 failed, 420 passed, 3 skipped"


# Stands for pytest in a shared run: notes its call.
CALLED = "sh -c 'echo \"called $$*\"; exit {status}' pytest"


@pytest.mark.parametrize(
    "broken, status, words",
    [({}, 0, None), ({}, 1, "tests-1 tests-2"), ({"typed.py": BROKEN["mypy, wrong type"][1]}, 0, "types-here")],
    ids=["good", "tests fail", "wrong type"],
)
def test_make_test_checks_types_beside_the_tests(lint, tmp_path, broken, status, words):
    """Either may fail: the other goes on, the whole fails, and the last line says which it was."""
    done = lint(tmp_path, {**GOOD, **broken}, "test-here", f"PYTEST={CALLED.format(status=status)}")
    calls = [line for line in done.stdout.splitlines() if line.startswith("called -m not slow")]
    assert len(calls) == 2 and len({line.partition("--share ")[2] for line in calls}) == 1, done.stdout + done.stderr
    assert (done.returncode == 0) == (words is None), done.stdout + done.stderr
    said = [line for line in done.stderr.splitlines() if line.startswith("test: ")]
    assert said == ([] if words is None else [f"test: failed: {words}"])
    assert ("typed.py:2" in done.stdout) == bool(broken)


def test_a_part_of_make_test_checks_types_too(lint, tmp_path):
    files = {**GOOD, "typed.py": BROKEN["mypy, wrong type"][1]}
    done = lint(tmp_path, files, "test-here", f"PYTEST={CALLED.format(status=0)}", "ARGS=-k name")
    assert done.returncode != 0 and "typed.py:2" in done.stdout
    assert [line for line in done.stdout.splitlines() if line.startswith("called")] == ["called -m not slow -k name"]


def test_help_lists_the_commands(checkout):
    text = subprocess.run(["make"], cwd=checkout, capture_output=True, text=True).stdout
    for target in ("demo", "test", "verify", "bench", "docs", "shell", "lint", "format", "clean"):
        assert f"make {target}" in text


# The guarded mpirun of tests/conftest.py, on which all parallel tests rely.


@pytest.mark.mpi
@pytest.mark.parametrize("n", [1, 2, 3])
def test_mpirun_runs_n_ranks(mpirun, n):
    # One rank prints: lines of several may come out mixed.
    code = "from mpi4py import MPI; c = MPI.COMM_WORLD; r = c.gather(c.rank); print('ranks', r) if r else None"
    assert f"ranks {list(range(n))}" in mpirun(n, code)


@pytest.mark.mpi
def test_mpirun_passes_arguments_and_scripts(mpirun, tmp_path):
    script = tmp_path / "a script.py"
    script.write_text("import sys\nprint(sys.argv[1:])\n")
    assert "['a b', '']" in mpirun(1, script, "a b", "")
    assert "set" in mpirun(1, "import os; print(os.environ['IMPACT_X'])", env={"IMPACT_X": "set"})


@pytest.mark.mpi
def test_mpirun_shows_the_error_of_one_rank(mpirun):
    """One rank fails while the other waits for it: no hang, and the message is shown."""
    code = """
        from mpi4py import MPI
        if MPI.COMM_WORLD.rank == 1:
            raise ValueError("from rank one")
        MPI.COMM_WORLD.barrier()
    """
    with pytest.raises(pytest.fail.Exception, match="from rank one"):
        mpirun(2, code)
    assert "from rank one" in mpirun(2, code, status=1)


@pytest.mark.mpi
@pytest.mark.alone
def test_mpirun_kills_a_run_that_hangs(mpirun, tmp_path):
    """Ranks that ignore the polite signal and wait for each other for ever are gone after the timeout."""
    code = f"""
        import os, pathlib, signal, time
        from mpi4py import MPI
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        pathlib.Path({str(tmp_path)!r}, f"pid-{{MPI.COMM_WORLD.rank}}").write_text(str(os.getpid()))
        print("so far", flush=True)
        if MPI.COMM_WORLD.rank == 0:
            MPI.COMM_WORLD.barrier()
        time.sleep(1000)
    """
    with pytest.raises(pytest.fail.Exception, match="so far"):
        mpirun(2, code, timeout=4)
    pids = [int(p.read_text()) for p in tmp_path.glob("pid-*")]
    assert len(pids) == 2
    for pid in pids:
        stat = pathlib.Path(f"/proc/{pid}/stat")
        assert not stat.exists() or stat.read_text().rpartition(")")[2].split()[0] == "Z"


def test_rng_repeats(rng, request, seed):
    import zlib

    import numpy as np

    again = np.random.default_rng([seed, zlib.crc32(request.node.nodeid.encode())])
    assert np.array_equal(rng.random(5), again.random(5))
