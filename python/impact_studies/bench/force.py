# SPDX-License-Identifier: MIT
"""Internal forces of elastic bodies: element applications per second, on one rank and on several.

The baselines are those of the command (bench_command.py): FFCx's kernel compiled strictly, and with fast arithmetic.
"""

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np
from mpi4py import MPI

from dolfinx_impact import _cpp, materials
from dolfinx_impact.assembly import operators
from dolfinx_impact.common.mpi_launcher import on_ranks
from .rows import BANDWIDTH, PEAK, Job, Row, row
from .setup import CASES, FAST, FINITE, STRICT, Case, MaterialClass, Setup

RANK_CELLS = (("hexahedron", 1, 48), ("tetrahedron", 2, 26))


def force_rows(
    cases: Sequence[Case] = CASES,
    law: MaterialClass = materials.LinearElastic,
    bandwidth: float | None = None,
    peak: float | None = None,
) -> list[Row]:
    """Measure InternalForce against assemble_vector.

    Args:
        cases: cell, degree and cells per side.
        law: class of the material.
        bandwidth: memory bandwidth of a core; None for no row [B/s].
        peak: operations per second of a core; None for no row [1/s].

    Returns:
        Rows.

    Raises:
        RuntimeError: the vectors of the two sides differ.
    """
    rows = []
    for cell, degree, n in cases:
        setup = Setup(cell, degree, n, law)
        label = f"{cell} P{degree}"
        a, reference = setup.baseline(STRICT)
        b, _ = setup.baseline(FAST)
        name = f"{law.law_class.name} force"
        found = {}
        for width in (1, 4, 8):
            if width <= _cpp.kernels.processor_width():
                found[width] = setup.ours(width)
        widths = {width: seconds for width, (seconds, _) in found.items()}
        operator = operators.InternalForce(setup.form)
        default = operator._cpp_object.width()
        seconds, operator = found[default] if default in found else setup.ours()
        setup.b[:] = 0.0
        operator.assemble(setup.b)
        difference = np.max(np.abs(setup.b - reference)) / np.max(np.abs(reference))
        if not difference < 1e-12:
            raise RuntimeError(f"{label}: the two sides differ by {difference:.1e}: no timing counts")
        rate = setup.num_cells / seconds * 1e-6
        unit = "million cells/s"
        rows.append(row(f"{name} / A", label, 1, rate, unit, setup.num_cells / a * 1e-6))
        rows.append(row(f"{name} / B", label, 1, rate, unit, setup.num_cells / b * 1e-6))
        for width, t in widths.items():
            rows.append(
                row(
                    f"{name}, {width} lanes / 1 lane",
                    label,
                    1,
                    setup.num_cells / t * 1e-6,
                    unit,
                    setup.num_cells / widths[1] * 1e-6,
                )
            )
        if peak and bandwidth:
            rows.append(row(f"{name}: {PEAK}", label, 1, operator.flops / seconds * 1e-9, "GFLOP/s", peak * 1e-9))
            traffic = setup.bytes() / seconds * 1e-9
            rows.append(row(f"{name}: {BANDWIDTH}", label, 1, traffic, "GB/s", bandwidth * 1e-9))
    return rows


def rank_rows(ranks: int = 2, cells: Sequence[Case] = RANK_CELLS) -> list[Row]:
    """Measure the speed per core on several ranks against one rank with as many cells per rank.

    Every application exchanges the ghosts.

    Args:
        ranks: number of ranks.
        cells: cell, degree and cells per side on one rank.

    Returns:
        Rows.
    """
    rows = []
    for cell, degree, n in cells:
        one = _rank_rate(1, cell, degree, n)
        several = _rank_rate(ranks, cell, degree, int(round(n * ranks ** (1 / 3))))
        rows.append(
            row("linear_elastic force, per core", f"{cell} P{degree}", ranks, several, "million cells/s/core", one)
        )
    return rows


def _rank_rate(ranks: int, cell: str, degree: int, n: int) -> float:
    """Million cells per second and rank, measured in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "rate.json"
        own = [sys.executable, "-m", "impact_studies.bench.force", cell, str(degree), str(n), str(path)]
        subprocess.run([*on_ranks(ranks), *own], check=True, capture_output=True)
        return json.loads(path.read_text())


def _rate(cell: str, degree: str, n: str, path: str) -> None:
    """Measure the rate on the ranks of this process and write it to a file."""
    comm = MPI.COMM_WORLD
    setup = Setup(cell, int(degree), int(n), comm=comm)
    operator = operators.InternalForce(setup.form)
    b = operator.vector()
    operator.apply(b)
    comm.Barrier()
    start, repeat = time.perf_counter(), 20
    for _ in range(repeat):
        operator.apply(b)
    comm.Barrier()
    rate = setup.num_cells * repeat / (time.perf_counter() - start) * 1e-6
    mean = comm.allreduce(rate, MPI.SUM) / comm.size
    if comm.rank == 0:
        Path(path).write_text(json.dumps(mean))


def jobs(bandwidth: float, peak: float) -> list[Job]:
    """Measurements of internal forces on one rank.

    Args:
        bandwidth: memory bandwidth of a core [B/s].
        peak: operations per second of a core [1/s].

    Returns:
        A text and a function that returns rows, for each measurement.
    """
    laws: list[tuple[MaterialClass, tuple[Case, ...]]] = [(materials.LinearElastic, CASES)]
    laws += [(law, FINITE) for law in (materials.StVenantKirchhoff, materials.NeoHookean)]
    return [
        (f"{law.law_class.name} force, {case[0]} P{case[1]}", partial(force_rows, (case,), law, bandwidth, peak))
        for law, cases in laws
        for case in cases
    ]


def rank_jobs() -> list[Job]:
    """Measurements of internal forces on two ranks.

    Returns:
        A text and a function that returns rows, for each measurement.
    """
    return [(f"force on 2 ranks, {c[0]} P{c[1]}", partial(rank_rows, 2, (c,))) for c in RANK_CELLS]


if __name__ == "__main__":
    _rate(*sys.argv[1:])
