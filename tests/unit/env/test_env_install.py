# SPDX-License-Identifier: MIT
"""env/inside: the package is installed when a source, the list or the Python changed, once, and never half."""

import os
import pty
import re
import signal
import subprocess
import sys
import time

import pytest

pytestmark = pytest.mark.waits


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


def test_builds_in_two_folders_know_nothing_of_each_other(project):
    project.run("true")
    assert project.run("true", IMPACT_BUILD="build/other").returncode == 0
    assert installs(project) == 2 and (project.checkout / "build/other/venv/bin/python3").exists()
    assert project.run("sh", "-c", "command -v python3", IMPACT_BUILD="build/other").stdout_text.strip() == str(
        project.checkout / "build/other/venv/bin/python3"
    )
    project.run("true")
    project.run("true", IMPACT_BUILD="build/other")
    assert installs(project) == 2


def test_each_prefix_has_a_build_folder_of_its_own(project, tmp_path):
    prefix = project.prefix(tmp_path / "of someone" / "dolfinx 0.11")
    project.run("true")
    for _ in range(2):
        assert project.run("true", IMPACT_DOLFINX=prefix).returncode == 0
    assert installs(project) == 2 and (project.checkout / "build/dolfinx_0.11/venv/bin/python3").exists()
    project.run("true", IMPACT_DOLFINX=prefix, IMPACT_BUILD="build/other")
    assert installs(project) == 3 and (project.checkout / "build/other/venv/bin/python3").exists()


def test_another_or_a_newer_prefix_means_another_install(project, tmp_path):
    prefixes = [project.prefix(tmp_path / name / "dolfinx-0.11") for name in ("one", "two")]
    for prefix in prefixes:
        project.run("true", IMPACT_DOLFINX=prefix)
    assert installs(project) == 2  # both have the same folder
    os.utime(prefixes[1] / "lib/cmake/dolfinx/DOLFINXConfig.cmake", (1e9, 1e9))
    for _ in range(2):
        project.run("true", IMPACT_DOLFINX=prefixes[1])
    assert installs(project) == 3


@pytest.mark.parametrize("system", [True, False])
def test_a_prefix_without_the_system_s_packages_does_not_get_them(project, tmp_path, system):
    """As one whose MPI is not the system's; otherwise with Debian 13's packages, as env/build_dolfinx.sh makes it."""
    prefix = project.prefix(tmp_path / "dolfinx-0.11")
    (prefix / "pyvenv.cfg").write_text(f"home = /usr/bin\ninclude-system-site-packages = {str(system).lower()}\n")
    text = (prefix / "bin" / "python3").read_text()
    (prefix / "bin" / "python3").write_text(text.replace('"-m venv"*) ', '"-m venv"*) echo "venv $*" >>"$CALLS"; '))
    assert project.run("true", IMPACT_DOLFINX=prefix).returncode == 0
    (call,) = project.calls("venv")
    assert ("--system-site-packages" in call) is system


@pytest.mark.parametrize("name", ["/tmp/build", "build/../..", "a folder"])
def test_a_build_folder_outside_is_refused(project, name):
    answer = project.run("true", IMPACT_BUILD=name)
    assert answer.returncode == 1 and f"not '{name}'" in answer.stderr_text and installs(project) == 0


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


@pytest.fixture
def installed(project):
    """A project that was built and installed a minute ago, with what CMake and pip would have left."""
    assert project.run("true").returncode == 0
    for name in ("build/release/build.ninja", "build/venv/lib/dolfinx_impact-0.1.0.dist-info/RECORD"):
        path = project.checkout / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    age(project)
    return project


def refreshes(project):
    return len(project.calls("refresh"))


@pytest.mark.parametrize("name", ["cpp/a.cpp", "python/d.py"])
def test_other_contents_are_brought_into_the_install(installed, name):
    (installed.checkout / name).write_text("changed\n")
    installed.run("true")
    installed.run("true")
    assert (installs(installed), refreshes(installed)) == (1, 1)
    site = installed.checkout / "build" / "venv" / "lib"
    assert installed.calls("refresh") == [f"refresh env/refresh.py build/release {site}"]


def _new_source(checkout):
    (checkout / "python" / "new.py").write_text("")


def _no_source(checkout):
    (checkout / "python" / "d.py").unlink()


def _other_settings(checkout):
    (checkout / "pyproject.toml").write_text("changed\n")


def _half_an_install(checkout):
    (checkout / "build/venv/lib/dolfinx_impact-0.1.0.dist-info/RECORD").unlink()
    (checkout / "python" / "d.py").write_text("changed\n")


@pytest.mark.parametrize("change", [_new_source, _no_source, _other_settings, _half_an_install])
def test_other_changes_are_installed_by_pip(installed, change):
    change(installed.checkout)
    installed.run("true")
    assert (installs(installed), refreshes(installed)) == (2, 0)


def test_a_failed_refresh_stops_and_is_tried_again(installed):
    (installed.checkout / "cpp" / "a.cpp").write_text("changed\n")
    failed = installed.run("echo", "not reached", FAKE_REFRESH_STATUS=1)
    assert failed.returncode == 1 and failed.stdout_text == ""
    assert "refresh was here" in failed.stderr_text and "build/install.log" in failed.stderr_text
    assert installed.run("echo", "reached").stdout_text == "reached\n"
    assert (installs(installed), refreshes(installed)) == (1, 2)


@pytest.fixture
def refresh(project):
    """refresh() -> the process: env/refresh.py itself, on a package in python/, with a stand-in for CMake."""
    checkout, site = project.checkout, project.checkout / "site"
    (checkout / "pyproject.toml").write_text(
        '[tool.scikit-build.wheel.packages]\n"one" = "python"\n"one/two" = "forms"\n'
    )
    project.stub("cmake", 'echo "cmake $*" >>"$CALLS"; exit "${FAKE_CMAKE_STATUS:-0}"')

    def run(status=0):
        command = [sys.executable, checkout / "env" / "refresh.py", "build/release", site]
        return subprocess.run(command, cwd=checkout, env={**project.env, "FAKE_CMAKE_STATUS": str(status)})

    return run


def test_refresh_builds_installs_and_copies_what_changed(project, refresh):
    site = project.checkout / "site"
    assert refresh().returncode == 0
    assert project.calls("cmake") == [
        "cmake --build build/release",
        f"cmake --install build/release --prefix {site} --strip",
    ]
    assert (site / "one" / "d.py").read_text() == (site / "one" / "two" / "b.py").read_text() == "source\n"
    unchanged = (site / "one" / "two" / "b.py").stat().st_ino
    (project.checkout / "python" / "d.py").write_text("changed\n")
    assert refresh().returncode == 0
    assert (site / "one" / "d.py").read_text() == "changed\n"
    assert (site / "one" / "two" / "b.py").stat().st_ino == unchanged
    assert not list(site.rglob("*.new"))


def test_refresh_copies_nothing_that_was_not_built(project, refresh):
    assert refresh(status=3).returncode == 3
    assert not (project.checkout / "site").exists()


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
