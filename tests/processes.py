# SPDX-License-Identifier: MIT
"""Processes that tests start: none outlives its time limit, and the ranks of mpirun end with it."""

import os
import pathlib
import signal
import subprocess
import time


def mpi_environment(**more):
    """Environment of mpirun: as root, with more ranks than cores; ranks that wait leave their core to the others."""
    return {
        "OMPI_ALLOW_RUN_AS_ROOT": "1",
        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
        "OMPI_MCA_rmaps_base_oversubscribe": "1",
        "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
        "OMPI_MCA_mpi_yield_when_idle": "1",
        "PRTE_MCA_hwloc_default_binding_policy": "none",
        "OMP_NUM_THREADS": "1",
        **os.environ,
        **more,
    }


def session_members(leader):
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


def kill_session(process, grace=3.0):
    """End a process started with start_new_session and all its offspring: politely, then for good."""
    for sig, wait in ((signal.SIGTERM, grace), (signal.SIGKILL, grace)):
        for pid in session_members(process.pid):
            try:
                os.kill(pid, sig)
            except ProcessLookupError:
                pass
        end = time.monotonic() + wait
        while session_members(process.pid) and time.monotonic() < end:
            process.poll()
            time.sleep(0.05)
    process.wait()


def start_session(command, out, env=None, cwd=None):
    """Start a command as the leader of a session of its own, without input, its output in the open file `out`."""
    return subprocess.Popen(
        [str(c) for c in command],
        stdin=subprocess.DEVNULL,
        stdout=out,
        stderr=subprocess.STDOUT,
        env=env,
        cwd=cwd,
        start_new_session=True,
    )


def run_guarded(command, timeout, log, env=None, cwd=None):
    """Run a command with its output in the file `log`; returns (exit status or None after a timeout, output)."""
    with open(log, "wb") as out:
        process = start_session(command, out, env, cwd)
        try:
            status = process.wait(timeout)
        except subprocess.TimeoutExpired:
            status = None
        finally:
            kill_session(process)
    return status, pathlib.Path(log).read_text(errors="replace")
