# SPDX-License-Identifier: MIT
"""HTML page and pictures of the checks of a form of one's own."""

from __future__ import annotations

import re
from html import escape
from pathlib import Path
from typing import Any

from dolfinx_impact.io.hdf5 import write_whole
from dolfinx_impact.io.run_folder import versions
from ..html import STYLE
from .findings import Finding, Picture, SelfCheckReport

MORE = """
.none { color: #8a6d00; } td.s { min-width: 20em; }
"""


def write(report: SelfCheckReport, path: Path | str) -> Path:
    """Write the page, and its pictures beside it.

    Args:
        report: findings and the numbers of the pictures.
        path: file to write.

    Returns:
        The file.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    made = [f for f in report.findings if f.applies]
    failed = [f for f in made if not f.passed]
    verdict = '<span class="pass">every check that applies passed</span>'
    if not report.passed:
        text = f"{len(failed)} of {len(made)} checks failed" if failed else "nothing was checked"
        verdict = f'<span class="fail">{text}</span>'
    with_versions = ", ".join(f"{k} {v}" for k, v in versions().items())
    out = [f"<!doctype html><meta charset='utf-8'><title>{report.title}</title><style>{STYLE}{MORE}</style>"]
    out.append(f"<h1>{report.title}</h1><p>{verdict}. {escape(with_versions)}.</p>")
    if failed:
        out.append("<h2>What failed</h2>" + _table(failed))
    groups: dict[str, list[Finding]] = {}
    for f in report.findings:
        groups.setdefault(f"{f.form} on {f.cell}s of degree {f.degree}", []).append(f)
    for title, findings in groups.items():
        out.append(f"<h2>{escape(title)}</h2>" + _table(findings))
        if report.pictures.get(title):
            file = _draw(report.pictures[title], path.parent / f"{re.sub('[^A-Za-z0-9]+', '_', title)}.png")
            out.append(f"<img src='{escape(file.name)}' alt='numbers of the checks: {escape(title)}'>")
    write_whole(path, "\n".join(out) + "\n")
    return path


def _table(findings: list[Finding]) -> str:
    rows = []
    for f in findings:
        mark = {"pass": "pass", "FAIL": "fail"}.get(f.status, "none")
        numbers = [f"{f.difference:.1e}", f"{f.tolerance:.0e}"] if f.applies else ["", ""]
        cells = [f"<td>{escape(f.name)}</td>", f'<td class="{mark}">{escape(f.status)}</td>']
        cells += [f'<td class="n">{n}</td>' for n in numbers]
        rows.append("<tr>" + "".join(cells) + f'<td class="s">{escape(f.note)}</td><td>{escape(f.reason)}</td></tr>')
    head = "".join(f"<th>{h}</th>" for h in ("check", "", "found", "tolerance", "what it says", "tolerance from"))
    return f"<table><tr>{head}</tr>{''.join(rows)}</table>"


def _draw(pictures: list[Picture], path: Path) -> Path:
    """One picture with a panel for each check that has numbers."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.ticker import NullLocator

    columns = min(len(pictures), 3)
    rows = -(-len(pictures) // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(4.6 * columns, 3.6 * rows), squeeze=False, layout="constrained")
    for axis, picture in zip(axes.ravel(), pictures):
        for k, curve in enumerate(picture.curves):
            style: dict[str, Any] = {"marker": "o", "ms": 3} if len(curve.x) < 50 else {"lw": 1.5}
            if curve.label in ("tolerance", "counts as zero"):
                style = {"ls": "--", "color": "0.5"}
            (line,) = axis.plot(curve.x, curve.y, label=curve.label, **style)
            if curve.slope is not None:
                theory = 0.6 * curve.y[-1] * (curve.x / curve.x[-1]) ** curve.slope
                axis.plot(curve.x, theory, ":", color=line.get_color(), label=f"slope {curve.slope:g}")
        axis.set_yscale("log")
        if not picture.points:
            axis.set_xscale("log" if any(c.slope is not None for c in picture.curves) else "linear")
        if any(c.slope is not None for c in picture.curves):
            x = picture.curves[0].x
            axis.set_xticks(x, [f"{v:g}" if v >= 1 else f"1/{1 / v:g}" for v in x])
            axis.xaxis.set_minor_locator(NullLocator())
        elif not picture.points:
            axis.set_xticks(picture.curves[0].x)
        axis.set_title(picture.title, fontsize=10)
        axis.set_xlabel(picture.xlabel)
        axis.set_ylabel(picture.ylabel)
        axis.grid(True, alpha=0.25)
        axis.legend(fontsize=8)
    for axis in axes.ravel()[len(pictures) :]:
        axis.remove()
    figure.savefig(path, dpi=110)
    plt.close(figure)
    return path
