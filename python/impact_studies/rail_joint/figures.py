# SPDX-License-Identifier: MIT
"""Pictures of a passage over a rail joint; called on rank 0 with plain arrays and gathered fields."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.signal import butter, sosfiltfilt

from dolfinx_impact.common.types import FilePath, FloatArray
from dolfinx_impact.io import plots
from dolfinx_impact.io.gather import Gathered
from .parameters import RailJoint
from .passage import Footprint, History
from .results import SLOW, Summary, low_pass

MM, MPA, KN = 1e3, 1e-6, 1e-3
VIEW = ((-0.55, -1.4, 0.55), (0, 0, 1))  # towards the viewer, up
WAVES = 20e3  # stations are shown without what is faster: cells of the coarse mesh carry no more [Hz]
ZONE = (0.055, 0.03, 0.035)  # half-length, width and depth of what pictures show [m]


@dataclass
class Picture:
    """Fields of one moment, gathered on rank 0.

    Attributes:
        place: of the wheel [m].
        displacement: [m].
        stress: von Mises stress [Pa].
    """

    place: float
    displacement: Gathered
    stress: Gathered


def _shade(axes: Any, data: RailJoint) -> None:
    half = 0.5 * data.gap * MM
    axes.axvspan(-half, half, color="#f0e4d8", zorder=0, lw=0)


def force(path: FilePath, data: RailJoint, history: History, summary: Summary) -> None:
    """Contact force over the place of the wheel.

    Args:
        path: PNG that is written.
        data: the joint.
        history: of the passage.
        summary: its numbers.
    """
    plt = plots.pyplot()
    figure, (up, along) = plt.subplots(
        2, 1, figsize=(8.5, 5.6), layout="constrained", sharex=True, height_ratios=(2.4, 1)
    )
    x, f = history.place * MM, history.force / data.load
    up.plot(x, f[:, 2], color=plots.COLOURS[0], lw=1.4, label="contact force")
    slow = low_pass(history)
    if slow is not None:
        up.plot(x, slow / data.load, color=plots.COLOURS[3], lw=1.2, label=f"below {SLOW:.0f} Hz")
    up.plot(summary.peak_place * MM, summary.dynamic_factor, "o", color=plots.COLOURS[1], ms=6)
    up.annotate(
        f"{summary.dynamic_factor:.3f} times the load", (summary.peak_place * MM, summary.dynamic_factor), (0, 9),
        textcoords="offset points", ha="center", color=plots.COLOURS[1],
    )  # fmt: skip
    low, high = f[:, 2].min(), f[:, 2].max()
    up.set(ylabel="contact force / load [1]", ylim=(low - 0.1 * (high - low), high + 0.2 * (high - low)))
    up.legend(loc="lower right")
    along.plot(x, f[:, 0], color=plots.COLOURS[2], lw=1.2)
    along.set(xlabel="place of the axle, the joint at 0 [mm]", ylabel="along / load [1]")
    for axes in (up, along):
        _shade(axes, data)
    plots.save(figure, path)


def footprints(path: FilePath, data: RailJoint, found: Sequence[Footprint]) -> None:
    """Contact areas with their pressures at some moments, the ellipse of Hertz beside them.

    Args:
        path: PNG that is written.
        data: the joint.
        found: footprints, up to six.
    """
    plt = plots.pyplot()
    figure, all_axes = plt.subplots(2, 3, figsize=(11, 5.8), layout="constrained", sharey=True)
    hertz, largest = data.hertz, max(float(f.pressure.max(initial=0.0)) for f in found) * MPA
    angle, marks = np.linspace(0.0, 2.0 * np.pi, 200), None
    for axes, f in zip(all_axes.ravel(), found):
        x, y, p = f.points[:, 0] * MM, f.points[:, 1] * MM, f.pressure * MPA
        if data.sides == 2:  # the other half
            off = y > 1e-6
            x, y, p = (np.concatenate([a, b[off]]) for a, b in ((x, x), (y, -y), (p, p)))
        size = (0.5 * data.cell_size * MM * 72 / 10) ** 2
        marks = axes.scatter(x, y, c=p, s=size, marker="s", cmap="viridis", vmin=0.0, vmax=largest)
        axes.plot(f.place * MM + hertz.a * MM * np.cos(angle), hertz.b * MM * np.sin(angle), "k:", lw=1)
        _shade(axes, data)
        middle = f.place * MM
        axes.set(xlim=(middle - 2 * hertz.a * MM, middle + 2 * hertz.a * MM), aspect="equal", xlabel="x [mm]")
        axes.set_title(f"axle at {middle:+.1f} mm", fontsize=10)
        axes.grid(False)
    all_axes[0, 0].set_ylabel("y [mm]")
    all_axes[1, 0].set_ylabel("y [mm]")
    figure.colorbar(marks, ax=all_axes, label="nodal pressure [MPa]", shrink=0.8)
    plots.save(figure, path)


def energies(path: FilePath, data: RailJoint, history: History) -> None:
    """Changes of the energies, and what their balance misses.

    Args:
        path: PNG that is written.
        data: the joint.
        history: of the passage.
    """
    plt = plots.pyplot()
    figure, (parts, rest) = plt.subplots(
        2, 1, figsize=(8.5, 5.6), layout="constrained", sharex=True, height_ratios=(2.4, 1)
    )
    x = history.place * MM
    changes = {name: values - values[0] for name, values in history.energy.items()}
    largest = max(float(np.abs(values).max()) for values in changes.values())
    for k, (name, values) in enumerate((n, v) for n, v in changes.items() if np.abs(v).max() > 1e-3 * largest):
        parts.plot(x, values, "--" if name == "external" else "-", color=f"C{k}", lw=1.4, label=name)
    parts.set(ylabel="change since the start [J]")
    parts.legend(fontsize=9, ncols=2)
    balance = sum(v for n, v in changes.items() if n != "external") - changes["external"]
    rest.plot(x, balance / largest, color=plots.COLOURS[0], lw=1.2)
    rest.set(xlabel="place of the axle, the joint at 0 [mm]", ylabel="missed / largest [1]")
    plots.save(figure, path)


def passages(path: FilePath, rows: Sequence[Mapping[str, Any]]) -> None:
    """Plastic strain after each passage and what the passage added, beside the largest force.

    Args:
        path: PNG that is written.
        rows: numbers of each passage, at least two, as Summary.as_dict.
    """
    plt = plots.pyplot()
    figure, (strain, gain, load) = plt.subplots(1, 3, figsize=(11, 3.4), layout="constrained")
    number = np.arange(1, len(rows) + 1)
    plastic = np.array([float(row["plastic_strain"]) for row in rows]) * 100.0
    strain.plot(number, plastic, "o-", color=plots.COLOURS[0], lw=1.2, ms=4)
    strain.set(ylabel="largest equivalent plastic strain [%]", ylim=(0.0, 1.1 * plastic.max()))
    added = np.diff(plastic, prepend=0.0)
    grows = added > 0.0
    gain.semilogy(number[grows], added[grows], "o-", color=plots.COLOURS[1], lw=1.2, ms=4)
    gain.set(ylabel="added by the passage [%]")
    factors = [float(row["dynamic_factor"]) for row in rows]
    load.plot(number, factors, "o-", color=plots.COLOURS[2], lw=1.2, ms=4)
    load.set(ylabel="largest force / load [1]", ylim=(min(factors) - 0.01, max(factors) + 0.01))
    load.ticklabel_format(useOffset=False)
    for axes in (strain, gain, load):
        axes.set(xlabel="passage", xlim=(0.5, len(rows) + 0.5))
        axes.xaxis.get_major_locator().set_params(integer=True)
    plots.save(figure, path)


def rail_ends(path: FilePath, data: RailJoint, ends: FloatArray) -> None:
    """Heights of the rail ends below those at the start.

    Args:
        path: PNG that is written.
        data: the joint.
        ends: place of the wheel and vertical displacement of both ends, (n, 3) [m].
    """
    plt = plots.pyplot()
    figure, axes = plt.subplots(figsize=(8.5, 3.6), layout="constrained")
    for k, name in ((1, "end of the first rail"), (2, "end of the second rail")):
        axes.plot(ends[:, 0] * MM, (ends[:, k] - ends[0, k]) * 1e6, color=plots.COLOURS[k - 1], lw=1.4, label=name)
    axes.set(xlabel="place of the axle, the joint at 0 [mm]", ylabel="height since the start [µm]")
    axes.legend()
    _shade(axes, data)
    plots.save(figure, path)


def waves(path: FilePath, data: RailJoint, time: FloatArray, stations: FloatArray, velocity: FloatArray) -> None:
    """Longitudinal velocities at stations along the second rail, and when (3.80)'s waves pass from one to the next.

    The load goes over to the second rail within a millisecond: there is no front. Marked is the lowest velocity of each
    station; the lines say when waves that leave the first station with its lowest velocity pass the others.

    Args:
        path: PNG that is written.
        data: the joint.
        time: since the start, (n) [s].
        stations: places along the rail, (m) [m].
        velocity: along the rail, (n, m) [m/s].
    """
    plt = plots.pyplot()
    figure, axes = plt.subplots(figsize=(8.5, 4.2), layout="constrained")
    shown, filtered = _low_pass(time, velocity)
    shown = 1e3 * (shown - shown[0])
    spacing = float(_round_up(np.ptp(shown, axis=0).max(initial=0.0) or 1.0))
    levels = spacing * np.arange(len(stations))
    lowest = shown.argmin(axis=0)
    for k in range(len(stations)):
        axes.plot(time * MM, shown[:, k] + levels[k], color=f"C{k}", lw=1.2)
        axes.plot(time[lowest[k]] * MM, shown[lowest[k], k] + levels[k], "o", color=f"C{k}", ms=5)
    for speed, name, style in ((np.sqrt(data.E / data.density), "bar", "--"), (_shear(data), "shear", ":")):
        passes = time[lowest[0]] + (stations - stations[0]) / speed
        label = f"from the lowest value at x = {stations[0]:.2f} m at the {name} wave's {speed:.0f} m/s"
        axes.plot(passes * MM, levels + shown[lowest[0], 0], "k" + style, lw=1, label=label)
    # Grid lines are one unit of the scale apart.
    axes.set(xlabel="time [ms]", xlim=(0.0, 1.03 * time[-1] * MM), yticks=levels)
    axes.set_yticklabels([f"x = {x:.2f} m" for x in stations])
    band = f" below {WAVES / 1e3:.0f} kHz" if filtered else ""
    axes.set_title(f"velocity along the rail{band}, since the start; lines are {spacing:.3g} mm/s apart", fontsize=10)
    axes.set_ylim(levels[0] - 1.1 * spacing, levels[-1] + 1.2 * spacing)
    axes.legend(loc="upper left", fontsize=9)
    plots.save(figure, path)


def _round_up(value: float) -> float:
    """The next number of one digit that is 1, 2 or 5."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(next(digit * power for digit in (1.0, 2.0, 5.0, 10.0) if digit * power >= value))


def _low_pass(time: FloatArray, velocity: FloatArray) -> tuple[FloatArray, bool]:
    """Velocities without what is faster than WAVES, True; where the samples are too few, as they are, False."""
    step = float(np.median(np.diff(time))) if len(time) > 40 else 0.0
    if step == 0.0 or 1.0 / step <= 2.5 * WAVES:
        return velocity, False
    # The filter wants equal steps; the run has a shorter one before each of its pictures.
    even = np.arange(time[0], time[-1], step)
    sections = butter(4, WAVES, fs=1.0 / step, output="sos")
    columns = [np.interp(time, even, sosfiltfilt(sections, np.interp(even, time, v))) for v in velocity.T]
    return np.column_stack(columns), True


def _shear(data: RailJoint) -> float:
    return float(np.sqrt(data.E / (2.0 * (1.0 + data.nu) * data.density)))


def section(picture: Picture, data: RailJoint, clim: tuple[float, float], size: tuple[int, int]) -> Any:
    """Image of the von Mises stress around the joint: the half behind the plane y = 0.

    Args:
        picture: the moment.
        data: the joint.
        clim: range of the colours [MPa].
        size: of the image [pixels].
    """
    stress, u = picture.stress, picture.displacement
    assert stress.points is not None and stress.cells is not None
    length, width, depth = ZONE
    middles = stress.points[stress.cells].mean(axis=1)
    near = np.all(np.abs(middles) < 2.0 * np.array([length, width, depth]), axis=1)  # clipping all cells takes a second
    grid = plots.deformed_grid(stress, u, factor=MPA, cell_mask=near)
    first = -1e-4 if data.sides == 2 else 0.0
    part = grid.clip_box((-length, length, first, width, -depth, 0.8 * depth), invert=False)
    view = (*VIEW, (0.0, 0.01, -0.004))
    return plots.draw([part], clim, cmap="viridis", size=size, view=view, above="#fff3b0", zoom=1.45)


def sequence(path: FilePath, data: RailJoint, pictures: Sequence[Picture], history: History) -> None:
    """Von Mises stress at six moments.

    Args:
        path: PNG that is written.
        data: the joint.
        pictures: of the moments.
        history: of the passage.
    """
    plt = plots.pyplot()
    figure, axes = plt.subplots(2, 3, figsize=(12.5, 6.4), layout="constrained")
    clim = (0.0, 800.0)
    for ax, picture in zip(axes.ravel(), pictures):
        plots.show(ax, section(picture, data, clim, (900, 660)))
        now = np.interp(picture.place, history.place, history.force[:, 2]) / data.load
        ax.set_title(f"axle at {picture.place * MM:+.1f} mm, force {now:.2f} of the load", fontsize=10)
    plots.colour_bar(figure, axes, clim, "von Mises stress [MPa]", shrink=0.7, extend="max")
    plots.save(figure, path)


def animation(path: FilePath, data: RailJoint, pictures: Sequence[Picture]) -> None:
    """The passage as an animated GIF.

    Args:
        path: file that is written.
        data: the joint.
        pictures: of all frames.
    """
    import PIL.Image
    import PIL.ImageDraw

    frames = []
    for picture in pictures:
        image = PIL.Image.fromarray(section(picture, data, (0.0, 800.0), (720, 520)))
        text = f"axle at {picture.place * MM:+5.1f} mm; von Mises stress 0 (dark) to 800 MPa (yellow)"
        PIL.ImageDraw.Draw(image).text((12, 500), text, fill="black")
        frames.append(image)
    colours = palette(frames)
    frames = [image.quantize(palette=colours, dither=PIL.Image.Dither.NONE) for image in frames]
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=120, loop=0, optimize=False)


def palette(images: Sequence[Any]) -> Any:
    """Palette of 256 colours for all frames of an animation, in which rare colours count as much as frequent ones.

    The hottest colours are those of a few pixels: a palette by their number would drop them.

    Args:
        images: of PIL, of one size or several.
    """
    import PIL.Image

    found = np.zeros(3 * (32,), dtype=bool)  # colours that differ by less than 8 are one
    for image in images:
        found[tuple(np.asarray(image.convert("RGB")).reshape(-1, 3).T >> 3)] = True
    rare = 8 * np.argwhere(found)
    return PIL.Image.fromarray(rare[None].astype(np.uint8)).quantize(256, method=PIL.Image.Quantize.MEDIANCUT)


def field_on_rail(
    path: FilePath,
    data: RailJoint,
    values: Gathered,
    label: str,
    clim: tuple[float, float],
    cmap: str = "magma",
    by_cell: FloatArray | None = None,
) -> None:
    """A field of the rail heads around the joint, cut at y = 0.

    Args:
        path: PNG that is written.
        data: the joint.
        values: field, in the unit of the picture.
        label: of the colour bar.
        clim: range of the colours.
        cmap: colour map.
        by_cell: values of the cells in their order that are shown instead, (num_cells).
    """
    plt = plots.pyplot()
    figure, axes = plt.subplots(figsize=(8.5, 4.2), layout="constrained")
    plots.show(axes, _heads(data, values, clim, cmap, (1100, 560), by_cell))
    plots.colour_bar(figure, axes, clim, label, cmap=cmap, shrink=0.8)
    plots.save(figure, path)


def _heads(
    data: RailJoint,
    values: Gathered,
    clim: tuple[float, float],
    cmap: str,
    size: tuple[int, int],
    by_cell: FloatArray | None = None,
) -> Any:
    """Image of a field of the rail heads around the joint, cut at y = 0."""
    assert values.values is not None and values.points is not None and values.cells is not None
    below = values.points[values.cells].mean(axis=1)[:, 2] < 0.0  # without the wheel
    grid = plots.grid(values, cell_mask=below)
    if by_cell is None:
        grid.point_data["value"] = values.values[:, 0]
    else:
        grid.cell_data["value"] = by_cell[below]
    length, width, depth = ZONE
    first = -1e-4 if data.sides == 2 else 0.0
    part = grid.clip_box((-length, length, first, width, -depth, 1e-3), invert=False)
    view = ((-0.3, -1.3, 0.6), (0, 0, 1), (0.0, 0.01, -0.015))
    return plots.draw([part], clim, cmap=cmap, size=size, view=view, edges=False, zoom=1.5)


RESIDUAL = {
    "sigma_xx": "along the rail", "sigma_yy": "across the rail", "tau_xz": "shear in the plane of the rail",
    "von_mises": "von Mises",
}  # fmt: skip


def residual(path: FilePath, data: RailJoint, stress: Mapping[str, Gathered]) -> None:
    """Residual stress of the rail heads around the joint: normal stress along and across the rail, shear, von Mises.

    Args:
        path: PNG that is written.
        data: the joint.
        stress: by the names of RESIDUAL; each has colours up to its own largest value [MPa].
    """
    plt = plots.pyplot()
    figure, all_axes = plt.subplots(2, 2, figsize=(12.0, 7.0), layout="constrained")
    for axes, (name, text) in zip(all_axes.ravel(), RESIDUAL.items()):
        positive, found = name == "von_mises", stress[name]
        assert found.values is not None and found.points is not None  # rank 0 has them
        near = np.abs(found.points[:, 0]) < ZONE[0]
        limit = max(1.0, float(np.abs(found.values[near]).max()))
        clim, cmap = (0.0 if positive else -limit, limit), "viridis" if positive else "RdBu_r"
        plots.show(axes, _heads(data, found, clim, cmap, (1100, 560)))
        axes.set_title(text, fontsize=10)
        plots.colour_bar(figure, axes, clim, "residual stress [MPa]", cmap=cmap, shrink=0.8)
    plots.save(figure, path)
