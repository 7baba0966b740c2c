# SPDX-License-Identifier: MIT
"""env/inside: the package is installed when a source, the list or the Python changed, once, and never half."""

import os
import signal
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
