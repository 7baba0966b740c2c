# SPDX-License-Identifier: MIT
"""Recorders and results where no room is left: the same error on all ranks, files that can be read, a clean end."""

import os
import subprocess
from pathlib import Path

import pytest

HERE = Path(__file__).parent
MODULES = os.pathsep.join((str(HERE.parent / "dynamics"), str(HERE.parents[1])))  # of checks and of all tests

RECORD = """
import os, resource, signal, sys
from pathlib import Path
sys.path[:0] = sys.argv[3].split(os.pathsep)
import h5py
import numpy as np
from mpi4py import MPI
from restart_checks import block_on_block
import dolfinx_impact as di
from dolfinx_impact.dynamics import recorder as module
comm, folder, case = MPI.COMM_WORLD, Path(sys.argv[1]), sys.argv[2]
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
module.INTERVAL = 0.0
soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
problem = block_on_block()
dt = 0.9 * problem.stable_step()
fields = () if case == "histories" else ("displacement", "velocity")
recorder = problem.record(folder / "run", every=10, fields=fields, points=[[0.5, 0.0]], points_every=5)
problem.advance(100 * dt, progress=False)

def rows():
    comm.barrier()
    with h5py.File(folder / "run" / "history.h5", "r") as file:
        found = [len(file[name]) for name in ("time", "kinetic", "force_0", "points/time")]
        times = file["time"][:]
    comm.barrier()
    assert found[0] == found[1] == found[2] and np.all(np.diff(times) > 0)
    return found

before = rows()
assert before[0] == problem.step
if case == "disk":  # a small one of its own
    if comm.rank == 0:
        with open(folder / "fill", "wb") as file:
            try:
                while file.write(b"x" * 4096):
                    file.flush()
            except OSError:
                pass
elif case == "histories":
    resource.setrlimit(resource.RLIMIT_FSIZE, (os.path.getsize(folder / "run" / "history.h5") + 5000, hard))
else:
    largest = max(f.stat().st_size for f in (folder / "run" / "fields.bp").iterdir())
    resource.setrlimit(resource.RLIMIT_FSIZE, (largest + 100000, hard))
comm.barrier()

def told(work):
    try:
        work()
        text = "nothing"
    except RuntimeError as error:
        text = str(error)
    everyone = comm.allgather(text)
    assert len(set(everyone)) == 1, everyone
    return text

text = told(lambda: problem.advance(5000 * dt, progress=False))
assert "cannot be written" in text and str(folder / "run") in text and "make room" in text, text
step = problem.step
assert 100 <= step < 5000 and len(problem.energy_history) == step
assert np.array_equal(problem.u.x.array[: problem.num_owned], problem._cpp_object.integrator.displacement())
there = rows()
assert before[0] <= there[0] <= step
if case == "histories":
    assert there[0] < step
if len(sys.argv) > 4:  # never any room: the end is clean all the same
    print("left", told(recorder.close) if case != "fields" else recorder.close(), flush=True)
    sys.exit(0)
resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
if comm.rank == 0:
    (folder / "fill").unlink(missing_ok=True)
comm.barrier()
problem.advance((step + 50) * dt, progress=False)
recorder.close()
assert rows()[0] == problem.step  # nothing is missing
if comm.rank == 0:
    assert not [f for f in (folder / "run").iterdir() if f.name.endswith((".room", ".part"))]
print("went on", flush=True)
"""


@pytest.mark.mpi
@pytest.mark.long_rows(where=lambda case, room, ranks: (ranks == 1) == room or case == "histories")
@pytest.mark.parametrize(
    "case, room",
    [("histories", True), ("fields", True), ("fields", False)],
    ids=["histories, room again", "fields, room again", "fields, no room"],
)
@pytest.mark.parametrize("ranks", (1, 2))
def test_beyond_a_limit_of_file_sizes(ranks, case, room, mpirun, tmp_path):
    output = mpirun(ranks, RECORD, tmp_path, case, MODULES, *([] if room else ["stay"]), timeout=200)
    assert output.count("went on" if room else "left") == ranks
    assert "terminate" not in output and "Abort" not in output


@pytest.mark.mpi
@pytest.mark.long_rows(where=lambda room, ranks: (ranks, room) != (2, True))
@pytest.mark.parametrize("room", (True, False), ids=["room again", "no room"])
@pytest.mark.parametrize("ranks", (1, 2))
def test_a_disk_that_is_full(ranks, room, mpirun, tmp_path):
    """A small file system of its own, where the process may mount one."""
    disk = tmp_path / "disk"
    disk.mkdir()
    if os.geteuid() != 0 or subprocess.run(["mount", "-t", "tmpfs", "-o", "size=4m", "tmpfs", disk]).returncode:
        pytest.skip("only root may mount a disk")
    try:
        output = mpirun(ranks, RECORD, disk, "disk", MODULES, *([] if room else ["stay"]), timeout=200)
        assert output.count("went on" if room else "left") == ranks and "terminate" not in output
    finally:
        subprocess.run(["umount", "-l", disk], check=True)


TABLES = """
import resource, signal, sys
from pathlib import Path
import numpy as np
from dolfinx import fem, mesh
from mpi4py import MPI
from dolfinx_impact.io.run_folder import RunFolder
comm, folder = MPI.COMM_WORLD, Path(sys.argv[1])
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
run = RunFolder(folder / "run", comm=comm)
run.table("line", {"z": (np.arange(3.0), "m")})
u = fem.Function(fem.functionspace(mesh.create_unit_square(comm, 30, 30), ("Lagrange", 1, (2,))), name="u")
before = {f.name: f.read_bytes() for f in (folder / "run").iterdir()}
comm.barrier()
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, resource.getrlimit(resource.RLIMIT_FSIZE)[1]))
for work in (lambda: run.table("line", {"z": (np.arange(3000.0), "m")}), lambda: run.fields("u", [u])):
    try:
        work()
        raise SystemExit("nothing was said")
    except RuntimeError as error:
        everyone = comm.allgather(str(error))
        assert len(set(everyone)) == 1 and "cannot be written" in everyone[0], everyone
    comm.barrier()
    now = {f.name: f.read_bytes() for f in (folder / "run").iterdir() if f.is_file()}
    assert now == before, sorted(now)
print("clean", flush=True)
"""


@pytest.mark.mpi
@pytest.mark.long_rows(where=lambda ranks: ranks == 1)
@pytest.mark.parametrize("ranks", (1, 2))
def test_tables_and_fields(ranks, mpirun, tmp_path):
    """What was there stays as it was."""
    assert mpirun(ranks, TABLES, tmp_path).count("clean") == ranks
