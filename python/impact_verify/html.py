# SPDX-License-Identifier: MIT
"""HTML page and figures of a verification run."""

from pathlib import Path

from dolfinx_impact.io.html_page import write_page
from dolfinx_impact.io.run_folder import versions
from .report import Report, Row, row_label


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
    figures = []
    for title, file in report.figures:
        figure = Path(file)
        beside = figure.parent.resolve() == path.parent.resolve()
        figures.append((title, figure.name if beside else str(figure)))
    levels: dict[str, list[Row]] = {}
    for row in report.rows:
        levels.setdefault(row.level, []).append(row)
    write_page(
        path, "impact_verify", "cross_check.html.jinja", title="Cross-verification",
        heading="UFL kernels against the hand-written solver",
        report=report, failed=report.failures(), levels=levels, figures=figures, label_of=row_label,
        versions=", ".join(f"{name} {version}" for name, version in versions().items()),
    )  # fmt: skip
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
