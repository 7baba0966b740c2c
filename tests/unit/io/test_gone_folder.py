# SPDX-License-Identifier: MIT
"""Recorders that nobody closes, and folders that vanish under them: a process ends with the status that it would have
had, never by what a destructor of ADIOS2 throws."""

import os
from pathlib import Path

import pytest

HERE = Path(__file__).parent
MODULES = os.pathsep.join((str(HERE.parent / "dynamics"), str(HERE.parents[1])))  # of checks and of all tests

RECORD = """
import gc, os, shutil, sys
from pathlib import Path
sys.path[:0] = sys.argv[3].split(os.pathsep)
from mpi4py import MPI
from restart_checks import block_on_block
comm, folder, end = MPI.COMM_WORLD, Path(sys.argv[1]), sys.argv[2]

def recorded(name, removed):
    problem = block_on_block()
    recorder = problem.record(folder / name, every=10)
    problem.advance(20 * 0.9 * problem.stable_step(), progress=False)
    comm.barrier()
    if removed and comm.rank == 0:
        shutil.rmtree(folder / name)
    comm.barrier()
    return problem, recorder

for removed in (True, False):  # collected by one rank after the other
    lost = recorded(f"collected {removed}", removed)
    for rank in range(comm.size):
        if comm.rank == rank:
            del lost
            gc.collect()
        comm.barrier()
kept = recorded("left", False), recorded("removed", True)
print("reached the end", flush=True)
if end == "error":
    raise ValueError("an error of the user's own")
"""


@pytest.mark.mpi
@pytest.mark.long_rows(where=lambda ranks, end: (ranks == 1) != (end == "error"))
@pytest.mark.parametrize("end", ("", "error"))
@pytest.mark.parametrize("ranks", (1, 2))
def test_the_status_is_that_of_the_script(ranks, end, mpirun, tmp_path):
    output = mpirun(ranks, RECORD, tmp_path, end, MODULES, timeout=120, status=1 if end else 0)
    assert output.count("reached the end") == ranks
    assert ("an error of the user's own" in output) == bool(end)
    assert "terminate called" not in output and "signal" not in output.replace("terminated by signals sent", "")
    if not end:
        assert closed(tmp_path / "left" / "fields.bp")
        assert closed(tmp_path / "collected False" / "fields.bp") == (ranks == 1)  # several ranks would have to wait


def closed(series):
    """What ADIOS2 notes in the 38th byte of the index: 1 while it writes."""
    return (series / "md.idx").read_bytes()[38] == 0
