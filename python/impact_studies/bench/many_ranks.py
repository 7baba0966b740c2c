# SPDX-License-Identifier: MIT
"""Runs on many ranks and of many cells: equal work by counters, and what set-up costs per cell, in time and memory.

Counters do not depend on how busy the machine is, so that there may be more ranks than cores. Set-up is measured in a
process of its own by processor time and by the most memory that the process ever had.
"""

import json
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path

import numpy as np
from dolfinx import fem, io, mesh
from mpi4py import MPI

from dolfinx_impact import materials
from dolfinx_impact import meshes  # type: ignore[attr-defined,unused-ignore]  # installed beside it
from dolfinx_impact.common.mpi_launcher import on_ranks
from dolfinx_impact.dynamics.explicit import ExplicitProblem
from dolfinx_impact.io.mesh_reader import read_mesh
from dolfinx_impact.io.partition import NODE_COST, partition
from .explicit import initial_velocity
from .rows import Job, Row, row
from .setup import most_memory

RANKS = (2, 4)
MANY_RANKS = (2, 4, 8, 16)
BALANCED = 0.10  # largest work over the mean less one, goal
SIDE = 58  # cells along a side of the cube that is set up: 195,000
LARGE_SIDE = 159  # 4.0 million
KB_PER_CELL = 6.0  # 4 million cells in 24 GB


def balance_rows(ranks: int, n: int = 16) -> list[Row]:
    """Count the work of the ranks, cells and slave nodes, of two blocks on each other.

    Args:
        ranks: number of ranks.
        n: cells along a side of the blocks, which are half as high.

    Returns:
        Rows: the imbalance after `partition` beside that of DOLFINx's partitioner, and beside the goal.
    """
    found = _run("balance", ranks, n)
    label = f"two blocks of {n} x {n} x {n // 2} hexahedra"
    ours, theirs = 1.0 + found["ours"], 1.0 + found["theirs"]
    return [
        row("largest work / mean, di.partition / DOLFINx's", label, ranks, ours, "", theirs),
        row("  the same, goal 1.1", label, ranks, ours, "", 1.0 + BALANCED),
    ]


def setup_rows(n: int = SIDE) -> list[Row]:
    """Measure set-up per cell of a cube of distorted hexahedra that is read from a file, and the memory for all of it.

    Args:
        n: cells along a side.

    Returns:
        Rows: processor time of reading mesh and space, of the problem beside it, of a step; most memory.
    """
    found = _run("setup", 1, n)
    label, unit = f"hexahedron P1, {n**3} cells", "microseconds"
    return [
        row("set-up per cell: problem / reading the mesh", label, 1, found["problem"], unit, found["read"]),
        row("set-up per cell: problem / a step", label, 1, found["problem"], unit, found["step"]),
        row("set-up per cell: most memory, goal 6", label, 1, found["kB"], "kB", KB_PER_CELL),
    ]


def _run(what: str, ranks: int, n: int) -> dict[str, float]:
    """Run this module in processes of its own; measured values by name."""
    with tempfile.TemporaryDirectory() as folder:
        out, file = Path(folder) / "out.json", Path(folder) / "cube.xdmf"
        own = [sys.executable, "-m", "impact_studies.bench.many_ranks"]
        if what == "setup":
            subprocess.run([*on_ranks(1), *own, "write", str(n), str(file), ""], check=True, capture_output=True)
        command = [*on_ranks(ranks), *own, what, str(n), str(file), str(out)]
        subprocess.run(command, check=True, capture_output=True)
        return json.loads(out.read_text())


def _balance(n: int) -> dict[str, float]:
    """Imbalance of two blocks by DOLFINx's partitioner and after `partition`. Collective."""
    comm = MPI.COMM_WORLD
    model = meshes.make(
        "two_blocks", comm, cell="hexahedron", gap=1e-4 / n, lower=(1.1, 1.1, 0.5), upper=(1.0, 1.0, 0.5),
        lower_cells=(n, n, n // 2), upper_cells=(n, n, n // 2),
    )  # fmt: skip
    shared = partition(model.mesh, None, model.facet_tags, slave=[model.tags["slave_surface"]])
    V = fem.functionspace(model.mesh, ("Lagrange", 1, (3,)))
    slaves = fem.locate_dofs_topological(V, 2, model.facet_tags.find(model.tags["slave_surface"]))
    work = model.mesh.topology.index_map(3).size_local + NODE_COST * int(np.sum(slaves < V.dofmap.index_map.size_local))
    theirs = comm.allreduce(work, MPI.MAX) * comm.size / comm.allreduce(work) - 1.0
    return {"ours": shared.imbalance, "theirs": theirs}


def _write(n: int, file: Path) -> None:
    """Write a cube whose cells all differ: each has its own stable step."""
    domain = mesh.create_unit_cube(MPI.COMM_SELF, n, n, n, mesh.CellType.hexahedron)
    x = domain.geometry.x
    x += 0.05 / n * np.sin(37 * x[:, [1, 2, 0]] * n)
    with io.XDMFFile(domain.comm, file, "w") as out:
        out.write_mesh(domain)


def _problem(domain: mesh.Mesh) -> tuple[float, ExplicitProblem]:
    """Processor time of making an explicit problem [s], and the problem."""
    V = fem.functionspace(domain, ("Lagrange", 1, (3,)))
    u, velocity = fem.Function(V, name="u"), initial_velocity(V)
    begin = time.process_time()
    problem = ExplicitProblem(u, materials.LinearElastic(1e3, 0.3, 1.0, "3d"), velocity=velocity)
    return time.process_time() - begin, problem


def _setup(n: int, file: Path, steps: int = 5) -> dict[str, float]:
    """Processor time per cell of reading, set-up and a step [microseconds], and most memory per cell [kB]."""
    _problem(mesh.create_unit_cube(MPI.COMM_SELF, 2, 2, 2, mesh.CellType.hexahedron))[1].advance(0.1, progress=False)
    before = most_memory()
    begin = time.process_time()
    read = read_mesh(file, MPI.COMM_SELF)
    reading = time.process_time() - begin
    seconds, problem = _problem(read.mesh)
    begin, first = time.process_time(), problem.step
    problem.advance(steps * 0.9 * problem._stepper.safe_step, progress=False)
    step = (time.process_time() - begin) / (problem.step - first)
    most = most_memory() - before
    micro = 1e6 / n**3
    return {"read": micro * reading, "problem": micro * seconds, "step": micro * step, "kB": 1e-3 * most / n**3}


def jobs(large: bool = False) -> list[Job]:
    """Measurements of ranks and of large meshes.

    Args:
        large: more ranks, and 4 million cells.

    Returns:
        A text and a function that returns rows, for each measurement.
    """
    out: list[Job] = [(f"equal work on {n} ranks", partial(balance_rows, n)) for n in (MANY_RANKS if large else RANKS)]
    return [*out, ("set-up per cell", partial(setup_rows, LARGE_SIDE if large else SIDE))]


if __name__ == "__main__":
    what, n, file, path = sys.argv[1:]
    if what == "write":
        _write(int(n), Path(file))
    else:
        result = _balance(int(n)) if what == "balance" else _setup(int(n), Path(file))
        if MPI.COMM_WORLD.rank == 0:
            Path(path).write_text(json.dumps(result))
