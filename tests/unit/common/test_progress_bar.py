# SPDX-License-Identifier: MIT
"""Progress: a bar on a terminal, lines in a file, also under mpirun; nothing where the log's level is above WARNING."""

import os
import subprocess
import sys
import threading

import pytest
from dolfinx import log
from mpi4py import MPI
from processes import mpi_environment

from dolfinx_impact.common import progress_lines
from dolfinx_impact.common.progress_bar import ProgressBar, transient_bar
from dolfinx_impact.common.terminal import console

SCRIPT = """
import time
from mpi4py import MPI
from dolfinx_impact.common import progress_lines
from dolfinx_impact.common.progress_bar import ProgressBar

progress_lines.FIRST = 0.2
with ProgressBar(MPI.COMM_WORLD, True, 40, "begins") as bar:
    for step in range(41):
        bar.show(step, lambda: f"step {step}", lambda: "after")
        time.sleep(0.02)
"""


def output(command, terminal):
    """What a command writes on its standard output, which is a terminal or a pipe."""
    ours, theirs = os.openpty() if terminal else os.pipe()
    written = []

    def read():
        try:
            while part := os.read(ours, 4096):
                written.append(part)
        except OSError:  # the other end of a terminal was closed
            pass

    reader = threading.Thread(target=read)
    with subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=theirs, env=mpi_environment(TERM="xterm"), start_new_session=True
    ) as process:
        os.close(theirs)
        reader.start()
        assert process.wait(100) == 0
    reader.join(20)
    os.close(ours)
    return b"".join(written).decode()


@pytest.mark.mpi
@pytest.mark.parametrize("wrapped", (False, True), ids=["", "in a shell"])
@pytest.mark.parametrize("ranks", (0, 1, 2), ids=["no mpirun", "1 rank", "2 ranks"])
@pytest.mark.parametrize("terminal", (False, True), ids=["file", "terminal"])
def test_a_bar_is_only_on_a_terminal(terminal, ranks, wrapped):
    """Open MPI's rank 0 has a terminal in every case but "no mpirun" into a file."""
    command = [sys.executable, "-c", SCRIPT]
    if wrapped:
        command = ["sh", "-c", '"$0" "$@"; exit $?', *command]
    text = output((["mpirun", "-n", str(ranks)] if ranks else []) + command, terminal)
    if terminal:
        assert "━" in text and "step 40" in text and "\x1b[" in text
    else:
        lines = text.splitlines()
        assert 2 <= len(lines) < 12 and "━" not in text and "\x1b" not in text
        assert all("%: step " in line and line.endswith(", after, 0 s") or line.endswith("1 s") for line in lines)


@pytest.fixture
def level():
    """Function that sets the level of DOLFINx's log; it is set back in the end."""
    before = log.get_log_level()
    yield log.set_log_level
    log.set_log_level(before)


@pytest.mark.parametrize("name, shown", (("INFO", True), ("WARNING", True), ("ERROR", False), ("OFF", False)))
def test_the_level_of_the_log_is_obeyed(name, shown, level, monkeypatch, capsys):
    monkeypatch.setattr(progress_lines, "FIRST", 0.0)
    level(getattr(log.LogLevel, name))
    with ProgressBar(MPI.COMM_SELF, True, 4, counted=True) as bar:
        bar.show(1, lambda: "creep 0.1")
    assert capsys.readouterr().out == ("1 of 4: creep 0.1, 0 s\n" if shown else "")
    with transient_bar(True) as bar:
        bar.update(bar.add_task("work", total=2), advance=1)
        assert bar.disable == (not shown)
    assert capsys.readouterr().out == "", "a file gets nothing, not even an empty line"


def test_lines_become_rare():
    """The first after five seconds, each later by 1.3 times the last pause, at most a minute."""
    time = 0.0
    lines, due = progress_lines.ProgressLines(lambda: time), []
    for half_second in range(2000):
        time = 0.5 * half_second
        if (seconds := lines.due()) is not None:
            due.append(seconds)
    assert due[:4] == [5.0, 11.5, 20.0, 31.0] and due[-1] - due[-2] == 60.0


def test_texts_are_made_only_where_they_are_shown():
    def unwanted():
        raise AssertionError("a text is made for nothing")

    with ProgressBar(MPI.COMM_SELF, False, 4) as silent, ProgressBar(MPI.COMM_SELF, True, 4) as early:
        silent.show(1, unwanted)
        early.show(1, unwanted)  # five seconds have not passed


def test_no_work_is_all_of_it(monkeypatch, capsys):
    monkeypatch.setattr(progress_lines, "FIRST", 0.0)
    with ProgressBar(MPI.COMM_SELF, True, 0.0) as bar:
        bar.show(0.0, lambda: "done")
    assert capsys.readouterr().out == "100%: done, 0 s\n"


def test_output_without_a_file_is_no_terminal(capsys):
    assert not console().is_terminal and not console(stderr=True).is_terminal
