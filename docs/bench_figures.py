# SPDX-License-Identifier: MIT
"""Figure and table of docs/bench_history.md: `python3 docs/bench_figures.py [FOLDER]`, default docs/figures.

Reads docs/bench_history.csv, which `make bench` appends to, and writes bench_history.png, ratios over runs, and
bench_history.txt, a table per processor.
"""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import matplotlib.pyplot as plt  # noqa: E402
from demo_figures import shrink  # noqa: E402

from impact_studies.bench import ratio_history  # noqa: E402


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
        ax.set_xticks(range(len(dates)), [f"{date[:10]}\n{commit}" for date, commit in dates], fontsize=7)
        ax.set(title=processor, ylabel="ratio over that of the first run [1]")
        ax.grid(alpha=0.3)
        ax.legend(fontsize=6, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return plot


def main(folder=HERE / "figures"):
    lines = ratio_history.read(HERE / "bench_history.csv")
    target = Path(folder)
    (target / "bench_history.txt").write_text(table(lines))
    path = target / "bench_history.png"
    figure(lines).savefig(path, dpi=110)
    shrink(path, path)


if __name__ == "__main__":
    main(*sys.argv[1:])
