# SPDX-License-Identifier: MIT
"""HTML page and figures of a verification run."""

from collections.abc import Callable, Iterable, Sequence
from html import escape
from pathlib import Path
from typing import TypeVar

from dolfinx_impact.io.hdf5 import write_whole
from dolfinx_impact.io.run_folder import versions
from .report import Report, Row, row_label

T = TypeVar("T")

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; margin: 2em auto; max-width: 72em; color: #222; padding: 0 1em; }
table { border-collapse: collapse; width: 100%; margin: 1em 0; }
th, td { text-align: left; padding: .25em .7em; border-bottom: 1px solid #ddd; }
td.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
.pass { color: #17702f; } .fail { color: #b00020; font-weight: bold; }
img { max-width: 100%; } details { margin: .5em 0; } summary { cursor: pointer; font-weight: 600; }
"""


def _table(rows: Iterable[T], header: Sequence[str], cells: Callable[[T], list[str]]) -> str:
    head = "".join(f"<th>{escape(h)}</th>" for h in header)
    body = "".join("<tr>" + "".join(cells(r)) + "</tr>" for r in rows)
    return f"<table><tr>{head}</tr>{body}</table>"


def _cells(r: Row, form: bool = True) -> list[str]:
    mark = "pass" if r.passed else "fail"
    return (
        [f"<td>{escape(r.form)}</td>"] * form
        + [
            f"<td>{escape(row_label(r))}</td>",
            f'<td class="n">{r.difference:.2e}</td>',
            f'<td class="n">{r.tolerance:.0e}</td>',
        ]
        + [f"<td>{escape(r.reason)}</td>", f'<td class="{mark}">{mark}</td>']
        + [f"<td>{escape(r.note) if not r.passed else ''}</td>"]
    )


def write(report: Report, path: Path | str) -> Path:
    """Write the page of a report; figures in its folder are linked by name, others by path.

    Args:
        report: report with its rows and figures.
        path: file to write.

    Returns:
        The file.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    failed = report.failures()
    verdict = '<span class="pass">every row passed</span>'
    if not report.passed:
        text = f"{len(failed)} rows failed" if failed else "nothing was compared"
        verdict = f'<span class="fail">{text}</span>'
    with_versions = ", ".join(f"{k} {v}" for k, v in versions().items())
    out = [f"<!doctype html><meta charset='utf-8'><title>Cross-verification</title><style>{STYLE}</style>"]
    out.append("<h1>UFL kernels against the hand-written solver</h1>")
    out.append(f"<p>{len(report.rows)} rows: {verdict}. {escape(with_versions)}.</p>")
    header = ["form", "case", "difference", "tolerance", "tolerance from", "", "where they differ"]
    if failed:
        out.append("<h2>Rows that failed</h2>" + _table(failed, header, _cells))
    out.append("<h2>Worst case of each form</h2>")
    summary = [(level, form, n, r) for level, form, n, r in report.summary()]
    out.append(
        _table(
            summary,
            ["level", "form", "rows", "worst case", "difference", "tolerance", "tolerance from", ""],
            lambda t: [f"<td>{escape(t[0])}</td><td>{escape(t[1])}</td><td class='n'>{t[2]}</td>"]
            + _cells(t[3], False)[:-1],
        )
    )
    for title, file in report.figures:
        figure = Path(file)
        source = figure.name if figure.parent.resolve() == path.parent.resolve() else str(figure)
        out.append(f"<h2>{escape(title)}</h2><img src='{escape(source)}' alt='{escape(title)}'>")
    out.append("<h2>All rows</h2>")
    for level in dict.fromkeys(r.level for r in report.rows):
        rows = [r for r in report.rows if r.level == level]
        table = _table(rows, header, _cells)
        out.append(f"<details><summary>{escape(level)}: {len(rows)} rows</summary>{table}</details>")
    write_whole(path, "\n".join(out) + "\n")
    return path


def differences_plot(report: Report, folder: Path | str) -> Path:
    """Plot all differences over their tolerances, one column of points per level.

    Args:
        report: report with its rows.
        folder: folder of the picture.

    Returns:
        File of the picture.
    """
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np

    levels = list(dict.fromkeys(r.level for r in report.rows))
    figure, axis = plt.subplots(figsize=(9, 5), constrained_layout=True)
    rng = np.random.default_rng(0)
    for i, level in enumerate(levels):
        rows = [r for r in report.rows if r.level == level and r.tolerance > 0]
        if not rows:
            continue
        ratio = np.array([max(r.difference / r.tolerance, 1e-8) for r in rows])
        colours = ["C0" if r.passed else "C3" for r in rows]
        axis.scatter(i + rng.uniform(-0.3, 0.3, len(rows)), ratio, c=colours, s=12, alpha=0.6)
    axis.axhline(1.0, color="C3")
    axis.text(len(levels) - 0.55, 1.2, "tolerance", color="C3", ha="right", va="bottom")
    axis.set_yscale("log")
    axis.set_xticks(range(len(levels)), levels)
    axis.set_ylabel("difference / tolerance (below 1e-8 shown there)")
    axis.set_title(f"{len(report.rows)} comparisons of UFL kernels and the hand-written solver")
    axis.grid(True, axis="y", alpha=0.3)
    path = Path(folder) / "differences.png"
    figure.savefig(path, dpi=110)
    plt.close(figure)
    return path
