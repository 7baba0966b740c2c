# SPDX-License-Identifier: MIT
"""The package's kernels one by one, their arrays in the cache: operations per second and per byte of their arguments.

A roofline (Williams, Waterman and Patterson, Communications of the ACM 52(4), 2009) shows whether a kernel is limited
by arithmetic or by what it reads and writes. docs/bench_figures.py draws it from the file that the command writes.
"""

import dataclasses
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from dolfinx_impact import _cpp
from .rows import PEAK, Job, Row, row

# Ends of the names of a material's kernels. In those of masses and body forces the compiler takes away most of the
# operations that are counted: their rate would be no rate of arithmetic.
FORCE = ".force"
TIMED = (FORCE, ".energy", ".stress")
IN_CACHE = 1024  # entries of each of three arrays that fit in the first-level cache together


@dataclasses.dataclass(frozen=True)
class KernelTime:
    """What a kernel does for a cell, and how long it takes.

    Attributes:
        name: form, as "linear_elastic.force".
        cell: cell and degree of its first argument or coefficient, as "hexahedron P1".
        hypothesis: "3d", "plane_strain", ...; "" where there is none.
        width: cells per call.
        flops: additions, multiplications and divisions per cell [1].
        bytes: size of its arguments per cell, element tensor read and written [B].
        seconds: time per cell [s].
    """

    name: str
    cell: str
    hypothesis: str
    width: int
    flops: float
    bytes: int
    seconds: float

    @property
    def rate(self) -> float:
        """Operations per second [1/s]."""
        return self.flops / self.seconds

    @property
    def intensity(self) -> float:
        """Operations per byte of the arguments [1/B]."""
        return self.flops / self.bytes


def time_kernel(kernel: _cpp.kernels.Kernel) -> KernelTime:
    """Measure a kernel with the number of cells per call that operators take by default.

    Args:
        kernel: kernel of integrals over cells or facets.

    Returns:
        Its time.
    """
    elements: list[dict[str, Any]] = [*kernel.arguments, *kernel.coefficients]
    degree = elements[0]["degree"] if elements else 0
    size_w = sum(c["num_dofs"] for c in kernel.coefficients)
    size = 8 * (2 * kernel.size_A + size_w + 3 * kernel.num_nodes)
    (seconds,) = kernel.seconds_per_cell([kernel.width])
    return KernelTime(
        kernel.name, f"{kernel.cell} P{degree}", kernel.hypothesis, kernel.width, kernel.flops, size, seconds
    )


def kernel_times(kernels: Iterable[_cpp.kernels.Kernel] | None = None) -> list[KernelTime]:
    """Measure kernels of materials over cells.

    Args:
        kernels: kernels to choose from instead of those of the package.

    Returns:
        Their times.
    """
    chosen = _cpp.kernels.table() if kernels is None else kernels
    return [time_kernel(k) for k in chosen if k.integral_type == "cell" and k.name.endswith(TIMED)]


def rows_of(times: Sequence[KernelTime], peak: float) -> list[Row]:
    """Share of the peak, for each cell and degree the median of its internal forces.

    Args:
        times: times of kernels.
        peak: operations per second of a core [1/s].

    Returns:
        Rows.
    """
    rates: dict[str, list[float]] = {}
    for t in times:
        if t.name.endswith(FORCE):
            rates.setdefault(t.cell, []).append(t.rate)
    return [
        row(f"kernels of forces, median: {PEAK}", cell, 1, float(np.median(found)) * 1e-9, "GFLOP/s", peak * 1e-9)
        for cell, found in rates.items()
    ]


class Measurement:
    """The job of the command, which keeps the times for its file.

    Args:
        peak: operations per second of a core [1/s].
    """

    def __init__(self, peak: float) -> None:
        self.peak = peak
        self.times: list[KernelTime] = []

    def rows(self) -> list[Row]:
        """Measure all kernels.

        Returns:
            Rows.
        """
        self.times = kernel_times()
        return rows_of(self.times, self.peak)

    def job(self) -> Job:
        """The measurement as the command takes it.

        Returns:
            A text, and a function that returns rows.
        """
        return "kernels in the cache", self.rows

    def record(self) -> dict[str, object]:
        """What the file holds.

        Returns:
            Bandwidth of the first-level cache, and the kernels with their times.
        """
        return {
            "cache_GB_per_s": _cpp.bench.triad_bandwidth(IN_CACHE) * 1e-9,
            "kernels": [dataclasses.asdict(t) for t in self.times],
        }
