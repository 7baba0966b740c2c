# SPDX-License-Identifier: MIT
"""`dolfinx-impact bench`: element applications per second, as ratios to DOLFINx in the same process and run.

Baseline A is dolfinx::fem::assemble_vector of the installed DOLFINx with FFCx's C kernel compiled -O3 -march=native,
its coefficients packed into reused storage. Baseline B is the same with -ffast-math; it shows which part of A's time is
due to strict floating-point arithmetic. Our kernels never use -ffast-math.
"""

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TypeAlias, Union

import numpy as np
import ufl
from dolfinx import cpp, fem, mesh
from mpi4py import MPI

from ..assembly.ffcx_form import ffcx_form
from .. import _cpp, materials
from ..assembly import operators
from ..common.types import FloatArray
from ..io.hdf5 import write_whole
from . import contact as bench_contact
from .rows import PEAK, Job, Row, impossible, measure, row

# Cell, degree and cells per side.
Case: TypeAlias = tuple[str, int, int]
MaterialClass: TypeAlias = type[Union[materials.LinearElastic, materials.NeoHookean, materials.StVenantKirchhoff]]

STRICT = ["-O3", "-march=native"]
FAST = ["-O3", "-march=native", "-ffast-math"]
# Some hundred thousand degrees of freedom each: more than the caches hold.
CASES = (
    ("triangle", 1, 300),
    ("triangle", 2, 160),
    ("quadrilateral", 1, 400),
    ("quadrilateral", 2, 160),
    ("tetrahedron", 1, 32),
    ("tetrahedron", 2, 22),
    ("hexahedron", 1, 50),
    ("hexahedron", 2, 20),
)
FINITE = (("tetrahedron", 2, 22), ("hexahedron", 1, 50))
RANK_CELLS = (("hexahedron", 1, 48), ("tetrahedron", 2, 26))


def best_time(function: Callable[[], object], at_least: float = 0.05, rounds: int = 3) -> tuple[float, float]:
    """Processor time of one call of a function.

    Args:
        function: function without arguments.
        at_least: duration of a round, which repeats the call [s].
        rounds: number of rounds.

    Returns:
        Best and median time of the rounds [s].
    """
    function()
    times: list[float] = []
    repeat = 1
    while len(times) < rounds:
        start = time.process_time()
        for _ in range(repeat):
            function()
        elapsed = time.process_time() - start
        if elapsed < at_least:
            repeat = max(repeat + 1, int(repeat * at_least / max(elapsed, 1e-6)))
            continue
        times.append(elapsed / repeat)
    return min(times), float(np.median(times))


class Setup:
    """A unit square or cube with the form of its internal force, and the operators of both sides.

    Args:
        cell: cell of the mesh.
        degree: degree of the displacement, 1 or 2.
        n: cells per side.
        law: class of the material.
        comm: communicator of the mesh.
    """

    def __init__(
        self,
        cell: str,
        degree: int,
        n: int,
        law: MaterialClass = materials.LinearElastic,
        comm: MPI.Intracomm = MPI.COMM_SELF,
    ) -> None:
        kind = getattr(mesh.CellType, cell)
        plane = cell in ("triangle", "quadrilateral")
        self.mesh = mesh.create_unit_square(comm, n, n, kind) if plane else mesh.create_unit_cube(comm, n, n, n, kind)
        dim = 2 if plane else 3
        self.V = fem.functionspace(self.mesh, ("Lagrange", degree, (dim,)))
        self.u = fem.Function(self.V, name="u")
        self.u.interpolate(lambda x: 0.01 * np.array([np.sin(3 * x[i] + x[(i + 1) % dim]) for i in range(dim)]))
        material = law(1e3, 0.3, 1.0, "plane_strain" if plane else "3d")
        self.form = operators.internal_force_form(self.u, ufl.TestFunction(self.V), material)
        self.num_cells: int = self.mesh.topology.index_map(self.mesh.topology.dim).size_local
        self.b: FloatArray = fem.Function(self.V).x.array
        self.pack_seconds: float | None = None

    def ours(self, width: int = 0) -> tuple[float, operators.InternalForce]:
        """Time our operator.

        Args:
            width: number of cells per kernel call; 0 takes the default.

        Returns:
            Time per application [s], and the operator.
        """
        operator = operators.InternalForce(self.form, width)
        return best_time(lambda: operator._cpp_object.assemble(self.b))[1], operator

    def baseline(self, flags: list[str]) -> tuple[float, FloatArray]:
        """Time assemble_vector of the installed DOLFINx, with coefficients packed into reused storage.

        Args:
            flags: compiler flags of FFCx's kernel.

        Returns:
            Time per application [s], and the assembled vector, shape (num_dofs) [F].
        """
        form = ffcx_form(self.form, jit_options={"cffi_extra_compile_args": flags})._cpp_object
        constants, coefficients = cpp.fem.pack_constants(form), cpp.fem.pack_coefficients(form)
        if self.pack_seconds is None:  # the same for all flags
            self.pack_seconds = best_time(_cpp.bench.Packed(form).pack)[1]
        apply = best_time(lambda: cpp.fem.assemble_vector(self.b, form, constants, coefficients))[1]
        self.b[:] = 0.0
        cpp.fem.assemble_vector(self.b, form, constants, coefficients)
        return self.pack_seconds + apply, self.b.copy()

    def bytes(self) -> int:
        """Memory traffic of one application if every node number and nodal value is transferred once.

        Returns:
            Traffic [B].
        """
        nodes = self.V.dofmap.list.shape[1]
        per_cell = 4 * (2 * nodes + self.mesh.geometry.dofmap.shape[1])
        return self.num_cells * per_cell + 8 * 3 * len(self.b) + 24 * len(self.mesh.geometry.x)


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
            rows.append(
                row(f"{name}: share of bandwidth", label, 1, setup.bytes() / seconds * 1e-9, "GB/s", bandwidth * 1e-9)
            )
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
        own = [sys.executable, "-m", "dolfinx_impact.bench.run", "--rate", cell, str(degree), str(n), str(path)]
        subprocess.run((["mpirun", "-n", str(ranks)] if ranks > 1 else []) + own, check=True, capture_output=True)
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


def machine(bandwidth: float, peak: float) -> dict[str, str | int | float | None]:
    """Description of the machine.

    Args:
        bandwidth: memory bandwidth of a core [B/s].
        peak: operations per second of a core [1/s].

    Returns:
        Processor, number of cores, load, vector width, bandwidth and peak by name.
    """
    model = platform.processor()
    try:
        text = Path("/proc/cpuinfo").read_text()
        model = next(line.split(":")[1].strip() for line in text.splitlines() if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    return {
        "processor": model,
        "cores": os.cpu_count(),
        "load": os.getloadavg()[0],
        "vector_width": _cpp.kernels.processor_width(),
        "triad_GB_per_s": bandwidth * 1e-9,
        "peak_GFLOP_per_s": peak * 1e-9,
    }


def jobs(bandwidth: float, peak: float, large: bool = False, ranks: int = 0) -> list[Job]:
    """All measurements of the command, in their order.

    Args:
        bandwidth: memory bandwidth of a core [B/s].
        peak: operations per second of a core [1/s].
        large: include contact problems of 300,000 unknowns.
        ranks: include whole explicit steps on this number of ranks; 0 for none.

    Returns:
        A text and a function that returns rows, for each measurement.
    """
    from . import explicit as bench_explicit  # these modules import this one
    from . import laws as bench_laws
    from . import plastic as bench_plastic
    from . import rolling as bench_rolling
    from . import statics as bench_statics

    laws: list[tuple[MaterialClass, tuple[Case, ...]]] = [(materials.LinearElastic, CASES)]
    laws += [(law, FINITE) for law in (materials.StVenantKirchhoff, materials.NeoHookean)]
    out: list[Job] = [
        (f"{law.law_class.name} force, {case[0]} P{case[1]}", partial(force_rows, (case,), law, bandwidth, peak))
        for law, cases in laws
        for case in cases
    ]
    out += bench_laws.jobs()
    out += [(f"force on 2 ranks, {c[0]} P{c[1]}", partial(rank_rows, 2, (c,))) for c in RANK_CELLS]
    out += bench_explicit.jobs(large, ranks) + bench_plastic.jobs(large)
    out += bench_statics.jobs()
    cases = bench_contact.CASES + (bench_contact.LARGE if large else ())
    out += [(f"static contact, {c[0]}", partial(bench_contact.contact_rows, row, (c,))) for c in cases]
    return out + bench_rolling.jobs(large)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command.

    Args:
        argv: arguments; None for those of the process.

    Returns:
        Exit status: 1 if a row cannot be true, otherwise 0.
    """
    parser = argparse.ArgumentParser(prog="dolfinx-impact bench", description=__doc__)
    parser.add_argument("--json", metavar="OUT", help="write rows and machine here")
    parser.add_argument("--large", action="store_true", help="also contact problems of 300,000 unknowns")
    parser.add_argument("--ranks", type=int, default=0, help="also whole explicit steps on so many ranks against one")
    parser.add_argument("--rate", nargs=4, help=argparse.SUPPRESS)
    args = parser.parse_args(argv)
    if args.rate:
        _rate(*args.rate)
        return 0
    bandwidth, peak = _cpp.bench.triad_bandwidth(), _cpp.bench.peak_flops()
    about = machine(bandwidth, peak)
    print(", ".join(f"{k} {v:.1f}" if isinstance(v, float) else f"{k} {v}" for k, v in about.items()))
    rows = measure(jobs(bandwidth, peak, args.large, args.ranks))
    if args.json:
        path = Path(args.json)
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, json.dumps({"rows": rows, "machine": about}, indent=1) + "\n")
    complaints = impossible(rows)
    for complaint in complaints:
        print(f"bench: {complaint}", file=sys.stderr)
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
