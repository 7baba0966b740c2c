# SPDX-License-Identifier: MIT
"""Figures of rail_joint_plane: called on rank 0 with plain arrays and gathered fields."""

import numpy as np

from dolfinx_impact.io import plots

MM = 1e3


def force(run, history, reference, load, quiet):
    """Contact force over the place of the wheel, with the peak."""
    plt = plots.pyplot()
    figure, (up, along) = plt.subplots(
        2, 1, figsize=(8.5, 5.6), layout="constrained", sharex=True, height_ratios=(2.4, 1)
    )
    x, f = history[:, 1] * MM, history[:, 3] / load
    up.plot(reference[:, 1] * MM, reference[:, 3] / load, color=plots.COLOURS[3], lw=1.2, label="rail without a joint")
    up.plot(x, f, color=plots.COLOURS[0], lw=1.6, label="rail joint")
    top = f.argmax()
    up.plot(x[top], f[top], "o", color=plots.COLOURS[1], ms=6)
    up.annotate(
        f"{f[top]:.2f} times the load", (x[top], f[top]), (0, 9), textcoords="offset points", ha="center",
        color=plots.COLOURS[1],
    )  # fmt: skip
    up.set(ylabel="contact force / load [1]", ylim=(min(0.4, f.min() - 0.1), f[top] + 0.25))
    up.legend(loc="upper left")
    seconds = up.secondary_xaxis("top", functions=(lambda v: _time(history, v), lambda t: _place(history, t)))
    seconds.set_xlabel("time [ms]")
    along.plot(x, history[:, 2] / load, color=plots.COLOURS[2], lw=1.4)
    along.set(xlabel="place of the axle, the joint at 0 [mm]", ylabel="friction / load [1]")
    for ax in (up, along):
        ax.axvspan(-4, 4, color="#f0e4d8", zorder=0, lw=0)
    plots.save(figure, run.file("rail_joint_plane_force.png"))


def _line(history):
    (t0, x0), (t1, x1) = history[0, :2] * MM, history[-1, :2] * MM
    return t0, x0, (x1 - x0) / (t1 - t0)


def _time(history, x):
    t0, x0, v = _line(history)
    return t0 + (x - x0) / v


def _place(history, t):
    t0, x0, v = _line(history)
    return x0 + (t - t0) * v


def energy(run, place, columns, balance, exchanged):
    """Changes of the energies, and what their balance misses."""
    plt = plots.pyplot()
    figure, (parts, rest) = plt.subplots(
        2, 1, figsize=(8.5, 5.6), layout="constrained", sharex=True, height_ratios=(2.4, 1)
    )
    unit = columns["kinetic"][1]
    styles = (
        ("kinetic", plots.COLOURS[0], "-"), ("internal", plots.COLOURS[1], "-"), ("external", plots.COLOURS[3], "--"),
        ("contact", plots.COLOURS[2], "-"), ("friction", "#7a3b8f", "-"),
    )  # fmt: skip
    labels = {"external": "external (work of the load)", "contact": "contact (springs)"}
    for name, colour, style in styles:
        parts.plot(place * MM, columns[name][0], style, color=colour, lw=1.5, label=labels.get(name, name))
    parts.set(ylabel=f"change since the start [{unit}]")
    parts.legend(fontsize=9, ncols=2)
    rest.plot(place * MM, balance / exchanged, color=plots.COLOURS[0], lw=1.2)
    rest.set(xlabel="place of the axle, the joint at 0 [mm]", ylabel="drift / exchanged [1]")
    rest.ticklabel_format(axis="y", style="sci", scilimits=(0, 0))
    plots.save(figure, run.file("rail_joint_plane_energy.png"))


def sequence(run, pictures, history):
    """Von Mises stress around the contact at the moments."""
    plt = plots.pyplot()
    figure, axes = plt.subplots(2, 3, figsize=(12.5, 6.2), layout="constrained")
    clim = (0.0, 500.0)
    box = (-0.045, 0.045, -0.036, 0.034)
    for ax, (place, mises, u) in zip(axes.ravel(), pictures):
        grid = plots.deformed_grid(mises, u, factor=1e-6)
        image = plots.draw([grid], clim, size=(900, 700), box=box, above="#fff3b0", edges=False)
        plots.show(ax, image, [v * MM for v in box])
        now = np.interp(place, history[:, 0], history[:, 1])
        ax.set_title(f"axle at {place * MM:+.1f} mm, force {now:.2f} of the load", fontsize=10)
    plots.colour_bar(figure, axes, clim, "von Mises stress [MPa]", shrink=0.7, extend="max")
    plots.save(figure, run.file("rail_joint_plane_sequence.png"))
