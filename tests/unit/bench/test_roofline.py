# SPDX-License-Identifier: MIT
"""Operations per second and per byte of kernels alone, and the picture of them under the machine's limits."""

import dataclasses
import importlib.util
import pathlib

import pytest

from dolfinx_impact import _cpp
from impact_studies.bench import roofline
from impact_studies.bench.contact_rows import SOLVE
from impact_studies.bench.roofline import KernelTime
from impact_studies.bench.rows import BANDWIDTH, PEAK, impossible, row

DOCS = pathlib.Path(__file__).parents[3] / "docs"


def made_up(cell="hexahedron P1", name="linear_elastic.force", flops=800.0, seconds=4e-8):
    return KernelTime(name, cell, "3d", 4, flops, 400, seconds)


def test_a_kernel_is_timed_with_the_size_of_its_arguments():
    (kernel,) = _cpp.kernels.find("linear_elastic.force", "hexahedron", 1, 1, "3d")
    (found,) = roofline.kernel_times([kernel])
    assert (found.name, found.cell, found.hypothesis) == ("linear_elastic.force", "hexahedron P1", "3d")
    assert found.width == kernel.width and found.width in kernel.widths
    assert found.bytes == 8 * (2 * 24 + 24 + 24) and found.flops == kernel.flops > 0.0
    assert 0.0 < found.rate < _cpp.bench.peak_flops()  # the count of operations is no larger than what was done


def test_only_kernels_of_materials_are_timed():
    """The compiler takes operations out of those of masses and loads."""
    mass = _cpp.kernels.find("row_sum", "hexahedron", 1, 1, "3d")
    energy = _cpp.kernels.find("neo_hookean.energy", "tetrahedron", 1, 1, "3d")
    assert [t.name for t in roofline.kernel_times([*mass, *energy])] == ["neo_hookean.energy"]


def test_more_cells_at_once_are_timed_in_turn():
    (kernel,) = _cpp.kernels.find("neo_hookean.force", "tetrahedron", 2, 1, "3d")
    seconds = kernel.seconds_per_cell(kernel.widths)
    assert len(seconds) == len(kernel.widths) and all(0.0 < s < 1e-4 for s in seconds)
    with pytest.raises(ValueError, match="neo_hookean.force.*3 cells"):
        kernel.seconds_per_cell([3])


def test_rows_are_medians_of_forces():
    times = [made_up(seconds=s) for s in (2e-8, 4e-8, 8e-8)]
    times += [made_up(name="linear_elastic.energy", seconds=1e-12), made_up(cell="tetrahedron P1")]
    first, second = roofline.rows_of(times, 4e10)
    assert (first["cell"], first["value"], first["ratio"]) == ("hexahedron P1", pytest.approx(20.0), pytest.approx(0.5))
    assert second["cell"] == "tetrahedron P1" and first["name"].endswith(PEAK)
    assert impossible(roofline.rows_of(times, 1e10)) != []  # a rate above the peak is refused


def test_the_file_of_a_run_holds_all_kernels_of_materials():
    measurement = roofline.Measurement(peak=1e12)
    what, rows = measurement.job()
    assert "kernels" in what and all(0.0 < r["ratio"] < 1.0 for r in rows())
    found = measurement.record()
    assert {"linear_elastic.force", "j2.small.voce.force"} < {k["name"] for k in found["kernels"]}
    assert found["cache_GB_per_s"] > 1.0


def bench_figures():
    specification = importlib.util.spec_from_file_location("bench_figures", DOCS / "bench_figures.py")
    figures = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(figures)
    return figures


def test_the_picture_has_a_point_for_each_kernel():
    forces = [
        row(f"linear_elastic force: {PEAK}", "hexahedron P1", 1, 10.0, "GFLOP/s", 50.0),
        row(f"linear_elastic force: {BANDWIDTH}", "hexahedron P1", 1, 2.0, "GB/s", 14.0),
        row("linear_elastic force / A", "hexahedron P1", 1, 2.0, "million cells/s", 1.0),
    ]
    machine = {"processor": "a processor", "vector_width": 4, "peak_GFLOP_per_s": 50.0, "triad_GB_per_s": 14.0}
    kernels = [dataclasses.asdict(made_up(seconds=s)) for s in (2e-8, 4e-8)]
    run = {"rows": forces, "machine": machine, "cache_GB_per_s": 200.0, "kernels": kernels}
    (ax,) = bench_figures().roofline(run).axes
    lines = {line.get_label(): line for line in ax.get_lines()}
    assert list(lines["hexahedron, a kernel"].get_xdata()) == [2.0, 2.0]
    assert list(lines["hexahedron, a kernel"].get_ydata()) == pytest.approx([40.0, 20.0])
    assert list(lines["hexahedron, the force of a mesh"].get_xdata()) == [5.0]
    assert max(lines["memory, 14 GB/s; one core, 50 GFLOP/s"].get_ydata()) == 50.0
    assert len(lines["triangle, a kernel"].get_xdata()) == 0


def test_a_cache_is_faster_than_memory():
    assert _cpp.bench.triad_bandwidth(roofline.IN_CACHE) > 1.2 * _cpp.bench.triad_bandwidth(1 << 22)
    with pytest.raises(ValueError, match="need entries"):
        _cpp.bench.triad_bandwidth(0)


def test_the_picture_of_static_contact_is_over_the_unknowns():
    rows = [
        row(SOLVE, "hexahedron P1, 300000 unknowns", 1, 90.0, "s", 30.0),
        row(SOLVE, "quadrilateral P1, 30000 unknowns", 1, 5.0, "s", 1.0),
        row(SOLVE, "hexahedron P1, 30000 unknowns", 1, 8.0, "s", 3.0),
    ]
    (ax,) = bench_figures().static_contact(rows).axes
    contact, tied, proportional = (line.get_xydata().tolist() for line in ax.get_lines())
    assert contact == [[30000, 8.0], [300000, 90.0]] and tied == [[30000, 3.0], [300000, 30.0]]
    assert proportional == [[30000, 3.0], [300000, 30.0]]
