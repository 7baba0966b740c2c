# SPDX-License-Identifier: MIT
"""HTML page and pictures of the checks of a form of one's own."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from dolfinx_impact.io.html_page import write_page
from dolfinx_impact.io.run_folder import versions
from .findings import Finding, Picture, SelfCheckReport


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
    groups: dict[str, list[Finding]] = {}
    for f in report.findings:
        groups.setdefault(f"{f.form} on {f.cell}s of degree {f.degree}", []).append(f)
    pictures = {
        title: _draw(report.pictures[title], path.parent / f"{re.sub('[^A-Za-z0-9]+', '_', title)}.png").name
        for title in groups
        if report.pictures.get(title)
    }
    write_page(
        path, "impact_verify", "self_check.html.jinja", title=report.title, heading=report.title,
        passed=report.passed, failed=failed, num_made=len(made), groups=groups, pictures=pictures,
        versions=", ".join(f"{name} {version}" for name, version in versions().items()),
    )  # fmt: skip
    return path


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
