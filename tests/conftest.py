# SPDX-License-Identifier: MIT
"""Shared by all tests: one printed seed, a guarded mpirun, hypothesis without chance, a time limit on every test."""

import os
import pathlib
import signal
import subprocess
import sys
import textwrap
import time
import zlib

import numpy as np
import pytest

try:
    import hypothesis
except ImportError:  # the tests that use it say so themselves
    hypothesis = None
else:
    hypothesis.settings.register_profile("ci", derandomize=True, deadline=None, database=None, print_blob=True)
    hypothesis.settings.register_profile("explore", deadline=None, max_examples=1000, print_blob=True)
    hypothesis.settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "ci"))

DEFAULT_SEED = 20250
TEST_TIMEOUT = 600  # seconds, for tests that name none of their own


def pytest_addoption(parser):
    parser.addoption("--seed", type=int, default=None, help="seed of the rng fixture (also IMPACT_SEED)")


def _seed(config):
    given = config.getoption("--seed")
    return int(os.environ.get("IMPACT_SEED", DEFAULT_SEED)) if given is None else given


def pytest_report_header(config):
    return f"seed: {_seed(config)} (repeat or change with --seed N or IMPACT_SEED=N)"


@pytest.hookimpl(tryfirst=True)  # before -m selects by markers
def pytest_collection_modifyitems(config, items):
    for item in items:
        if item.get_closest_marker("mpi") or "mpirun" in item.fixturenames:
            item.add_marker(pytest.mark.alone)
    if config.pluginmanager.hasplugin("timeout"):
        for item in items:
            if item.get_closest_marker("timeout") is None:
                item.add_marker(pytest.mark.timeout(TEST_TIMEOUT))


@pytest.fixture(scope="session")
def seed(pytestconfig):
    """The run's seed, for tests that hand it to other processes."""
    return _seed(pytestconfig)


@pytest.fixture
def rng(request, seed):
    """NumPy generator of this test, from the run's seed and the test's name: their order is of no account."""
    print(f"rng: --seed {seed}")  # pytest shows it when the test fails
    return np.random.default_rng([seed, zlib.crc32(request.node.nodeid.encode())])


@pytest.fixture(scope="session")
def checkout():
    """Folder of the checkout the tests belong to."""
    return pathlib.Path(__file__).resolve().parent.parent


def _session_members(leader):
    """Processes of the session that `leader` opened: the ranks leave mpirun's process group, but not its session."""
    members = []
    for entry in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            fields = (entry / "stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue  # it has ended meanwhile
        if int(fields[3]) == leader and fields[0] != "Z":
            members.append(int(entry.name))
    return members


def _kill_session(process, grace=3.0):
    """End a process started with start_new_session and all its offspring: politely, then for good."""
    for sig, wait in ((signal.SIGTERM, grace), (signal.SIGKILL, grace)):
        for pid in _session_members(process.pid):
            try:
                os.kill(pid, sig)
            except ProcessLookupError:
                pass
        end = time.monotonic() + wait
        while _session_members(process.pid) and time.monotonic() < end:
            process.poll()
            time.sleep(0.05)
    process.wait()


def run_guarded(command, timeout, log, env=None, cwd=None):
    """Run a command with its output in the file `log`; returns (exit status or None after a timeout, output)."""
    with open(log, "wb") as out:
        process = subprocess.Popen(
            [str(c) for c in command],
            stdin=subprocess.DEVNULL,
            stdout=out,
            stderr=subprocess.STDOUT,
            env=env,
            cwd=cwd,
            start_new_session=True,
        )
        try:
            status = process.wait(timeout)
        except subprocess.TimeoutExpired:
            status = None
        finally:
            _kill_session(process)
    return status, pathlib.Path(log).read_text(errors="replace")


@pytest.fixture
def mpirun(tmp_path):
    """mpirun(n, script_or_code, *args, timeout=120, status=0, env=None, cwd=None) -> output of all ranks.

    Starts `mpirun -n N python3 -m mpi4py ...` (an exception on one rank ends them all). A path, or one line that ends
    in .py, is a script; any other text is code, which may be indented. Fails the test, with the output, on a timeout
    and on any other exit status than `status` (None: any). Nothing of the run outlives the call.
    """
    count = 0

    def run(n, script_or_code, *args, timeout=120, status=0, env=None, cwd=None):
        nonlocal count
        __tracebackhide__ = True
        count += 1
        text = str(script_or_code)
        is_script = isinstance(script_or_code, os.PathLike) or ("\n" not in text and text.endswith(".py"))
        what = [text] if is_script else ["-c", textwrap.dedent(text)]
        command = ["mpirun", "-n", n, sys.executable, "-m", "mpi4py", *what, *args]
        surroundings = {
            "OMPI_ALLOW_RUN_AS_ROOT": "1",
            "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
            "OMPI_MCA_rmaps_base_oversubscribe": "1",
            "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
            "OMP_NUM_THREADS": "1",
            **os.environ,
            **(env or {}),
        }
        found, output = run_guarded(command, timeout, tmp_path / f"mpirun-{count}.log", surroundings, cwd)
        if found is None:
            pytest.fail(f"{n} ranks did not finish within {timeout} s and were killed; their output:\n{output}")
        if status is not None and found != status:
            pytest.fail(f"{n} ranks ended with status {found}, expected {status}; their output:\n{output}")
        return output

    return run
