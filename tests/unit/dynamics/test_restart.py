# SPDX-License-Identifier: MIT
"""Checkpoints on ranks, across numbers of ranks, and under a process that is killed."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import restart_checks
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(
    restart_checks, ranks=(2, 3), timeout=300, in_make_test={"a_restored_run_is_the_uninterrupted_one": (2,)}
)
HERE = Path(__file__).parent
MODULES = os.pathsep.join((str(HERE), str(HERE.parents[1])))  # of checks and of all tests


SCRIPT = """
import sys
import numpy as np
from mpi4py import MPI
from restart_checks import block_on_block
mode, path = sys.argv[1:3]
problem = block_on_block()
end = 600 * problem.stable_step()
if mode == "write":
    problem.advance(end, callback=lambda p: p.save(path) if p.step == 333 else None, progress=False)
else:
    problem.restore(path)
    problem.advance(end, progress=False)
V = problem.space
n = V.dofmap.index_map.size_local
rows = [V.tabulate_dof_coordinates()[:n, :2]] + [
    f.x.array[: 2 * n].reshape(-1, 2) for f in (problem.u, problem.velocity, problem.acceleration)]
rows = np.vstack(MPI.COMM_WORLD.allgather(np.hstack(rows)))
if MPI.COMM_WORLD.rank == 0:
    # By place; nodes of the two bodies that lie there by displacement.
    keys = [rows[:, 2].round(6), *rows[:, :2].round(9).T]
    np.save(sys.argv[3], rows[np.lexsort(keys)])
"""


@pytest.mark.mpi
@pytest.mark.parametrize("counts", [(1,), pytest.param((1, 3), marks=pytest.mark.slow)])
def test_a_run_goes_on_on_other_ranks(counts, mpirun, tmp_path):
    """To 1e-10 of the largest entry, 267 steps later."""

    def run(mode, ranks):
        """Result by place of a run that writes a checkpoint, or goes on from it."""
        out = tmp_path / f"{mode}{ranks}.npy"
        mpirun(ranks, SCRIPT, mode, tmp_path / "checkpoint.h5", out, timeout=300, env={"PYTHONPATH": MODULES})
        return np.load(out)[:, 2:]

    whole = run("write", 2)
    for ranks in counts:
        again = run("read", ranks)
        for columns in np.split(np.arange(6), 3):
            scale = np.abs(whole[:, columns]).max()
            np.testing.assert_allclose(again[:, columns], whole[:, columns], rtol=0, atol=1e-10 * scale)


KILLED = """
import sys
from restart_checks import block_on_block
problem = block_on_block()
try:
    problem.restore(sys.argv[1])
except RuntimeError:
    pass
print("ready", flush=True)
end = 1e6 * problem.stable_step()
problem.advance(end, callback=lambda p: p.save(sys.argv[1]), progress=False)
"""


@pytest.mark.long_rows(where=lambda number: number >= 2)
@pytest.mark.parametrize("number", range(20))
def test_killed_at_any_moment_the_last_checkpoint_opens(number, tmp_path_factory):
    """SIGKILL while a checkpoint is written at every step: the last one opens, and the run goes on from there."""
    folder = tmp_path_factory.getbasetemp() / "killed"
    folder.mkdir(exist_ok=True)
    path, script = folder / "checkpoint.h5", folder / "script.py"
    script.write_text(KILLED)
    environment = {**os.environ, "PYTHONPATH": MODULES}
    process = subprocess.Popen(
        [sys.executable, str(script), str(path)], env=environment, stdout=subprocess.PIPE, text=True
    )  # fmt: skip
    assert process.stdout.readline().strip() == "ready"
    time.sleep(0.05 + 0.2 * random.Random(number).random())
    process.send_signal(signal.SIGKILL)
    process.wait(30)
    process.stdout.close()
    problem = restart_checks.block_on_block()
    problem.restore(path)
    assert problem.step > 0 and np.all(np.isfinite(problem.u.x.array))
    step = problem.step
    problem.advance(problem.time + 3 * problem.stable_step(), progress=False)
    assert problem.step > step


HALF_WRITTEN = """
import os, resource, signal, sys
from pathlib import Path
sys.path[:0] = sys.argv[3].split(os.pathsep)
from mpi4py import MPI
from restart_checks import block_on_block, state
comm, path, case = MPI.COMM_WORLD, Path(sys.argv[1]), sys.argv[2]
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
problem = block_on_block()
problem.advance(20 * problem.stable_step(), progress=False)
problem.save(path / "good.h5")
there, good, step = (path / "good.h5").read_bytes(), state(problem), problem.step
problem.advance(problem.time + 20 * problem.stable_step(), progress=False)
soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)

def failure():
    # What all ranks say of a save that must fail; it leaves nothing behind, and the file that was there.
    try:
        problem.save(path / "good.h5")
        said = "nothing"
    except RuntimeError as error:
        said = str(error)
    resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    everyone = comm.allgather(said)
    assert len(set(everyone)) == 1 and "could not be written" in said, everyone
    assert os.listdir(path) == ["good.h5"] and (path / "good.h5").read_bytes() == there
    comm.barrier()
    return said

os.environ["FULL_DISK"] = "1"  # what free space there is is looked at before anything is written
assert "no space left" in failure()
del os.environ["FULL_DISK"]
if case == "unreserved":  # a file system that cannot reserve: the write itself fails, in the middle
    os.environ["UNRESERVED"] = "1"
for part in (0.0, 0.1, 0.5, 0.8 if case == "last rank" else 0.99):  # the seal at the end is rank 0's
    if case != "last rank" or comm.rank == comm.size - 1:
        resource.setrlimit(resource.RLIMIT_FSIZE, (int(part * len(there)), hard))
    said = failure()
    assert "File too large" in said, said
again = block_on_block()
again.restore(path / "good.h5")
assert again.step == step and (state(again) == good).all()
problem.save(path / "good.h5")
again.restore(path / "good.h5")
assert again.step == problem.step and (state(again) == state(problem)).all()
print("went on", flush=True)
"""


@pytest.mark.mpi
@pytest.mark.long_rows(where=lambda case, ranks: (case, ranks) != ("last rank", 2))
@pytest.mark.parametrize("case", ("all", "last rank", "unreserved"))
@pytest.mark.parametrize("ranks", (1, 2))
def test_a_write_that_fails_in_the_middle(ranks, case, mpirun, tmp_path):
    """A full disk, and beyond a limit of the file's size: the same error on all ranks, nothing is left behind, the
    checkpoint that was there opens, and the process goes on and writes the next one."""
    folder, disk = tmp_path / "run", tmp_path / "disk.so"
    folder.mkdir()
    compiler = os.environ.get("CXX", "c++").split()
    subprocess.run([*compiler, "-shared", "-fPIC", "-o", disk, HERE.parent / "io" / "disk.cpp", "-ldl"], check=True)
    output = mpirun(ranks, HALF_WRITTEN, folder, case, MODULES, env={"LD_PRELOAD": str(disk)})
    assert output.count("went on") == ranks
