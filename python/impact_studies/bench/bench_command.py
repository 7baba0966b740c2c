# SPDX-License-Identifier: MIT
"""`dolfinx-impact bench`: element applications per second, as ratios to DOLFINx in the same process and run.

Baseline A is dolfinx::fem::assemble_vector of the installed DOLFINx with FFCx's C kernel compiled -O3 -march=native,
its coefficients packed into reused storage. Baseline B is the same with the compiler's fast arithmetic; it shows which
part of A's time is due to strict floating-point arithmetic. Our kernels are always strict.
"""

import argparse
import json
import os
import platform
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from dolfinx_impact import _cpp
from dolfinx_impact.io.hdf5 import write_whole
from . import (
    averaged,
    contact_rows,
    explicit,
    force,
    laws,
    many_ranks,
    mixed,
    one_point,
    plastic,
    ratio_history,
    rolling,
    roofline,
    statics,
)
from .rows import Job, impossible, measure

LONGEST = 8  # measurements whose time is printed


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
    out = force.jobs(bandwidth, peak) + laws.jobs() + force.rank_jobs()
    out += explicit.jobs(large, ranks) + mixed.jobs() + one_point.jobs()
    out += plastic.jobs(large) + averaged.jobs(large) + statics.jobs()
    return out + contact_rows.jobs(large) + rolling.jobs(large) + many_ranks.jobs(large)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command.

    Args:
        argv: arguments; None for those of the process.

    Returns:
        Exit status: 1 if a row cannot be true, otherwise 0.
    """
    parser = argparse.ArgumentParser(prog="dolfinx-impact bench", description=__doc__)
    parser.add_argument("--json", metavar="OUT", help="write rows and machine here")
    parser.add_argument("--history", metavar="FILE", type=Path, help="append the ratios to this file")
    parser.add_argument("--commit", default="unknown", help="what is measured, for the file of ratios")
    parser.add_argument("--large", action="store_true", help="also contact problems of 300,000 unknowns")
    parser.add_argument("--ranks", type=int, default=0, help="also whole explicit steps on so many ranks against one")
    args = parser.parse_args(argv)
    bandwidth, peak = _cpp.bench.triad_bandwidth(), _cpp.bench.peak_flops()
    about = machine(bandwidth, peak)
    print(", ".join(f"{k} {v:.1f}" if isinstance(v, float) else f"{k} {v}" for k, v in about.items()))
    begin, roof = time.monotonic(), roofline.Measurement(peak)
    seconds: dict[str, float] = {}
    rows = measure([*jobs(bandwidth, peak, args.large, args.ranks), roof.job()], seconds=seconds)
    about["seconds"] = time.monotonic() - begin
    if args.json:
        path = Path(args.json)
        path.parent.mkdir(parents=True, exist_ok=True)
        record = {"rows": rows, "machine": about, "seconds": seconds, **roof.record()}
        write_whole(path, json.dumps(record, indent=1) + "\n")
    complaints = impossible(rows)
    if args.history and not complaints:
        ratio_history.append(args.history, rows, about, args.commit)
    longest = sorted(seconds.items(), key=lambda job: -job[1])[:LONGEST]
    times = ", ".join(f"{what} {spent:.0f} s" for what, spent in longest)
    print(f"{len(rows)} rows in {about['seconds']:.0f} s; longest: {times}")
    for complaint in complaints:
        print(f"bench: {complaint}", file=sys.stderr)
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
