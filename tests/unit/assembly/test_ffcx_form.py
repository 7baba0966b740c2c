# SPDX-License-Identifier: MIT
"""Kernels of DOLFINx's own cache after processes that were killed while they compiled."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest

pytestmark = pytest.mark.waits

# Each process compiles one form of its own; FFCx waits for a second instead of ten.
SCRIPT = """
import sys
from mpi4py import MPI
import ufl
from dolfinx import fem, mesh
from dolfinx_impact.assembly import ffcx_form
ffcx_form.GRACE, ffcx_form.PATIENCE = {grace}, 3.0
domain = mesh.create_unit_square(MPI.COMM_WORLD, 2, 2)
x = ufl.SpatialCoordinate(domain)
print(round(domain.comm.allreduce(fem.assemble_scalar(ffcx_form.ffcx_form(x[0] ** 3 * ufl.dx))), 12))
"""
# A stand-in for the compiler that never ends, so that a kill is sure to meet it.
SLOW = "#!/bin/sh\nexec sleep 30 >/dev/null 2>&1\n"


@pytest.fixture
def run(tmp_path):
    """Starts a process in a folder and a cache of the test's own."""
    (tmp_path / "dolfinx_jit_options.json").write_text(json.dumps({"timeout": 1}))
    slow = tmp_path / "cc"
    slow.write_text(SLOW)
    slow.chmod(0o755)
    started = []

    def start(grace=0.0, stuck=False):
        env = os.environ | {"XDG_CACHE_HOME": str(tmp_path / "cache")} | ({"CC": str(slow)} if stuck else {})
        command = [sys.executable, "-c", SCRIPT.format(grace=grace)]
        process = subprocess.Popen(
            command, cwd=tmp_path, env=env, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),  # ignored in the background
        )  # fmt: skip
        started.append(process)
        return process

    yield start
    for process in started:
        process.kill()
        process.communicate()


def _wait_for_file(tmp_path, process):
    """The C file of a process that compiles."""
    end = time.monotonic() + 60.0
    while time.monotonic() < end and process.poll() is None:
        files = [p for p in (tmp_path / "cache" / "fenics").glob("*.c") if p.stat().st_size > 0]
        if files:
            return files[0]
        time.sleep(0.05)
    raise AssertionError(f"nothing is compiled: {process.communicate()}")


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT])
def test_what_a_killed_process_leaves_is_compiled_again(tmp_path, run, how):
    killed = run(stuck=True)
    left = _wait_for_file(tmp_path, killed)
    killed.send_signal(how)
    killed.communicate()
    assert left.exists() and not left.with_suffix(".c.cached").exists()
    for _ in range(2):
        out, err = run().communicate()
        assert out == "0.25\n", err
    assert left.with_suffix(".c.cached").exists()


def test_on_two_ranks(tmp_path, run, mpirun):
    killed = run(stuck=True)
    left = _wait_for_file(tmp_path, killed)
    killed.kill()
    killed.communicate()
    script = tmp_path / "form.py"
    script.write_text(SCRIPT.format(grace=0.0))
    out = mpirun(2, script, env={"XDG_CACHE_HOME": str(tmp_path / "cache")}, cwd=tmp_path)
    # Two ranks may write their numbers into one line.
    assert out.count("0.25") == 2 and left.with_suffix(".c.cached").exists()


def test_what_a_living_process_compiles_is_left_to_it(tmp_path, run):
    """Another waits, three seconds here, then says what it waits for; it goes on once the first is killed."""
    first = run(stuck=True)
    left = _wait_for_file(tmp_path, first)
    _, err = run().communicate()
    assert "TimeoutError: JIT compilation timed out" in err and str(left) in err and left.exists()
    second = run()
    time.sleep(2.0)
    first.kill()
    first.communicate()
    out, err = second.communicate()
    assert out == "0.25\n", err


def test_a_young_file_may_be_that_of_plain_dolfinx(tmp_path, run):
    """It holds no lock: its file is left alone until it is old."""
    (tmp_path / "cache" / "fenics").mkdir(parents=True)
    killed = run(stuck=True)
    left = _wait_for_file(tmp_path, killed)
    killed.kill()
    killed.communicate()
    _, err = run(grace=60.0).communicate()
    assert "TimeoutError" in err and left.exists()
    old = time.time() - 120.0
    os.utime(left, (old, old))
    out, err = run(grace=60.0).communicate()
    assert out == "0.25\n", err


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", (1, 2))
def test_without_a_compiler_one_sentence_says_so(ranks, tmp_path, mpirun):
    env = {"XDG_CACHE_HOME": str(tmp_path / "cache"), "CC": str(tmp_path / "missing_cc")}
    caught = """
try:
    ffcx_form.ffcx_form(x[0] * ufl.dx)
except RuntimeError as error:
    print(f"rank {domain.comm.rank} says: {error}", flush=True)
"""
    script = SCRIPT.format(grace=0.0)
    output = mpirun(ranks, script[: script.index("print(")] + caught, env=env)
    for rank in range(ranks):
        assert f"rank {rank} says: no C compiler was found ({tmp_path}/missing_cc): DOLFINx compiles" in output


def test_what_forms_need_is_looked_for(tmp_path, monkeypatch):
    from dolfinx_impact.assembly import ffcx_form

    assert ffcx_form.missing_for_forms() == ""
    monkeypatch.setattr(ffcx_form.sysconfig, "get_path", lambda name: str(tmp_path))
    assert ffcx_form.missing_for_forms().startswith(f"Python's headers were not found ({tmp_path}/Python.h)")
