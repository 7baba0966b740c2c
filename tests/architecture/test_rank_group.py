# SPDX-License-Identifier: MIT
"""Checks that share one mpirun: each has a result of its own, and what fails, hangs or exits hides no other."""

import os
import subprocess
import sys
import textwrap

import pytest
import rank_group
from processes import session_members
from rank_group import RankFailure, RankGroup

CHECKS = """
import os, sys, time
from mpi4py import MPI
COMM = MPI.COMM_WORLD

def check_passes():
    assert COMM.allreduce(1) == COMM.size

def check_fails():
    assert COMM.size == 7, "not seven"

def check_raises_on_one_rank():
    if COMM.rank == 1:
        raise ValueError("only here")

def check_raises_before_the_others_wait():
    if COMM.rank == 1:
        raise ValueError("before the barrier")
    COMM.barrier()

def check_hangs():
    print("so far", flush=True)
    if COMM.rank == 0:
        COMM.barrier()
    time.sleep(1000)

def check_exits():
    if COMM.rank == 1:
        os._exit(3)
    COMM.barrier()

def check_calls_exit():
    sys.exit(0)

def check_aborts():
    if COMM.rank == 0:
        COMM.Abort(5)
    COMM.barrier()

def check_parts_are_others():
    from dolfinx import mesh
    topologies = [mesh.create_unit_square(COMM, 3, 2).topology for _ in range(3)]
    first, second, third = (set(t.original_cell_index[: t.index_map(2).size_local].tolist()) for t in topologies)
    assert first and second and first.isdisjoint(second) and first == third
"""


@pytest.fixture
def module(tmp_path):
    path = tmp_path / f"checks_in_{tmp_path.name}.py"
    path.write_text(CHECKS)
    return str(path)


@pytest.fixture
def group():
    group = RankGroup(2)
    group.grace = 1.0
    yield group
    leader = group._process.pid if group._process else None
    group.kill()
    assert leader is None or not session_members(leader)


def perform(group, module, *names, timeout=60):
    """What each check came to, by name: None, or the text of its failure."""
    found = {}
    for name in names:
        try:
            assert group.call(timeout, module=module, check=f"check_{name}") == ["", ""]
            found[name] = None
        except RankFailure as failure:
            found[name] = str(failure)
    return found


def test_one_start_serves_many_checks(group, module):
    assert set(perform(group, module, *["passes"] * 20).values()) == {None} and group.starts == 1
    assert group.close() == 0


def test_the_same_mesh_is_partitioned_otherwise_each_time(group, module):
    """Of two ranks in turn: a check that compares arrays of two meshes is wrong, and does not pass by chance."""
    assert perform(group, module, "parts_are_others") == {"parts_are_others": None}


@pytest.mark.long_rows(where=lambda name: name in ("fails", "calls_exit", "exits", "raises_before_the_others_wait"))
@pytest.mark.parametrize(
    "name, words",
    [
        ("fails", ("rank 0: Traceback", "rank 1: Traceback", "AssertionError: not seven", "in check_fails")),
        ("raises_on_one_rank", ("ValueError: only here",)),
        ("raises_before_the_others_wait", ("ValueError: before the barrier", "rank 0: still ran 1 s after another")),
        ("exits", ("rank 1: ended",)),
        ("calls_exit", ("rank 0: Traceback", "SystemExit: 0")),
        ("aborts", ("rank 0: ended", "MPI_ABORT")),
        ("is_not_there", ("AttributeError", "check_is_not_there")),
    ],
)
def test_a_check_that_fails_hides_no_other(group, module, name, words):
    found = perform(group, module, "passes", name, "passes")
    assert found["passes"] is None and group.starts == 2
    assert all(word in found[name] for word in words), found[name]


def test_only_ranks_that_failed_are_told(group, module):
    (text,) = perform(group, module, "raises_on_one_rank").values()
    assert text.startswith("rank 1: Traceback") and "rank 0" not in text


@pytest.mark.alone
def test_a_check_that_hangs_ends_by_its_own_time_limit(group, module):
    """It tells where it hung and what it had printed; the next one runs on new ranks."""
    (text,) = perform(group, module, "hangs", timeout=3).values()
    assert "rank 0: did not finish within 3 s" in text and "rank 1: did not finish within 3 s" in text
    assert "so far" in text and "in check_hangs" in text
    assert perform(group, module, "passes") == {"passes": None} and group.starts == 2


def test_after_an_interrupt_no_reply_is_taken_for_another(group, module, monkeypatch):
    def interrupted(timeout):
        raise KeyboardInterrupt

    assert perform(group, module, "passes") == {"passes": None}
    with monkeypatch.context() as patch:
        patch.setattr(group, "_replies", interrupted)
        with pytest.raises(KeyboardInterrupt):
            group.call(60, module=module, check="check_fails")
    assert perform(group, module, "passes") == {"passes": None} and group.starts == 2


def test_ranks_that_end_with_another_status_are_noticed(group, tmp_path):
    script = tmp_path / "script.py"
    script.write_text("import atexit, os, sys\natexit.register(lambda: os._exit(4))\nprint(sys.argv[1:])\n")
    assert group.call(60, script=str(script), arguments=["a b"]) == ["['a b']\n"] * 2
    assert group.close() == 4


def test_ranks_that_cannot_be_started(group, monkeypatch):
    monkeypatch.setattr(rank_group.sys, "executable", "/bin/false")
    with pytest.raises(RankFailure, match="2 ranks could not be started"):
        group.call(10, module="none.py", check="check_nothing")


def test_every_check_on_every_number_of_ranks_is_a_test(module, checkout, tmp_path):
    """By name, and one of them alone with -k; those on as many ranks run one after the other."""
    name = os.path.splitext(os.path.basename(module))[0]
    (tmp_path / "conftest.py").write_text("from conftest_of_tests import *  # noqa\n")
    (tmp_path / "conftest_of_tests.py").write_text((checkout / "tests" / "conftest.py").read_text())
    test = f"""
        import {name}
        from on_ranks import rank_tests
        test_one_rank, test_several_ranks = rank_tests({name}, ranks=(2, 3), timeout=30)
    """
    (tmp_path / "test_them.py").write_text(textwrap.dedent(test))

    def outcomes(keyword):
        command = [sys.executable, "-m", "pytest", "-v", "-p", "no:cacheprovider", "--rootdir", tmp_path, tmp_path]
        environment = {**os.environ, "PYTHONPATH": str(checkout / "tests")}
        done = subprocess.run(
            [*command, "-k", keyword], env=environment, cwd=tmp_path, capture_output=True, text=True, timeout=200
        )
        lines = [line.split()[:2] for line in done.stdout.splitlines() if line.startswith("test_them.py::")]
        return [(test.partition("::")[2], outcome) for test, outcome in lines], done.stdout

    found, _ = outcomes("passes")
    assert found == [(f"test_{t}", "PASSED") for t in
                     ("one_rank[passes]", "several_ranks[2-passes]", "several_ranks[3-passes]")]  # fmt: skip
    found, text = outcomes("several and 2- and (passes or fails or one_rank)")
    assert dict(found) == {
        "test_several_ranks[2-passes]": "PASSED",
        "test_several_ranks[2-fails]": "FAILED",
        "test_several_ranks[2-raises_on_one_rank]": "FAILED",
    }
    assert "ValueError: only here" in text
