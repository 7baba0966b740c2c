# SPDX-License-Identifier: MIT
"""Processes that share the tests: every test is run once, modules stay whole, `alone` is alone, a dead process hides
nothing."""

import itertools
import os
import subprocess
import sys

import pytest

pytestmark = pytest.mark.waits

# Each test notes its process and when it began and ended.
MODULE = """
import os, pathlib, time
import pytest
LOG = pathlib.Path(__file__).with_name("log")

def note(name, start):
    with open(LOG, "a") as log:
        log.write(f"{name} {os.getpid()} {start} {time.monotonic()}\\n")

@pytest.fixture(scope="module")
def made_once():
    start = time.monotonic()
    yield
    note(f"fixture_{NUMBER}", start)

@pytest.mark.parametrize("k", range(3))
def test_it(made_once, k):
    start = time.monotonic()
    time.sleep(0.1)
    note(f"test_{NUMBER}_{k}", start)
    BODY
"""
ALONE = MODULE.replace("@pytest.mark.parametrize", "@pytest.mark.alone\n@pytest.mark.parametrize")
WAITS = MODULE.replace("import pytest\n", "import pytest\npytestmark = pytest.mark.waits\n")

# Both are there before the first test is taken.
CONFTEST = """
import os, pathlib, time
from conftest_of_tests import *  # noqa

def pytest_collection_finish(session):
    folder = pathlib.Path(__file__).parent
    (folder / f"started-{os.getpid()}").touch()
    while len(list(folder.glob("started-*"))) < int(os.environ["PROCESSES"]):
        time.sleep(0.01)
"""


@pytest.fixture
def suite(checkout, tmp_path):
    """A folder with the conftest of the tests and six modules: the third has tests that are alone, the fourth waits."""
    (tmp_path / "conftest.py").write_text(CONFTEST)
    (tmp_path / "conftest_of_tests.py").write_text((checkout / "tests" / "conftest.py").read_text())
    for number in range(6):
        text = {2: ALONE, 3: WAITS}.get(number, MODULE).replace("BODY", "pass").replace("NUMBER", str(number))
        (tmp_path / f"test_{number}.py").write_text(text)
    return tmp_path


def run(checkout, suite, processes, *arguments):
    """Run pytest in several processes at once: exit status and output of each."""
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--rootdir", suite, *arguments, suite]
    environment = {**os.environ, "PYTHONPATH": str(checkout / "tests"), "PROCESSES": str(processes)}
    options = dict(cwd=suite, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    running = [subprocess.Popen([str(c) for c in command], **options) for _ in range(processes)]
    outputs = [p.communicate(timeout=100)[0] for p in running]
    return [p.returncode for p in running], outputs


def log(suite):
    """name -> (process, start, end); a name that is there twice fails."""
    rows = [line.split() for line in (suite / "log").read_text().splitlines()]
    assert len({row[0] for row in rows}) == len(rows), rows
    return {name: (int(process), float(begin), float(end)) for name, process, begin, end in rows}


def of_modules(*numbers):
    return {f"test_{number}_{k}" for number in numbers for k in range(3)}


EVERY = of_modules(*range(6))


def names(found):
    return {name for name in found if name.startswith("test")}


def test_two_processes_share_the_tests(checkout, suite):
    status, outputs = run(checkout, suite, 2, "--share", suite / "share")
    assert status == [0, 0], outputs
    found = log(suite)
    assert names(found) == EVERY
    assert len({process for process, _, _ in found.values()}) == 2
    for number in range(6):  # whole modules: their fixtures are made once, and ended in time
        assert len({found[f"test_{number}_{k}"][0] for k in range(3)} | {found[f"fixture_{number}"][0]}) == 1
        assert found[f"fixture_{number}"][2] > max(found[f"test_{number}_{k}"][2] for k in range(3))
    waiting, alone = of_modules(3), of_modules(2)
    stages = EVERY - waiting - alone, waiting, alone
    for earlier, later in itertools.pairwise(stages):
        assert max(found[name][2] for name in earlier) <= min(found[name][1] for name in later)


def test_one_process_runs_all(checkout, suite):
    status, (output,) = run(checkout, suite, 1, "--share", suite / "share")
    assert status == [0] and "18 passed" in output
    assert names(log(suite)) == EVERY


def test_without_a_folder_nothing_is_shared(checkout, suite):
    status, outputs = run(checkout, suite, 2, "-k", "test_3 or test_4")
    assert status == [0, 0] and all("6 passed" in output for output in outputs)


def test_a_test_that_fails_makes_its_process_fail(checkout, suite):
    path = suite / "test_4.py"
    path.write_text(path.read_text().replace("    pass\n", "    assert k != 1, 'not one'\n"))
    status, outputs = run(checkout, suite, 2, "--share", suite / "share")
    assert sorted(status) == [0, 1] and sum("not one" in output for output in outputs) == 1
    assert names(log(suite)) == EVERY


def test_a_module_that_cannot_be_imported_makes_all_fail(checkout, suite):
    (suite / "test_5.py").write_text("import no_such_module\n")
    status, (output,) = run(checkout, suite, 1, "--share", suite / "share")
    assert status == [2] and "no_such_module" in output
    assert not (suite / "log").exists()


def test_a_process_that_dies_does_not_keep_the_other_waiting(checkout, suite):
    path = suite / "test_0.py"
    path.write_text(path.read_text().replace("    pass\n", "    os._exit(3)\n"))
    status, outputs = run(checkout, suite, 2, "--share", suite / "share")
    assert sorted(status) == [0, 3], outputs
    assert names(log(suite)) == EVERY - {"test_0_1", "test_0_2"}
