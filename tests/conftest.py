# SPDX-License-Identifier: MIT
"""Shared by all tests: one printed seed, guarded ranks, hypothesis without chance, a time limit on every test."""

import os
import pathlib
import signal
import sys
import textwrap
import zlib

import helper_folders
import numpy as np
import pytest
import rows
import sharing
from processes import mpi_environment, run_guarded
from rank_group import RankFailure, RankGroup

try:
    import hypothesis
except ImportError:  # the tests that use it say so themselves
    hypothesis = None
else:
    hypothesis.settings.register_profile("ci", derandomize=True, deadline=None, database=None, print_blob=True)
    hypothesis.settings.register_profile("explore", deadline=None, max_examples=1000, print_blob=True)
    hypothesis.settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "ci"))

helper_folders.put_on_path()

DEFAULT_SEED = 20250
TEST_TIMEOUT = 600  # seconds, for tests that name none of their own

# Whatever starts ranks: those that wait for each other leave their core to other processes.
os.environ.setdefault("OMPI_MCA_mpi_yield_when_idle", "1")


def pytest_addoption(parser):
    parser.addoption("--seed", type=int, default=None, help="seed of the rng fixture (also IMPACT_SEED)")
    parser.addoption("--share", metavar="FOLDER", help="share the tests with other processes; see sharing.py")


def _seed(config):
    given = config.getoption("--seed")
    return int(os.environ.get("IMPACT_SEED", DEFAULT_SEED)) if given is None else given


def pytest_report_header(config):
    return f"seed: {_seed(config)} (repeat or change with --seed N or IMPACT_SEED=N)"


def _ranks(item):
    """The number of ranks that a test is for, its parameter `ranks`; None: it does not say."""
    return item.callspec.params.get("ranks") if hasattr(item, "callspec") else None


def _ranks_of_group(item):
    """Tests on the ranks of a group come last, those on as many ranks together: a group is started once."""
    return _ranks(item) if "rank_group" in item.fixturenames else 0


@pytest.hookimpl(tryfirst=True)  # before -m selects by markers
def pytest_collection_modifyitems(config, items):
    for item in items:
        if {"rank_group", "mpirun"} & set(item.fixturenames):
            item.add_marker(pytest.mark.mpi)
    for item in [*rows.long_rows(items), *rows.beyond_covering(items)]:
        item.add_marker(pytest.mark.slow)
    items.sort(key=_ranks_of_group)  # the sort is stable: else the order stays
    if config.pluginmanager.hasplugin("timeout"):
        for item in items:
            if item.get_closest_marker("timeout") is None:
                item.add_marker(pytest.mark.timeout(TEST_TIMEOUT))


def pytest_runtestloop(session):
    folder = session.config.getoption("--share")
    if folder is None or session.testsfailed or session.config.option.collectonly:
        return None  # pytest's own loop
    sharing.run(session, folder)
    return True


@pytest.fixture(scope="session")
def seed(pytestconfig):
    """The run's seed, for tests that hand it to other processes."""
    return _seed(pytestconfig)


@pytest.fixture
def rng(request, seed):
    """NumPy generator of this test, from the run's seed and the test's name: their order is of no account."""
    print(f"rng: --seed {seed}")  # pytest shows it when the test fails
    return np.random.default_rng([seed, zlib.crc32(request.node.nodeid.encode())])


@pytest.fixture
def contacts_in_python(monkeypatch):
    """Newton's method calls the methods of contacts in Python, where a test may have replaced them."""
    from dolfinx_impact import _cpp
    from dolfinx_impact.contact import in_cpp

    monkeypatch.setattr(in_cpp, "contact_in_cpp", _cpp.solve.PythonContact)


@pytest.fixture(autouse=True)
def handler_of_interrupts():
    """A test leaves the handler of SIGINT as it was. gmsh.initialize() gives the signal its default action, with which
    a later test of Ctrl-C would end the process."""
    before = signal.getsignal(signal.SIGINT)
    yield
    after = signal.signal(signal.SIGINT, before)
    assert after == before, f"the handler of SIGINT is {after} after the test"


@pytest.fixture(scope="session")
def checkout():
    """Folder of the checkout the tests belong to."""
    return pathlib.Path(__file__).resolve().parent.parent


def _is_script(script_or_code):
    """A path, or one line that ends in .py; anything else is code."""
    text = str(script_or_code)
    return isinstance(script_or_code, os.PathLike) or ("\n" not in text and text.endswith(".py"))


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
        what = [text] if _is_script(script_or_code) else ["-c", textwrap.dedent(text)]
        command = ["mpirun", "-n", n, sys.executable, "-m", "mpi4py", *what, *args]
        surroundings = mpi_environment(**(env or {}))
        found, output = run_guarded(command, timeout, tmp_path / f"mpirun-{count}.log", surroundings, cwd)
        if found is None:
            pytest.fail(f"{n} ranks did not finish within {timeout} s and were killed; their output:\n{output}")
        if status is not None and found != status:
            pytest.fail(f"{n} ranks ended with status {found}, expected {status}; their output:\n{output}")
        return output

    return run


@pytest.fixture(scope="session")
def rank_group():
    """rank_group(size, timeout, **request) -> what each rank printed; the request is that of rank_process.py.

    The ranks are started for the first request and stay; a request to another number of ranks ends them. Fails the
    test with what the ranks raised, on a lack of replies after `timeout` seconds, and where ranks that are ended do
    not do so with status 0.
    """
    group = RankGroup(1)

    def end():
        status = group.close()
        if status != 0:
            pytest.fail(f"after all their tests {group.size} ranks ended with status {status}", pytrace=False)

    def run(size, timeout, **request):
        nonlocal group
        __tracebackhide__ = True
        if size != group.size:
            end()
            group = RankGroup(size)
        try:
            return group.call(timeout, **request)
        except RankFailure as failure:
            pytest.fail(str(failure), pytrace=False)

    yield run
    end()


@pytest.fixture
def script_on_ranks(rank_group, tmp_path):
    """script_on_ranks(n, script_or_code, *args, timeout=120) -> output of all ranks.

    As `mpirun`, on ranks that other tests use as well: for scripts that leave the process as it was.
    """

    def run(n, script_or_code, *args, timeout=120):
        __tracebackhide__ = True
        script = pathlib.Path(str(script_or_code))
        if not _is_script(script_or_code):
            script = tmp_path / "script_on_ranks.py"
            script.write_text(textwrap.dedent(script_or_code))
        return "".join(rank_group(n, timeout, script=str(script), arguments=[str(a) for a in args]))

    return run
