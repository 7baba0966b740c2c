# SPDX-License-Identifier: MIT
"""env/inside: the package is installed when a source, the list or the Python changed, once, and never half."""

import os
import pty
import re
import signal
import subprocess
import time

import pytest


@pytest.fixture
def project(sandbox):
    """A checkout with sources, in an environment that has DOLFINx."""
    sandbox.dolfinx.touch()
    sandbox.env["IMPACT_ENV"] = "native"
    for name in ("pyproject.toml", "cpp/a.cpp", "forms/b.py", "meshes/c.py", "python/d.py", "demos/e.py"):
        path = sandbox.checkout / name
        path.parent.mkdir(exist_ok=True)
        path.write_text("source\n")
    return sandbox


def age(project):
    """Let all that was made so far be a minute old, so that the next change is newer whatever the clock's grain."""
    for path in project.checkout.rglob("*"):
        if not path.is_symlink():
            os.utime(path, (path.stat().st_atime, path.stat().st_mtime - 60))


def installs(project):
    return len(project.calls("pip"))


def test_installed_at_the_first_start_only(project):
    first = project.run("echo", "out")
    assert (first.returncode, first.stdout_text) == (0, "out\n")
    assert "installing" in first.stderr_text
    second = project.run("echo", "out")
    assert (second.stdout_text, second.stderr_text) == ("out\n", "")
    assert installs(project) == 1


def test_no_build_means_no_build(project):
    assert project.run("--no-build", "true").returncode == 0
    assert project.run("true", IMPACT_NO_BUILD="1").returncode == 0
    assert installs(project) == 0


@pytest.mark.parametrize(
    "name", ["cpp/a.cpp", "forms/b.py", "meshes/c.py", "python/d.py", "demos/e.py", "forms/new.py"]
)
def test_a_changed_or_new_source_is_installed(project, name):
    project.run("true")
    age(project)
    (project.checkout / name).write_text("changed\n")
    project.run("true")
    project.run("true")
    assert installs(project) == 2


def test_a_deleted_source_is_noticed(project):
    project.run("true")
    (project.checkout / "python" / "d.py").unlink()
    project.run("true")
    assert installs(project) == 2


def test_a_byte_code_file_is_no_source(project):
    project.run("true")
    age(project)
    (project.checkout / "python" / "__pycache__").mkdir()
    (project.checkout / "python" / "__pycache__" / "d.pyc").write_text("")
    project.run("true")
    assert installs(project) == 1


def test_another_package_list_means_another_install(project):
    project.run("true")
    project.packages("alpha\nbeta\ngamma\n")
    project.run("true")
    assert installs(project) == 2


def test_a_failed_install_stops_and_is_tried_again(project):
    failed = project.run("echo", "not reached", FAKE_PIP_STATUS=1)
    assert failed.returncode == 1 and failed.stdout_text == ""
    assert "pip was here" in failed.stderr_text and "build/install.log" in failed.stderr_text
    assert project.run("echo", "reached").stdout_text == "reached\n"
    assert installs(project) == 2


def test_an_interrupted_install_is_done_again(project):
    process = project.start("true", FAKE_PIP_SECONDS=60)
    end = time.monotonic() + 20
    while not installs(project):
        assert time.monotonic() < end
        time.sleep(0.02)
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    assert project.run("echo", "reached").stdout_text == "reached\n"
    assert installs(project) == 2


def test_two_starts_install_once(project):
    starts = [project.start("echo", "out", FAKE_PIP_SECONDS=1) for _ in range(3)]
    assert [s.communicate(timeout=30)[0] for s in starts] == ["out\n"] * 3
    assert installs(project) == 1


def test_a_running_command_does_not_hold_the_install_lock(project):
    long = project.start("sh", "-c", "echo ready; exec sleep 60")
    assert long.stdout.readline() == "ready\n"
    age(project)
    (project.checkout / "cpp" / "a.cpp").write_text("changed\n")
    start = time.monotonic()
    assert project.run("true").returncode == 0
    assert time.monotonic() - start < 20 and installs(project) == 2
    os.killpg(long.pid, signal.SIGKILL)
    long.communicate()


NINJA = """
case "$*" in
  *"import dolfinx"*) [ -e "$FAKE_DOLFINX" ] ;;
  "-m venv"*) venv=${!#}; mkdir -p "$venv/bin" "$venv/lib"; cp -- "$0" "$venv/bin/python3" ;;
  *sysconfig*) echo "$(cd -- "$(dirname -- "$0")/.." && pwd)/lib" ;;
  *"-m pip"*) echo "  [1/8] Building CXX object a/first.cpp.o"; sleep 2
              echo "  [6/8] Building CXX object b/later.cpp.o"; sleep 2
              echo "  *** Making wheel..."; sleep 2 ;;
esac"""
REPORTS = [
    r"env/run: build: 12 % \(1 of 8, first\.cpp\.o\), \d+ s",
    r"env/run: build: 75 % \(6 of 8, later\.cpp\.o\), \d+ s",
    r"env/run: install: 33 % \(packing\), \d+ s",
]


def test_a_build_reports_its_progress_now_and_then(project):
    """In a file: whole lines, at most one in the interval, with seconds that grow."""
    project.stub("python3", NINJA)
    answer = project.run("echo", "out", IMPACT_PROGRESS_SECONDS=1)
    assert (answer.returncode, answer.stdout_text) == (0, "out\n")
    lines = [line for line in answer.stderr_text.splitlines() if " %" in line]
    for report in REPORTS:
        assert any(re.fullmatch(report, line) for line in lines), lines
    assert all(any(re.fullmatch(report, line) for report in REPORTS) for line in lines), lines
    seconds = [int(line.split()[-2]) for line in lines]
    assert seconds == sorted(set(seconds)) and "\r" not in answer.stderr_text


def test_a_build_rewrites_one_line_of_a_terminal(project):
    project.stub("python3", NINJA)
    ours, theirs = pty.openpty()
    command = [project.checkout / "env" / "run", "true"]
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stderr=theirs, env=project.env)
    os.close(theirs)
    text = b""
    try:
        while part := os.read(ours, 4096):
            text += part
    except OSError:  # the other end is closed: all that had it have ended
        pass
    os.close(ours)
    assert process.wait(timeout=20) == 0
    first, progress, last = text.decode().split("\r\n")[:3]
    assert "building and installing" in first and re.search(r"env/run: installed in \d+ s$", last or progress)
    reports = progress.split("\r\x1b[K")
    for report in REPORTS:
        assert any(re.fullmatch(report, part) for part in reports), reports


def test_a_short_build_reports_nothing_between(project):
    answer = project.run("true")
    assert answer.returncode == 0 and len(answer.stderr_text.splitlines()) == 2, answer.stderr_text
