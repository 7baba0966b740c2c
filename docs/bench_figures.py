# SPDX-License-Identifier: MIT
"""Figures and table of docs/bench_history.md and docs/performance.md: `python3 docs/bench_figures.py [FOLDER]`.

FOLDER is docs/figures unless given. Reads docs/bench_history.csv, which `make bench` appends to, and writes
bench_history.png, ratios over runs, and bench_history.txt, a table per processor. Where results/bench.json of a run is
there, writes roofline.png, too, and static_contact.png of a run with --large.
"""

import json
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import matplotlib.pyplot as plt  # noqa: E402
from demo_figures import shrink  # noqa: E402

from impact_studies.bench import ratio_history  # noqa: E402
from impact_studies.bench.contact_rows import SOLVE  # noqa: E402
from impact_studies.bench.roofline import KernelTime  # noqa: E402
from impact_studies.bench.rows import BANDWIDTH, PEAK  # noqa: E402

CELLS = ("triangle", "quadrilateral", "tetrahedron", "hexahedron")


def by_processor(lines):
    """Lines of each processor, in the order in which processors appear."""
    out = {}
    for line in lines:
        out.setdefault(line["processor"], []).append(line)
    return out


def table(lines):
    """Text: for each processor its rows, with the ratio of the last run, the lowest, the highest and how many runs."""
    out = []
    for processor, own in by_processor(lines).items():
        out += [processor, f"{'name':56s} {'cell':34s} {'last':>7s} {'lowest':>7s} {'highest':>7s} {'runs':>5s}"]
        for (name, cell), runs in ratio_history.by_row(own).items():
            ratios = [ratio for _, ratio in runs]
            numbers = f"{ratios[-1]:7.3g} {min(ratios):7.3g} {max(ratios):7.3g} {len(ratios):5d}"
            out.append(f"{name:56s} {cell:34s} {numbers}")
        out.append("")
    return "\n".join(out)


def figure(lines):
    """Ratios over runs, each relative to its first one, for each processor; rows that moved most have names."""
    processors = by_processor(lines)
    plot, axes = plt.subplots(
        len(processors), 1, figsize=(9, 3.6 * len(processors)), layout="constrained", squeeze=False
    )
    for ax, (processor, own) in zip(axes[:, 0], processors.items()):
        rows = ratio_history.by_row(own)
        dates = list(dict.fromkeys((line["date"], line["commit"]) for line in own))
        change = {
            key: max(abs(ratio / runs[0][1] - 1.0) for _, ratio in runs) for key, runs in rows.items() if runs[0][1]
        }
        named = sorted(change, key=change.__getitem__, reverse=True)[:8]
        for key in change:
            runs = rows[key]
            relative = [ratio / runs[0][1] for _, ratio in runs]
            start = len(dates) - len(runs)  # rows that were added later end with the others
            style = {"label": ", ".join(key)} if key in named else {"color": "0.8", "zorder": 0}
            ax.plot(range(start, len(dates)), relative, "o-", markersize=3, linewidth=1, **style)
        # Of the date what fits beside its neighbours: months and days; the commit says the rest.
        labels = [" ".join((date[5:10], commit)) for date, commit in dates]
        ax.set_xticks(range(len(dates)), labels, fontsize=7, rotation=30, ha="right", rotation_mode="anchor")
        ax.set(title=processor, ylabel="ratio over that of the first run [1]")
        ax.grid(alpha=0.3)
        ax.legend(fontsize=6, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return plot


def applied_forces(rows):
    """Operations per byte and GFLOP/s of forces of whole meshes, by cell and degree, from a run's rows."""
    rate, traffic = (
        {
            (r["cell"], r["name"].removesuffix(f": {what}")): r["value"]
            for r in rows
            if r["name"].endswith(f" force: {what}")
        }
        for what in (PEAK, BANDWIDTH)
    )
    return [(cell, rate[cell, name] / traffic[cell, name], rate[cell, name]) for cell, name in rate]


def roofline(run):
    """Kernels alone, a point each, and forces of whole meshes, under the limits of processor, cache and memory."""
    about, times = run["machine"], [KernelTime(**k) for k in run["kernels"]]
    plot, ax = plt.subplots(figsize=(9, 5), layout="constrained")
    forces = applied_forces(run["rows"])
    intensities = [t.intensity for t in times] + [x for _, x, _ in forces]
    peak, ends = about["peak_GFLOP_per_s"], (0.5 * min(intensities), 2.0 * max(intensities))
    for name, bandwidth, style in (
        ("first-level cache", run["cache_GB_per_s"], "-"),
        ("memory", about["triad_GB_per_s"], "--"),
    ):
        knee = peak / bandwidth
        x = sorted({*ends, min(max(knee, ends[0]), ends[1])})
        label = f"{name}, {bandwidth:.0f} GB/s; one core, {peak:.0f} GFLOP/s"
        ax.plot(x, [min(peak, bandwidth * i) for i in x], f"k{style}", linewidth=1, label=label)
    for cell, colour in zip(CELLS, plt.rcParams["axes.prop_cycle"].by_key()["color"]):
        own = [t for t in times if t.cell.startswith(cell)]
        points = {"color": colour, "linestyle": "none"}
        ax.plot(
            [t.intensity for t in own], [t.rate * 1e-9 for t in own], marker=".", label=f"{cell}, a kernel", **points
        )
        whole = [(x, y) for c, x, y in forces if c.startswith(cell)]
        ax.plot([x for x, _ in whole], [y for _, y in whole], marker="D", markerfacecolor="none",
                label=f"{cell}, the force of a mesh", **points)  # fmt: skip
    ax.set(xscale="log", yscale="log", xlabel="operations per byte of arguments, or of memory [1/B]", ylabel="GFLOP/s",
           title=f"{about['processor']}, vectors of {about['vector_width']}")  # fmt: skip
    ax.grid(alpha=0.3, which="both")
    ax.legend(fontsize=7, loc="lower right")
    return plot


def static_sizes(rows):
    """Unknowns of static contact in space, its time and that of the tied bodies [s], by size."""
    found = [r for r in rows if r["name"] == SOLVE and r["cell"].startswith("hexahedron")]
    return sorted((int(r["cell"].split()[-2]), r["value"], r["baseline"]) for r in found)


def static_contact(rows):
    """Time of static contact in space, and of the tied bodies, over the number of unknowns."""
    sizes, ours, tied = zip(*static_sizes(rows))
    plot, ax = plt.subplots(figsize=(6, 4), layout="constrained")
    ax.plot(sizes, ours, "o-", label="contact, from first touch to Hertz's pressure")
    ax.plot(sizes, tied, "s--", label="one linear solve of the bodies tied together")
    ax.plot(sizes, [tied[0] * n / sizes[0] for n in sizes], "k:", linewidth=1, label="proportional to the size")
    ax.set(xscale="log", yscale="log", xlabel="unknowns, hexahedra of degree 1", ylabel="time on one core [s]")
    ax.grid(alpha=0.3, which="both")
    ax.legend(fontsize=8)
    return plot


def main(folder=HERE / "figures"):
    lines = ratio_history.read(HERE / "bench_history.csv")
    target = Path(folder)
    (target / "bench_history.txt").write_text(table(lines))
    path = target / "bench_history.png"
    figure(lines).savefig(path, dpi=110)
    shrink(path, path)
    run = HERE.parent / "results" / "bench.json"
    if run.exists():
        found = json.loads(run.read_text())
        pictures = {"roofline": roofline(found)}
        if len(static_sizes(found["rows"])) > 1:
            pictures["static_contact"] = static_contact(found["rows"])
        for name, plot in pictures.items():
            path = target / f"{name}.png"
            plot.savefig(path, dpi=110)
            shrink(path, path)


if __name__ == "__main__":
    main(*sys.argv[1:])
