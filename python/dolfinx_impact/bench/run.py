# SPDX-License-Identifier: MIT
"""`dolfinx-impact bench`: element applications per second, as ratios against DOLFINx in the same process and run.

Baseline A is dolfinx::fem::assemble_vector of the installed DOLFINx with FFCx's C kernel compiled -O3 -march=native,
its coefficients packed into reused storage; baseline B is the same with -ffast-math, which shows how much of A's time
is strict floating point. Ours never uses -ffast-math.
"""

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path

import numpy as np
import ufl
from dolfinx import cpp, fem, mesh
from mpi4py import MPI

from .. import _cpp, materials
from . import contact as bench_contact
from .rows import PEAK, impossible, measure, row
from ..assembly import operators
from ..io.hdf5 import write_whole

STRICT = ["-O3", "-march=native"]
FAST = ["-O3", "-march=native", "-ffast-math"]
# (cell, degree, cells per side): a few hundred thousand degrees of freedom, beyond the caches
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


def best_time(function, at_least=0.05, rounds=3):
    """Processor time of one call, (best, median); a round repeats the call until it lasts `at_least` seconds."""
    function()
    times, repeat = [], 1
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
    """A body, a form on it and both ways to apply it."""

    def __init__(self, cell, degree, n, law=materials.LinearElastic, comm=MPI.COMM_SELF):
        kind = getattr(mesh.CellType, cell)
        plane = cell in ("triangle", "quadrilateral")
        self.mesh = mesh.create_unit_square(comm, n, n, kind) if plane else mesh.create_unit_cube(comm, n, n, n, kind)
        dim = 2 if plane else 3
        self.V = fem.functionspace(self.mesh, ("Lagrange", degree, (dim,)))
        self.u = fem.Function(self.V, name="u")
        self.u.interpolate(lambda x: 0.01 * np.array([np.sin(3 * x[i] + x[(i + 1) % dim]) for i in range(dim)]))
        material = law(1e3, 0.3, 1.0, "plane_strain" if plane else "3d")
        self.form = operators.internal_force_form(self.u, ufl.TestFunction(self.V), material)
        self.num_cells = self.mesh.topology.index_map(self.mesh.topology.dim).size_local
        self.b = fem.Function(self.V).x.array
        self.pack = None

    def ours(self, width=0):
        """(seconds per application, operator)."""
        operator = operators.InternalForce(self.form, width)
        return best_time(lambda: operator._cpp_object.assemble(self.b))[1], operator

    def baseline(self, flags):
        """(seconds per application, result): assemble_vector of the installed DOLFINx, packing into reused storage."""
        form = fem.form(self.form, jit_options={"cffi_extra_compile_args": flags})._cpp_object
        constants, coefficients = cpp.fem.pack_constants(form), cpp.fem.pack_coefficients(form)
        if self.pack is None:  # the same for all flags
            self.pack = best_time(_cpp.bench.Packed(form).pack)[1]
        apply = best_time(lambda: cpp.fem.assemble_vector(self.b, form, constants, coefficients))[1]
        self.b[:] = 0.0
        cpp.fem.assemble_vector(self.b, form, constants, coefficients)
        return self.pack + apply, self.b.copy()

    def bytes(self):
        """Memory traffic of one application if every value moved once: node numbers per cell, nodal values per node."""
        nodes = self.V.dofmap.list.shape[1]
        per_cell = 4 * (2 * nodes + self.mesh.geometry.dofmap.shape[1])
        return self.num_cells * per_cell + 8 * 3 * len(self.b) + 24 * len(self.mesh.geometry.x)


def force_rows(cases=CASES, law=materials.LinearElastic, bandwidth=None, peak=None):
    """Rows of InternalForce against assemble_vector, per cell type."""
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
        if peak:
            rows.append(row(f"{name}: {PEAK}", label, 1, operator.flops / seconds * 1e-9, "GFLOP/s", peak * 1e-9))
            rows.append(
                row(f"{name}: share of bandwidth", label, 1, setup.bytes() / seconds * 1e-9, "GB/s", bandwidth * 1e-9)
            )
    return rows


def rank_rows(ranks=2, cells=RANK_CELLS):
    """Per-core speed on several ranks against one rank with as many cells a rank; ghosts are exchanged every time."""
    rows = []
    for cell, degree, n in cells:
        one = _rank_rate(1, cell, degree, n)
        several = _rank_rate(ranks, cell, degree, int(round(n * ranks ** (1 / 3))))
        rows.append(
            row("linear_elastic force, per core", f"{cell} P{degree}", ranks, several, "million cells/s/core", one)
        )
    return rows


def _rank_rate(ranks, cell, degree, n):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "rate.json"
        own = [sys.executable, "-m", "dolfinx_impact.bench.run", "--rate", cell, str(degree), str(n), str(path)]
        subprocess.run((["mpirun", "-n", str(ranks)] if ranks > 1 else []) + own, check=True, capture_output=True)
        return json.loads(path.read_text())


def _rate(cell, degree, n, path):
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


def machine(bandwidth, peak):
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


def jobs(bandwidth, peak, large=False, ranks=0):
    """All measurements, in their order.

    Args:
        bandwidth: memory bandwidth of a core [B/s].
        peak: operations per second of a core [1/s].
        large: also contact problems of 300,000 unknowns.
        ranks: also whole explicit steps on so many ranks; 0: without.
    """
    from . import explicit as bench_explicit  # which uses this module

    laws = [(materials.LinearElastic, CASES)]
    laws += [(law, FINITE) for law in (materials.StVenantKirchhoff, materials.NeoHookean)]
    out = [
        (f"{law.law_class.name} force, {case[0]} P{case[1]}", partial(force_rows, (case,), law, bandwidth, peak))
        for law, cases in laws
        for case in cases
    ]
    out += [(f"force on 2 ranks, {c[0]} P{c[1]}", partial(rank_rows, 2, (c,))) for c in RANK_CELLS]
    out += bench_explicit.jobs(large, ranks)
    cases = bench_contact.CASES + (bench_contact.LARGE if large else ())
    return out + [(f"static contact, {c[0]}", partial(bench_contact.contact_rows, row, (c,))) for c in cases]


def main(argv=None):
    """Run the command.

    Args:
        argv: arguments; None: those of the process.

    Returns:
        The exit status: 1 where a row cannot be true.
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
