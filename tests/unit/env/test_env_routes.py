# SPDX-License-Identifier: MIT
"""env/run: which route is taken, what passes through, and what is said when there is no route."""

import os
import signal
import subprocess
import time

import pytest

pytestmark = pytest.mark.waits
ROUTES = ["native", "root"]


@pytest.fixture(params=ROUTES)
def route(request, sandbox):
    if request.param == "native":
        sandbox.dolfinx.touch()
    sandbox.env["IMPACT_ENV"] = request.param
    return request.param


def test_arguments_pass_through_unchanged(sandbox, route):
    arguments = ["two words", "", 'quo"te', "it's", "$HOME", "*", "back\\slash", "-n", "new\nline"]
    answer = sandbox.run("printf", "%s|", *arguments)
    assert answer.stdout_text == "".join(a + "|" for a in arguments)


def test_standard_input_passes_through(sandbox, route):
    text = "first\n" + "x" * 200000 + "\nlast"
    assert sandbox.run("cat", stdin=text).stdout_text == text


@pytest.mark.parametrize("status", [0, 1, 7, 255])
def test_exit_status_passes_through(sandbox, route, status):
    assert sandbox.run("sh", "-c", f"exit {status}").returncode == status


def test_an_unknown_command_is_127(sandbox, route):
    answer = sandbox.run("no-such-command")
    assert answer.returncode == 127 and "no-such-command" in answer.stderr_text


def test_a_signal_reaches_the_command(sandbox, route):
    process = sandbox.start("sh", "-c", "echo ready; exec sleep 60")
    assert process.stdout.readline() == "ready\n"
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=20)
    assert process.returncode == -signal.SIGTERM


def test_the_command_runs_in_the_caller_s_folder(sandbox, route, tmp_path):
    """However env/run is called: by its path, by a link, by a path relative to there."""
    folder = tmp_path / "a folder" / "below"
    folder.mkdir(parents=True)
    (folder / "script.sh").write_text("pwd\n")
    (tmp_path / "link").symlink_to(sandbox.checkout / "env" / "run")
    for run in (sandbox.checkout / "env" / "run", tmp_path / "link", "../../a checkout/env/run"):
        done = subprocess.run(
            [run, "sh", "script.sh"],
            env={**sandbox.env, "CDPATH": str(tmp_path)},
            cwd=folder,
            capture_output=True,
            text=True,
        )
        assert (done.stdout, done.returncode) == (f"{folder}\n", 0), done.stderr
    assert sandbox.run("pwd", cwd=sandbox.checkout).stdout_text == f"{sandbox.checkout}\n"


def test_the_package_is_built_in_the_checkout_wherever_the_caller_is(sandbox, tmp_path):
    sandbox.dolfinx.touch()
    (sandbox.checkout / "pyproject.toml").write_text("source\n")
    answer = sandbox.run("true", cwd=tmp_path, IMPACT_ENV="native")
    assert answer.returncode == 0, answer.stderr_text
    assert (sandbox.checkout / "build" / "venv" / "bin" / "python3").exists() and not (tmp_path / "build").exists()


@pytest.mark.parametrize("folder", ["/usr/share", "/etc", "/var"])
def test_the_root_does_not_see_the_system_s_folders(sandbox, folder):
    answer = sandbox.run("true", cwd=folder)
    assert answer.returncode == 1 and f"does not see {folder}, a folder of this system" in answer.stderr_text
    assert sandbox.calls("mmdebstrap") == []  # found out before two minutes of work
    sandbox.dolfinx.touch()
    assert sandbox.run("pwd", cwd=folder, IMPACT_ENV="native").stdout_text == f"{folder}\n"


def test_a_caller_s_folder_that_is_gone(sandbox, tmp_path):
    (tmp_path / "gone").mkdir()
    gone = f'cd "{tmp_path}/gone" && rmdir ../gone && exec "{sandbox.checkout}/env/run" true'
    done = subprocess.run(["sh", "-c", gone], env=sandbox.env, capture_output=True, text=True)
    assert done.returncode == 1 and "folder is gone" in done.stderr


def test_another_dolfinx_is_taken_from_its_prefix(sandbox, route, tmp_path):
    prefix = sandbox.prefix(tmp_path / "some where" / "dolfinx-0.11")
    (sandbox.checkout / "pyproject.toml").write_text("source\n")
    sandbox.dolfinx.unlink(missing_ok=True)  # nobody else's DOLFINx is needed
    answer = sandbox.run("env", cwd=tmp_path, IMPACT_DOLFINX="some where/dolfinx-0.11", CMAKE_PREFIX_PATH="/opt/mine")
    assert answer.returncode == 0, answer.stderr_text
    found = dict(line.split("=", 1) for line in answer.stdout_text.splitlines() if "=" in line)
    venv = sandbox.checkout / "build" / "dolfinx-0.11" / "venv"
    assert found["PATH"].split(":")[:2] == [f"{venv}/bin", f"{prefix}/bin"]
    assert found["CMAKE_PREFIX_PATH"] == f"{prefix}:/opt/mine"
    assert found["IMPACT_DOLFINX"] == str(prefix)
    assert (venv / "bin" / "python3").read_text() == (prefix / "bin" / "python3").read_text()


def test_a_prefix_is_found_without_naming_a_route(sandbox, tmp_path):
    prefix = sandbox.prefix(tmp_path / "dolfinx-0.11")
    answer = sandbox.run("echo", "there", IMPACT_ENV=None, IMPACT_DOLFINX=prefix)
    assert (answer.stdout_text, answer.stderr_text) == ("there\n", "")
    assert not sandbox.calls_file.exists() and not sandbox.cache.exists()


def _no_prefix(prefix):
    prefix.rename(prefix.with_name("elsewhere"))


def _no_cmake_file(prefix):
    (prefix / "lib" / "cmake" / "dolfinx" / "DOLFINXConfig.cmake").unlink()


def _no_dolfinx(prefix):
    text = (prefix / "bin" / "python3").read_text()
    (prefix / "bin" / "python3").write_text(text.replace(" true ;;", " false ;;"))


def _no_python(prefix):
    (prefix / "bin" / "python3").unlink()


@pytest.mark.parametrize(
    "harm, said",
    [
        (_no_prefix, "is no folder"),
        (_no_cmake_file, "no lib/cmake/dolfinx/DOLFINXConfig.cmake"),
        (_no_dolfinx, "bin/python3 cannot import DOLFINx 0.9, 0.10 or 0.11"),
        (_no_python, "bin/python3 cannot import DOLFINx 0.9, 0.10 or 0.11"),
    ],
)
def test_a_prefix_that_is_none_is_refused(sandbox, route, tmp_path, harm, said):
    prefix = sandbox.prefix(tmp_path / "dolfinx-0.11")
    harm(prefix)
    answer = sandbox.run("echo", "not reached", IMPACT_DOLFINX=prefix)
    assert answer.returncode == 1 and answer.stdout_text == ""
    assert f"{prefix}" in answer.stderr_text and said in answer.stderr_text


def test_the_root_does_not_see_a_prefix_of_the_system(sandbox):
    sandbox.stub("find", "echo there")  # its CMake file
    answer = sandbox.run("true", IMPACT_DOLFINX="/usr/share")
    assert answer.returncode == 1 and "does not see IMPACT_DOLFINX=/usr/share" in answer.stderr_text


def test_the_variables_of_a_parallel_run_are_set(sandbox, route):
    names = ("OMPI_ALLOW_RUN_AS_ROOT", "OMP_NUM_THREADS", "OMPI_MCA_btl", "MPLBACKEND", "LC_ALL")
    answer = sandbox.run("env", OMP_NUM_THREADS="3")
    found = dict(line.split("=", 1) for line in answer.stdout_text.splitlines() if "=" in line)
    assert all(found.get(name) for name in names)
    assert found["OMP_NUM_THREADS"] == "3"  # what the caller sets stays


def test_the_root_does_not_see_the_caller_s_libraries(sandbox):
    answer = sandbox.run("env", PETSC_DIR="/opt/petsc", PYTHONPATH="/opt/python", LC_ALL="en_GB.UTF-8")
    assert "/opt/petsc" not in answer.stdout_text and "/opt/python" not in answer.stdout_text
    assert "LC_ALL=C.UTF-8" in answer.stdout_text.splitlines()


def test_native_keeps_the_caller_s_path(sandbox):
    sandbox.dolfinx.touch()
    answer = sandbox.run("env", IMPACT_ENV="native", PYTHONPATH="/opt/python")
    path = next(line for line in answer.stdout_text.splitlines() if line.startswith("PATH="))
    assert path == f"PATH={sandbox.checkout}/build/venv/bin:{sandbox.env['PATH']}"
    assert "PYTHONPATH=/opt/python" in answer.stdout_text.splitlines()


def test_dolfinx_on_the_machine_is_used_as_it_is(sandbox):
    sandbox.dolfinx.touch()
    answer = sandbox.run("echo", "there", IMPACT_ENV=None)
    assert (answer.stdout_text, answer.stderr_text) == ("there\n", "")
    assert not sandbox.calls_file.exists() and not sandbox.cache.exists()


def test_no_route_names_three_ways(sandbox):
    answer = sandbox.run("true", IMPACT_ENV=None, FAKE_UID=1000)
    assert answer.returncode == 1
    assert answer.stdout_text == ""
    for way in ("1. install it for python3", "2. run this as root", "3. build the container recipe env/Containerfile"):
        assert way in answer.stderr_text
    assert not sandbox.calls_file.exists() and not sandbox.cache.exists()


def test_root_route_needs_root(sandbox):
    answer = sandbox.run("true", FAKE_UID=1000)
    assert answer.returncode == 1 and "rights of root" in answer.stderr_text


def test_native_without_dolfinx(sandbox):
    answer = sandbox.run("true", IMPACT_ENV="native")
    assert answer.returncode == 1 and "cannot import DOLFINx 0.9, 0.10 or 0.11" in answer.stderr_text


def test_apt_route_installs_the_list_once(sandbox):
    sandbox.env["IMPACT_ENV"] = "apt"
    answer = sandbox.run("echo", "done")
    assert (answer.returncode, answer.stdout_text) == (0, "done\n"), answer.stderr_text
    assert sandbox.calls("apt-get")[-1].endswith("alpha beta")
    assert len(sandbox.calls("apt-get")) == 2
    sandbox.run("echo", "done", IMPACT_ENV=None)  # found, not installed again
    assert len(sandbox.calls("apt-get")) == 2


def test_apt_route_that_fails(sandbox):
    answer = sandbox.run("true", IMPACT_ENV="apt", FAKE_APT_STATUS=100)
    assert answer.returncode == 1 and "could not install env/packages.txt" in answer.stderr_text


def test_wrong_use(sandbox):
    assert "usage:" in sandbox.run().stderr_text
    answer = sandbox.run("true", IMPACT_ENV="conda")
    assert answer.returncode == 1 and "'conda'" in answer.stderr_text
    answer = sandbox.run("--help")
    assert answer.returncode == 0 and "IMPACT_CACHE" in answer.stdout_text and "set -euo" not in answer.stdout_text


def test_without_home(sandbox):
    answer = sandbox.run("sh", "-c", 'echo "$HOME"', HOME=None, FAKE_UID=0)
    assert answer.returncode == 0 and answer.stdout_text.startswith("/")


@pytest.mark.alone
def test_the_real_start_is_quick(checkout):
    """The environment these tests run in, entered once more. Best of three: the machine has other work too."""
    times = []
    for _ in range(3):
        start = time.monotonic()
        environ = {**os.environ, "IMPACT_NO_BUILD": "1"}
        done = subprocess.run([checkout / "env" / "run", "true"], env=environ, capture_output=True, text=True)
        times.append(time.monotonic() - start)
        assert done.returncode == 0, done.stderr
        if times[-1] < 2.0:
            return
    raise AssertionError(f"a second start took {min(times):.1f} s, promised are 2")


def test_the_container_recipe_reads_the_same_list(checkout):
    recipe = (checkout / "env" / "Containerfile").read_text()
    packages = (checkout / "env" / "packages.txt").read_text()
    names = [n for line in packages.splitlines() for n in line.partition("#")[0].split()]
    assert "COPY env/packages.txt" in recipe and "trixie" in recipe and len(names) > 20
    commands = "\n".join(line for line in recipe.splitlines() if not line.startswith("#"))
    assert [n for n in names if f" {n} " in commands.replace("\\\n", " ")] == []
