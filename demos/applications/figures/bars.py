# SPDX-License-Identifier: MIT
"""Figures of impact_bars: called on rank 0 with plain arrays."""

import numpy as np

from dolfinx_impact.io import plots
from dolfinx_impact.theory import waves

STYLES = {"penalty": plots.COLOURS[0], "kinematic": plots.COLOURS[1]}
GREY = plots.COLOURS[3]


def _exact(case, times):
    """Velocities and displacements of the bars' ends at the contact: times after first touch -> two lists."""
    faces = (-1e-12 * case.length,) if case.second is None else (-1e-12 * case.length, 1e-12 * case.length)
    fine = np.linspace(times[0], times[-1], 4001)
    second = (case.second or ())[2:]
    velocities = [waves.bar_waves(x, fine, *case.bars, *second)[1] + case.frame for x in faces]
    places = []
    for v in velocities:
        way = np.concatenate([[0.0], np.cumsum(np.diff(fine) * (v[1:] + v[:-1]) / 2)])
        places.append(way - np.interp(0.0, fine, way))
    return fine, places, velocities


def histories(run, cases):
    """Contact stress, place and velocity of the ends at the contact over time, beside the exact solution.

    Args:
        cases: list of (Case, dict of method -> (force, ends) of Impact, lag of the springs as a time).
    """
    plt = plots.pyplot()
    figure, axes = plt.subplots(3, len(cases), figsize=(4.2 * len(cases), 8.4), layout="constrained", sharex=True)
    for (case, found, lag), (stress, place, speed) in zip(cases, axes.T):
        T, first = case.exact.release_time, case.gap / case.velocity
        fine, places, velocities = _exact(case, np.array([-0.15, 1.3]) * T)
        tau, scale = fine / T, case.velocity * T / 2
        stress.plot(tau, (tau > 0) & (tau < 1), color=GREY, lw=2.2, alpha=0.5, label="exact")
        stress.plot(tau, waves.contact_pulse(fine, T, lag, case.echo), "--", color="k", lw=0.9, label="with a spring")
        for x, v in zip(places, velocities):
            place.plot(tau, x / scale, color=GREY, lw=2.2, alpha=0.5)
            speed.plot(tau, v / case.velocity, color=GREY, lw=2.2, alpha=0.5)
        for method, (force, rows) in found.items():
            t, colour = (rows[:, 0] - first) / T, STYLES[method]
            stress.plot((force[:, 0] - first) / T, force[:, 1] / case.exact.stress, color=colour, lw=1.1, label=method)
            for k, style in zip(range(1, rows.shape[1], 2), ("-", ":")):
                start = (case.velocity + case.frame, case.frame)[k // 2] * first
                place.plot(t, (rows[:, k] - start) / scale, style, color=colour, lw=1.1)
                speed.plot(t, rows[:, k + 1] / case.velocity, style, color=colour, lw=1.1)
        stress.set_title(case.title, fontsize=10)
        speed.set_xlabel("time after first touch / T")
        shown = np.concatenate(places) / scale
        place.set_ylim(shown.min() - 0.05, shown.max() + 0.1)
        stress.set(xlim=(-0.15, 1.3), ylim=(-0.1, 1.35))
    axes[0, 0].set_ylabel("contact stress / exact")
    axes[1, 0].set_ylabel("place of the ends / (v L/c)")
    axes[2, 0].set_ylabel("velocity of the ends / v")
    axes[0, 0].legend(fontsize=8, loc="lower center")
    plots.save(figure, run.file("impact_bars.png"))


def convergence(run, impact, profiles, table):
    """Profiles along equal bars, and L2 errors over the cells' length with what was expected.

    Args:
        impact: case and time of the profiles. profiles: method -> rows of Impact.rows.
        table: method -> rows of h/L, errors of stress and velocity, expected error.
    """
    plt = plots.pyplot()
    figure, ((stress, speed), right) = _layout(plt)
    case, x = impact.case, np.linspace(-impact.case.length, impact.case.second[2], 4001)
    exact = impact.exact_profile(np.where(x < 0, x - case.gap, x))
    unit = 1 / case.length
    for ax, values, scale in ((stress, exact[0], case.exact.stress), (speed, exact[1], case.velocity / 2)):
        ax.plot(x * unit, values / scale, color=GREY, lw=2.2, alpha=0.5, label="exact")
    for method, rows in profiles.items():
        middle = rows[:, :2].mean(axis=1) * unit
        stress.plot(middle, rows[:, 2] / case.exact.stress, color=STYLES[method], lw=1.1, label=method)
        speed.plot(middle, rows[:, 3:].mean(axis=1) / (case.velocity / 2), color=STYLES[method], lw=1.1)
    stress.set(ylabel="stress / (ρ c v)", title=f"two thirds through the contact, {len(rows) // 2} cells in each bar")
    stress.title.set_fontsize(10)
    speed.set(ylabel="velocity / v", xlabel="x / L")
    stress.legend(fontsize=9, loc="lower center")
    for method, rows in table.items():
        rows = np.array(rows)
        colour = STYLES[method]
        right.loglog(rows[:, 0], rows[:, 1], "o", mfc="none", color=colour, label=f"stress, {method}")
        right.loglog(rows[:, 0], rows[:, 2], "s", mfc="none", ms=5, color=colour, label=f"velocity, {method}")
        right.loglog(rows[:, 0], rows[:, 3], "-", color=colour, lw=1, label=f"expected, {method}")
    h = rows[[0, -1], 0]
    for order, start, text in ((1 / 2, 1.25, "1/2"), (1 / 3, 0.72, "1/3")):
        first = np.array(table["penalty" if order == 1 / 2 else "kinematic"])[0, 3] * start
        right.loglog(h, first * (h / h[0]) ** order, ":", color="k", lw=1)
        right.annotate(
            f"slope {text}", (np.sqrt(h.prod()), first * (h[1] / h[0]) ** (order / 2)), ((-8, 6), (8, -14))[start < 1],
            textcoords="offset points", ha="right" if start > 1 else "left", fontsize=9,
        )  # fmt: skip
    right.set(xlabel="length of a cell / L", ylabel="L2 error / (jump behind the wave)")
    right.set_title("convergence to the wave equation", fontsize=10)
    right.legend(fontsize=8)
    plots.save(figure, run.file("impact_bars_convergence.png"))


def _layout(plt):
    figure = plt.figure(figsize=(12, 5.4), layout="constrained")
    left, right = figure.subfigures(1, 2, width_ratios=(1.15, 1))
    return figure, (left.subplots(2, 1, sharex=True), right.subplots())
