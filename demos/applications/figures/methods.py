# SPDX-License-Identifier: MIT
"""Figure of implicit_or_explicit: called on rank 0 with plain arrays."""

import numpy as np

from dolfinx_impact.io import plots

MARKS = ("o", "s", "^", "D")
# Forces of several methods lie on each other: each line is narrower than the one below it, which shows on both sides.
WIDTHS = (5.0, 3.2, 1.8, 0.8)


def work_and_error(run, cases, methods, results):
    """Forces of the finest runs over time; error over CPU time of all runs.

    Args:
        cases: each case, by name.
        methods: names of the methods.
        results: (case, method) -> list of Results, from coarse to fine.
    """
    plt = plots.pyplot()
    figure, axes = plt.subplots(2, len(cases), figsize=(4.3 * len(cases), 7.6), layout="constrained")
    for (name, case), (upper, lower) in zip(cases.items(), axes.T):
        for k, method in enumerate(methods):
            found = results[name, method]
            style = {"color": plots.COLOURS[k % len(plots.COLOURS)], "label": method}
            width = WIDTHS[k % len(WIDTHS)]
            upper.plot(found[-1].times, found[-1].forces, lw=width, **style)
            lower.loglog([r.seconds for r in found], [r.error for r in found], marker=MARKS[k], ms=5, lw=1.2, **style)
        upper.set(title=case.title, xlabel=case.clock, ylabel="contact force / exact [1]")
        lower.set(xlabel="CPU time of the steps [s]", ylabel="error [1]")
        for axis in (lower.xaxis, lower.yaxis):
            axis.set_minor_formatter("")
        low, high = lower.get_xlim()
        lower.set_xlim(10 ** np.floor(np.log10(low)), 10 ** np.ceil(np.log10(high)))
        low, high = lower.get_ylim()
        lower.set_ylim(10 ** np.floor(np.log10(low)), 10 ** np.ceil(np.log10(high)))
        lower.grid(True, which="both", lw=0.3)
    axes[0, 0].set_ylim(-0.1, 1.6)
    forces, errors = axes[0, 0].get_legend_handles_labels()[0], axes[1, 0].get_legend_handles_labels()
    handles = [(a, b) for a, b in zip(forces, errors[0])]
    figure.legend(handles, errors[1], ncols=len(handles), fontsize=9, loc="outside lower center")
    plots.save(figure, run.file("implicit_or_explicit.png"))
