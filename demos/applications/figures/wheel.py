# SPDX-License-Identifier: MIT
"""Figures of wheel_on_rail: called on rank 0 with gathered fields."""

import numpy as np

from dolfinx_impact.io import plots

CMAP = "viridis"


def _grid(gathered, scale, shift=None):
    """Deformed grid; `value` is the von Mises stress [MPa], known at the vertices."""
    mises = gathered["mises"]
    moved = np.zeros(mises.points.shape)
    if shift is not None:
        moved[_bodies(mises), -1] = -shift
    out = plots.deformed_grid(mises, gathered["u"], scale, 1e-6, shift=moved)
    out.point_data["value"] = np.maximum(out.point_data["value"], 1e-3)  # the scale is logarithmic
    return out


def _bodies(field):
    """Mask of the wheel's nodes: those of the cells above the rail."""
    above = field.points[field.cells].mean(axis=1)[:, -1] > 0.0
    mask = np.zeros(len(field.points), dtype=bool)
    mask[field.cells[above].ravel()] = True
    return mask


def plane(run, gathered, a, p0, approach):
    """Deformed wheel and rail with the von Mises stress, and the contact in true scale."""
    plt = plots.pyplot()
    scale = 300
    figure, (left, right) = plt.subplots(1, 2, figsize=(11.5, 5.2), layout="constrained")
    whole, near = (0.3, 300.0), (0.0, round(0.56 * p0 / 1e6, -1))
    box = (-0.62, 0.62, -0.21, 0.97)
    grid = _grid(gathered, scale)
    title, label = f"displacement × {scale} (bore and foot are held)", "von Mises stress [MPa]"
    plots.show_grids(
        figure, left, [grid], whole, label, title, CMAP, box, log=True, size=(820, 780), above="#fde725"
    )  # fmt: skip
    r = 3.2 * a
    box = (-r, r, -r, r)
    title, grid = "the contact in true scale, wheel lowered by the approach", _grid(gathered, 1.0, approach)
    plots.show_grids(figure, right, [grid], near, label, title, CMAP, box, size=(760, 760))
    for side in (-a, a):
        right.axvline(side * 1e3, color="white", lw=0.8, ls="--")
    right.text(0, -0.93 * r * 1e3, f"patch: 2a = {2 * a * 1e3:.2f} mm", color="white", ha="center", fontsize=10)
    plots.save(figure, run.file("wheel_on_rail_2d.png"))


def space(run, gathered, p0):
    """A quarter of wheel and rail, cut faces in front."""
    plt = plots.pyplot()
    figure, (left, right) = plt.subplots(1, 2, figsize=(11.5, 5.2), layout="constrained")
    clim, near = (0.3, 700.0), (0.0, round(0.6 * p0 / 1e6, -1))
    scale = 300
    view = ((-1, -1.5, 0.45), (0, 0, 1), (0.14, 0, 0.365))
    title, label = f"a quarter of wheel and rail, displacement × {scale}", "von Mises stress [MPa]"
    grid, size = _grid(gathered, scale), (760, 760)
    plots.show_grids(figure, left, [grid], clim, label, title, CMAP, log=True, size=size, view=view, zoom=1.03)
    r = 0.02
    grid = _grid(gathered, 1.0)
    grid = grid.clip_box((-1e-3, r, -1e-3, r, -r, r), invert=False)
    view = ((-1, -1.5, 0.45), (0, 0, 1), (0.4 * r, 0.4 * r, 0))
    title = "20 mm around the contact, true scale"
    plots.show_grids(figure, right, [grid], near, label, title, CMAP, size=size, view=view, zoom=1.2, edges=False)
    plots.save(figure, run.file("wheel_on_rail_3d.png"))


def lines(run, flat, solid, curves, a, p0, radius):
    """The two solvers on the vertical axis, and what Hertz says below and beside the patch."""
    plt = plots.pyplot()
    figure, axes = plt.subplots(2, 2, figsize=(10.5, 7.4), layout="constrained")
    (top_left, top_right), (low_left, low_right) = axes
    ours, hand, mark = plots.COLOURS[0], plots.COLOURS[1], "o"
    for case, dimension, style, colour in ((flat, "plane strain", "-", ours), (solid, "3D", "--", plots.COLOURS[2])):
        field, theirs = case["field"], case["by_hand"]
        on_axis = np.flatnonzero(np.all(np.abs(field.points[:, :-1]) < 1e-9, axis=1) & (field.points[:, -1] < 0.4))
        y = field.points[on_axis, -1]
        order = on_axis[np.lexsort((field.values[on_axis, -1], np.round(y, 9)))]
        y, mine, other = field.points[order, -1] * 1e3, field.values[order, -1] * 1e6, theirs[order, -1] * 1e6
        wheel = np.argmax(np.diff(mine)) + 1  # the jump: rail below, wheel from here on
        for body, label in ((slice(0, wheel), f"DOLFINx, {dimension}"), (slice(wheel, None), None)):
            top_left.plot(y[body], mine[body], color=ours, ls=style, label=label, zorder=1)
        some = np.unique(np.linspace(0, len(y) - 1, 36).astype(int))
        label = "hand-written" if case is flat else None
        top_left.plot(y[some], other[some], mark, ms=4, mfc="none", color=hand, label=label)
        relative = np.abs(mine - other) / np.abs(theirs).max() / 1e6
        relative = np.maximum(relative, 1e-17)
        top_right.semilogy(y, relative, style, marker=".", ms=4, lw=0.8, color=colour, label=dimension)
    top_left.set(
        xlabel="height above the contact [mm]",
        ylabel="vertical displacement [µm]",
        title="both solvers, on the axis of the wheel",
    )
    top_right.set(
        xlabel="height above the contact [mm]", ylabel="|difference| / largest displacement [1]",
        title="their difference (zeros drawn at 1e-17)", ylim=(5e-18, 1e-9),
    )  # fmt: skip
    z = np.linspace(0, 6, 300)
    low_left.plot(z, z - z**2 / np.sqrt(1 + z**2), color=ours, label="Hertz, half-plane")
    low_left.plot(curves["depth"] / a, curves["tau"] / p0, mark, ms=4, mfc="none", color=hand, label="finite elements")
    low_left.set(
        xlabel="depth below the patch, z / a [1]",
        ylabel="largest shear stress / p0 [1]",
        xlim=(0, 6),
        ylim=(0, 0.34),
        title="shear below the patch",
    )
    s = np.linspace(1, 3)
    outside = s * np.sqrt(s**2 - 1) - np.log(s + np.sqrt(s**2 - 1))
    unit = a**2 / (2 * radius) * 1e6
    low_right.plot(np.r_[-s[::-1], s], unit * np.r_[outside[::-1], outside], color=ours, label="Hertz")
    low_right.plot(curves["x"] / a, curves["gap"] * 1e6, mark, ms=4, mfc="none", color=hand, label="finite elements")
    low_right.set(
        xlabel="x / a [1]",
        ylabel="distance of the deformed surfaces [µm]",
        xlim=(-3, 3),
        title="the pressed surfaces fit",
    )
    for ax in axes.ravel():
        ax.legend(fontsize=9)
    plots.save(figure, run.file("two_solvers.png"))
