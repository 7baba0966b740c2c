# SPDX-License-Identifier: MIT
"""The benchmark's rows: printed as they come, and refused where they cannot be true."""

import io
import json
import os
import subprocess
import sys

import pytest
from rich.console import Console

from dolfinx_impact import _cpp
from impact_studies.bench import averaged as bench_averaged
from impact_studies.bench import contact_rows as bench_contact
from impact_studies.bench import explicit as bench_explicit
from impact_studies.bench import force
from impact_studies.bench import laws as bench_laws
from impact_studies.bench import many_ranks as bench_many_ranks
from impact_studies.bench import mixed as bench_mixed
from impact_studies.bench import one_point as bench_one_point
from impact_studies.bench import plastic as bench_plastic
from impact_studies.bench import rolling as bench_rolling
from impact_studies.bench import rows, bench_command
from impact_studies.bench import statics as bench_statics
from impact_studies.bench.setup import CASES, FINITE

PEAKS = """
import json, sys
from dolfinx_impact import _cpp
from impact_studies.bench import force
peak = _cpp.bench.peak_flops()
found = force.force_rows((("hexahedron", 1, 12), ("triangle", 2, 40)), bandwidth=1e10, peak=peak)
peaks = {lanes: _cpp.bench.peak_flops(lanes) for lanes in (2, 4, 8)}
print(json.dumps({"peak": peak, "peaks": peaks, "rows": found, "width": _cpp.kernels.processor_width()}))
"""


@pytest.mark.alone
@pytest.mark.long_rows(where=lambda width: width != 8)
@pytest.mark.parametrize("width", (1, 4, 8))
def test_no_kernel_is_above_the_peak(width):
    """Whatever the width of the kernels in use; 8 is 4 where the processor has no AVX-512."""
    environment = {**os.environ, "IMPACT_SIMD_WIDTH": str(width)}
    done = subprocess.run([sys.executable, "-c", PEAKS], env=environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout.splitlines()[-1])
    shares = [r for r in found["rows"] if r["name"].endswith(rows.PEAK)]
    assert len(shares) == 2 and all(0.0 < r["ratio"] < 1.0 for r in shares)
    assert all(r["baseline"] == pytest.approx(found["peak"] * 1e-9) for r in shares)
    assert rows.impossible(found["rows"]) == []
    # Nothing is spilled: longer vectors do more (a run of each, on a machine that others use, too).
    available = [lanes for lanes in (2, 4, 8) if found["peaks"][str(lanes)] > 0.0]
    assert 2 in available and (found["width"] < 4 or 4 in available)
    assert found["width"] < 4 or found["peaks"]["4"] > 1.3 * found["peaks"]["2"]


def test_lanes_of_the_peak():
    with pytest.raises(ValueError, match="2, 4 or 8.*not 3"):
        _cpp.bench.peak_flops(3)


def test_a_row_above_the_peak_is_refused():
    good = rows.row(f"neo_hookean force: {rows.PEAK}", "hexahedron P1", 1, 20.0, "GFLOP/s", 40.0)
    wrong = rows.row(f"neo_hookean force: {rows.PEAK}", "tetrahedron P2", 1, 20.2, "GFLOP/s", 6.5)
    other = rows.row("neo_hookean force / A", "tetrahedron P2", 1, 20.2, "million cells/s", 6.5)
    assert rows.impossible([good, other]) == []
    (complaint,) = rows.impossible([good, wrong, other])
    assert "tetrahedron P2" in complaint and "20.20 GFLOP/s is 3.11 times the peak" in complaint
    (complaint,) = rows.impossible([rows.row("memory", "hexahedron P1", 1, float("nan"), "kB", 0.8)])
    assert "memory" in complaint and "no finite ratio" in complaint


def test_the_command_fails_with_such_a_row(monkeypatch, capsys, tmp_path):
    """Rows are shown and written all the same, so that one can see what is wrong."""
    wrong = rows.row(f"force: {rows.PEAK}", "hexahedron P1", 1, 3.1, "GFLOP/s", 1.0)
    right = rows.row("force / A", "hexahedron P1", 1, 3.0, "million cells/s", 1.0)
    monkeypatch.setattr(_cpp.bench, "triad_bandwidth", lambda *_: 1e10)
    monkeypatch.setattr(_cpp.bench, "peak_flops", lambda: 1e12)
    monkeypatch.setattr(bench_command, "jobs", lambda *_: [("one", lambda: [right]), ("two", lambda: [wrong])])
    assert bench_command.main(["--json", str(tmp_path / "new" / "bench.json")]) == 1
    shown = capsys.readouterr()
    assert "force / A" in shown.out and "3.10 times the peak" in shown.err and rows.PEAK in shown.err
    found = json.loads((tmp_path / "new" / "bench.json").read_text())
    assert found["rows"][:2] == [right, wrong] and "median" in found["rows"][2]["name"]
    assert len(found["kernels"]) > 50 and found["machine"]["seconds"] > 0.0 and "s; longest: " in shown.out
    assert {"one", "two"} < set(found["seconds"]) and min(found["seconds"].values()) >= 0.0
    monkeypatch.setattr(bench_command, "jobs", lambda *_: [("one", lambda: [right])])
    assert bench_command.main([]) == 0


def test_rows_are_printed_as_they_come():
    text = io.StringIO()
    shown = []

    def job(name):
        shown.append(text.getvalue())
        return [rows.row(name, "[hexahedron] P1", 1, 2.0, "s", 4.0)]

    found = rows.measure([("one", lambda: job("first")), ("two", lambda: job("second"))], Console(file=text, width=80))
    assert [r["name"] for r in found] == ["first", "second"] and found[0]["ratio"] == 0.5
    assert "first" not in shown[0] and "first" in shown[1] and "second" not in shown[1]
    (line,) = [line for line in text.getvalue().splitlines() if line.startswith("second")]
    assert line.split() == ["second", "[hexahedron]", "P1", "1", "2.00", "s", "4.00", "0.50"]


def test_jobs_are_all_measurements():
    """A job per case, so that the bar moves; what the options add."""
    small, large = bench_command.jobs(1e10, 1e9), bench_command.jobs(1e10, 1e9, large=True, ranks=2)
    files = (bench_explicit, bench_mixed, bench_one_point, bench_averaged, bench_plastic, bench_laws, bench_statics)
    contact = bench_contact.jobs(False) + bench_rolling.jobs(False) + bench_many_ranks.jobs(False)
    forces = len(CASES) + 2 * len(FINITE) + len(force.RANK_CELLS)
    assert len(small) == forces + sum(len(file.jobs()) for file in files) + len(contact)
    assert {what for what, _ in small} < {what for what, _ in large}
    assert "explicit steps on 2 ranks" in {what for what, _ in large}
    assert all(callable(work) for _, work in large)
