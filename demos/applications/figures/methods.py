# SPDX-License-Identifier: MIT
"""Figure of implicit_or_explicit: called on rank 0 with plain arrays."""

import numpy as np

from dolfinx_impact.io import plots

MARKS = ("o", "s", "^", "D")


def work_and_error(run, titles, methods, results):
    """Forces of the finest runs over time; error over CPU time of all runs.

    Args:
        titles: title of each case, by name.
        methods: names of the methods.
        results: (case, method) -> list of Results, from coarse to fine.
    """
    plt = plots.pyplot()
    figure, axes = plt.subplots(2, len(titles), figsize=(4.3 * len(titles), 7.2), layout="constrained")
    for (name, title), (upper, lower) in zip(titles.items(), axes.T):
        for k, method in enumerate(methods):
            found = results[name, method]
            style = {"color": plots.COLOURS[k % len(plots.COLOURS)], "label": method}
            upper.plot(found[-1].times, found[-1].forces, lw=1.0, **style)
            lower.loglog([r.seconds for r in found], [r.error for r in found], marker=MARKS[k], ms=5, lw=1.2, **style)
        upper.set(title=title, xlabel="time", ylabel="contact force / exact")
        lower.set(xlabel="CPU time of the steps [s]", ylabel="error")
        for axis in (lower.xaxis, lower.yaxis):
            axis.set_minor_formatter("")
        low, high = lower.get_xlim()
        lower.set_xlim(10 ** np.floor(np.log10(low)), 10 ** np.ceil(np.log10(high)))
        low, high = lower.get_ylim()
        lower.set_ylim(10 ** np.floor(np.log10(low)), 10 ** np.ceil(np.log10(high)))
        lower.grid(True, which="both", lw=0.3)
    axes[0, 0].set_ylim(-0.1, 1.6)
    axes[1, 0].legend(fontsize=8, loc="lower center")
    plots.save(figure, run.file("implicit_or_explicit.png"))
