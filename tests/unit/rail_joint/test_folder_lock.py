# SPDX-License-Identifier: MIT
"""One run in a folder at a time, and children that end with their parent."""

import json
import os
import signal
import socket
import subprocess
import sys
import time

import pytest

from dolfinx_impact.common.end_with_parent import command_of
from dolfinx_impact.io.folder_lock import NAME, FolderLock, start_of
from dolfinx_impact.io.run_folder import RunFolder
from impact_studies.rail_joint import study

HOLD = """
import sys, time
from pathlib import Path
from dolfinx_impact.io.folder_lock import FolderLock
lock = FolderLock(Path(sys.argv[1]))
print("locked", flush=True)
time.sleep(60)
"""


@pytest.fixture
def holder(tmp_path):
    """Another process that has locked tmp_path."""
    with subprocess.Popen([sys.executable, "-c", HOLD, str(tmp_path)], stdout=subprocess.PIPE) as process:
        assert process.stdout.readline() == b"locked\n"
        yield process
        process.kill()


def test_a_locked_folder_names_its_owner(holder, tmp_path, capsys):
    with pytest.raises(RuntimeError, match=f"process {holder.pid} on {socket.gethostname()}"):
        FolderLock(tmp_path)
    before = sorted(os.listdir(tmp_path))
    with pytest.raises(RuntimeError, match="another run writes"):
        RunFolder(tmp_path, {"a": 1}, alone=True)
    assert sorted(os.listdir(tmp_path)) == before, "nothing was written beside the other run"
    assert study.main(["rail_joint", "--output", str(tmp_path)]) == 2
    assert f"process {holder.pid}" in capsys.readouterr().out
    holder.kill()
    holder.wait()
    FolderLock(tmp_path).release()


def test_a_lock_is_held_once_and_released(tmp_path):
    with RunFolder(tmp_path, alone=True):
        with pytest.raises(RuntimeError, match=f"process {os.getpid()} on"):
            FolderLock(tmp_path)
    assert not (tmp_path / NAME).exists()
    lock = FolderLock(tmp_path)
    del lock
    FolderLock(tmp_path).release()


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b'{"pid": "x"}'])
def test_a_lock_that_says_nothing_is_taken(content, tmp_path):
    (tmp_path / NAME).write_bytes(content)
    FolderLock(tmp_path).release()


@pytest.mark.parametrize("case", ["dead", "another with its number", "another machine", "alive"])
def test_owners_without_locks_of_the_kernel(case, tmp_path):
    """As on file systems that have none: the owner's process, start and machine tell."""
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as process:
        owner = {"pid": process.pid, "host": socket.gethostname(), "start": start_of(process.pid), "since": "today"}
        if case == "dead":
            process.communicate()
            assert start_of(process.pid) is None
        if case == "another with its number":
            owner["start"] = "1"
        if case == "another machine":
            owner["host"] = "elsewhere"
        (tmp_path / NAME).write_text(json.dumps(owner))
        if case in ("dead", "another with its number"):
            FolderLock(tmp_path).release()
        else:
            with pytest.raises(RuntimeError, match="elsewhere.*remove" if "machine" in case else "another run writes"):
                FolderLock(tmp_path)


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM, None])
def test_children_end_with_their_parent(how, tmp_path):
    """Killed, ended, or by an error: none is left."""
    file = tmp_path / "pid"
    grandchild = f"import os, time; open({str(file)!r}, 'w').write(str(os.getpid())); time.sleep(60)"
    code = (
        "import subprocess, sys, time\n"
        "from dolfinx_impact.common.end_with_parent import command_of\n"
        f"subprocess.Popen(command_of([sys.executable, '-c', {grandchild!r}]))\n"
        f"time.sleep({60 if how else 3})\n"
        "raise SystemExit(1)\n"
    )
    with subprocess.Popen([sys.executable, "-c", code]) as parent:
        deadline = time.monotonic() + 60.0
        while not (file.exists() and file.read_text()) and time.monotonic() < deadline:
            time.sleep(0.05)
        child = int(file.read_text())
        assert start_of(child) is not None
        if how:
            parent.send_signal(how)
    while start_of(child) is not None and time.monotonic() < deadline:
        time.sleep(0.05)
    assert start_of(child) is None


def test_a_child_has_the_status_of_its_command():
    assert subprocess.run(command_of([sys.executable, "-c", "raise SystemExit(7)"])).returncode == 7


def test_a_case_whose_folder_has_an_equals_sign(tmp_path, monkeypatch):
    """Its file of parameters is given by an option."""
    started = []
    monkeypatch.setattr(study.subprocess, "Popen", lambda command, **_: started.append(command))
    job = study.Job(study.RailJoint(), tmp_path / "a=b" / "c=d")
    job.start()
    (command,) = started
    arguments = command[command.index("joint") + 1 :]
    from impact_studies.rail_joint import joint_command

    given = joint_command.parser().parse_args(arguments)
    assert joint_command.parameters(given.values, given.parameters) == study.RailJoint()
