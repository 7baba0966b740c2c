# SPDX-License-Identifier: MIT
"""Figures of deformed meshes with fields, drawn by PyVista without a screen, with axes by matplotlib.

PyVista draws the image; matplotlib draws axes, labels and colour bars, so that they are legible. All functions take
gathered arrays (gather.py) and are called on rank 0.
"""

from __future__ import annotations

import atexit
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ..common.types import ArrayLike, BoolArray, FilePath, FloatArray, IntArray
from .gather import Gathered

if TYPE_CHECKING:
    import matplotlib.axes
    import matplotlib.colorbar
    import matplotlib.figure
    import pyvista

Image: TypeAlias = npt.NDArray[np.uint8]  # (height, width, 3)
Box: TypeAlias = Sequence[float]  # xmin, xmax, ymin, ymax

COLOURS = ("#0b5394", "#c8501e", "#3a7d44", "#6b6b6b")
_STYLE = {
    "font.size": 10,
    "axes.grid": True,
    "grid.color": "#dddddd",
    "axes.axisbelow": True,
    # Legends without a frame, but curves below them fade, so that they can be read.
    "legend.edgecolor": "none",
    "legend.framealpha": 0.8,
    "figure.constrained_layout.w_pad": 0.1,  # the label of a colour bar keeps off that of the next axes [inch]
}


class NoScreen(RuntimeError):
    """There is no display for VTK."""


def screen() -> None:
    """Make sure that VTK has a display: the present one, or else an Xvfb that ends with this process.

    Raises:
        NoScreen: there is no display, and Xvfb is missing or does not start.
    """
    if os.environ.get("DISPLAY"):
        return
    program = shutil.which("Xvfb")
    if program is None:
        raise NoScreen("pictures of meshes need a screen: install Xvfb (Debian: xvfb) or set DISPLAY")
    read, write = os.pipe()
    command = [program, "-displayfd", str(write), "-screen", "0", "1600x1200x24", "-nolisten", "tcp"]
    server = subprocess.Popen(
        command, pass_fds=(write,), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
    )
    os.close(write)
    with os.fdopen(read) as answer:  # Xvfb writes the number it took, or ends
        number = answer.readline().strip()
    if not number:
        server.wait()
        raise NoScreen(f"{program} did not start: set DISPLAY, or see what it says when started by hand")
    os.environ["DISPLAY"] = f":{number}"

    def stop() -> None:
        server.terminate()
        server.wait()
        os.environ.pop("DISPLAY", None)

    atexit.register(stop)


def _import_pyplot() -> ModuleType:
    """matplotlib.pyplot, without a screen unless a notebook, a caller who imported it or MPLBACKEND chose one."""
    if "matplotlib.pyplot" not in sys.modules and "MPLBACKEND" not in os.environ:
        import matplotlib

        matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    return plt


def pyplot() -> ModuleType:
    """Import matplotlib.pyplot and give all figures from now on the style of this package's, for scripts.

    Returns:
        matplotlib.pyplot.
    """
    plt = _import_pyplot()
    plt.rcParams.update(_STYLE)
    return plt


@contextmanager
def styled() -> Iterator[ModuleType]:
    """Import matplotlib.pyplot, with the style of this package's figures until the block ends; then the caller's.

    Yields:
        matplotlib.pyplot.
    """
    plt = _import_pyplot()
    with plt.rc_context(_STYLE):
        yield plt


def grid(
    field: Gathered,
    displacement: FloatArray | None = None,
    scale: float = 1.0,
    cell_mask: BoolArray | IntArray | None = None,
) -> pyvista.UnstructuredGrid:
    """PyVista grid of a gathered mesh or field.

    Args:
        field: gathered mesh or field.
        displacement: displacement of its nodes, (num_nodes, gdim); None: undeformed [L].
        scale: factor of the displacement [1].
        cell_mask: mask or numbers of the cells that are shown; None: all.

    Returns:
        Grid.
    """
    import pyvista

    assert field.points is not None, "gathered fields have their nodes on rank 0 only"
    points = np.zeros((len(field.points), 3))
    points[:, : field.points.shape[1]] = field.points
    if displacement is not None:
        points[:, : displacement.shape[1]] += scale * displacement
    cells, kind = field.vtk()
    if cell_mask is not None:
        cells = cells[cell_mask]
    flat = np.hstack([np.full((len(cells), 1), cells.shape[1]), cells]).ravel()
    return pyvista.UnstructuredGrid(flat, np.full(len(cells), kind, dtype=np.uint8), points)


def deformed_grid(
    field: Gathered,
    displacement: Gathered,
    scale: float = 1.0,
    factor: float = 1.0,
    cell_mask: BoolArray | IntArray | None = None,
    shift: FloatArray | None = None,
) -> pyvista.UnstructuredGrid:
    """PyVista grid of a scalar field at the vertices on the deformed body, for `draw`.

    Args:
        field: gathered field of degree 1.
        displacement: gathered displacement of any degree on the same mesh [L].
        scale: factor of the displacement [1].
        factor: factor of the values, for another unit.
        cell_mask: mask or numbers of the cells that are shown; None: all.
        shift: added to the displacements of the nodes, (gdim) or (num_nodes, gdim) [L].

    Returns:
        Grid with the point data "value".
    """
    assert field.values is not None, "gathered fields have their values on rank 0 only"
    moved = at_nodes_of(field, displacement)
    out = grid(field, moved if shift is None else moved + shift, scale, cell_mask)
    out.point_data["value"] = factor * field.values[:, 0]
    return out


def at_nodes_of(field: Gathered, other: Gathered) -> FloatArray:
    """Values of another field at the nodes of one of degree 1, found by the cells: bodies that touch keep their own.

    Args:
        field: gathered field of degree 1.
        other: gathered field of any degree on the same mesh.

    Returns:
        Values, (num_nodes, components).
    """
    assert field.points is not None and field.cells is not None
    assert other.cells is not None and other.values is not None
    out = np.zeros((len(field.points), other.values.shape[1]))
    corners = other.cells[:, : field.cells.shape[1]]  # DOLFINx numbers the vertices of a cell first
    out[field.cells.ravel()] = other.values[corners.ravel()]
    return out


def show_grids(
    figure: matplotlib.figure.Figure,
    axes: matplotlib.axes.Axes,
    grids: Sequence[pyvista.UnstructuredGrid],
    clim: Sequence[float],
    label: str,
    title: str | None = None,
    cmap: str = "viridis",
    box: Box | None = None,
    lengths: float = 1e3,
    unit: str = "mm",
    shrink: float = 0.85,
    log: bool = False,
    **options: Any,
) -> None:
    """Draw grids into matplotlib axes, with a colour bar: `draw`, `show` and `colour_bar` in one.

    Args:
        figure: figure.
        axes: axes of the image.
        grids: grids with the point data "value".
        clim: smallest and largest value of the colour scale, in the unit of the values.
        label: label of the colour bar.
        title: title of the axes, or None.
        cmap: matplotlib's name of the colour map.
        box: xmin, xmax, ymin, ymax of a view along z, on axes with coordinates; None: without coordinates [L].
        lengths: factor of the coordinates that the axes show.
        unit: unit of the coordinates that the axes show.
        shrink: length of the colour bar, as part of the axes [1].
        log: whether the colour scale is logarithmic.
        options: further arguments of `draw`.

    Raises:
        NoScreen: there is no display.
    """
    image = draw(grids, clim, cmap, box=box, log=log, **options)
    show(axes, image, None if box is None else [lengths * place for place in box], unit, title)
    colour_bar(figure, axes, clim, label, cmap, log, shrink=shrink)


def draw(
    grids: Sequence[pyvista.UnstructuredGrid],
    clim: Sequence[float],
    cmap: str = "viridis",
    size: tuple[int, int] = (900, 700),
    box: Box | None = None,
    view: tuple[ArrayLike, ArrayLike, ArrayLike | None] | None = None,
    log: bool = False,
    edges: bool = True,
    zoom: float = 1,
    above: str | None = None,
) -> Image:
    """Draw grids, coloured by their point data "value".

    Args:
        grids: grids.
        clim: smallest and largest value of the colour scale, in the unit of the values.
        cmap: matplotlib's name of the colour map.
        size: width and height of the image [pixels].
        box: xmin, xmax, ymin, ymax of the image in a view along z; None: the whole of the grids [L].
        view: direction towards the viewer, upward direction, and focal point or None, of a parallel projection in 3D;
            None: view along z.
        log: whether the colour scale is logarithmic.
        edges: whether edges of cells are drawn.
        zoom: zoom factor of the camera, with `view` [1].
        above: colour of values above the range; None: that of the largest value.

    Returns:
        Image, (height, width, 3).

    Raises:
        NoScreen: there is no display.
    """
    import pyvista

    screen()
    plotter = pyvista.Plotter(off_screen=True, window_size=size)
    plotter.set_background("white")
    plotter.enable_parallel_projection()
    plotter.enable_anti_aliasing("ssaa", multi_samples=4)
    for part in grids:
        shown = part.extract_surface(nonlinear_subdivision=1)
        plotter.add_mesh(
            shown, scalars="value", clim=clim, cmap=cmap, log_scale=log, show_scalar_bar=False, above_color=above,
            nan_color="white", lighting=view is not None, ambient=0.35, diffuse=0.7,
            show_edges=edges, edge_color="#202020", edge_opacity=0.25, line_width=1,
        )  # fmt: skip
    camera = plotter.camera
    if view is None:
        plotter.view_xy()
        if box is None:
            bounds = np.array([part.bounds for part in grids])
            low, high = bounds.min(axis=0), bounds.max(axis=0)
            box = (low[0], high[1], low[2], high[3])
        middle = ((box[0] + box[1]) / 2, (box[2] + box[3]) / 2, 0.0)
        camera.focal_point, camera.position = middle, (*middle[:2], 10.0)
        camera.parallel_scale = max((box[3] - box[2]) / 2, (box[1] - box[0]) / 2 * size[1] / size[0])
    else:
        direction, up, focal = view
        plotter.view_vector(direction, up)
        if focal is not None:
            offset = np.array(camera.position) - np.array(camera.focal_point)
            camera.focal_point, camera.position = focal, np.asarray(focal) + offset
        camera.zoom(zoom)
    image = plotter.screenshot(return_img=True)
    plotter.close()
    return image


def colour_bar(
    figure: matplotlib.figure.Figure,
    axes: matplotlib.axes.Axes,
    clim: Sequence[float],
    label: str,
    cmap: str = "viridis",
    log: bool = False,
    **options: Any,
) -> matplotlib.colorbar.Colorbar:
    """Add the colour bar of an image made by `draw`.

    Args:
        figure: figure.
        axes: axes of the image.
        clim: smallest and largest value, as for `draw`.
        label: label of the bar.
        cmap: colour map, as for `draw`.
        log: whether the scale is logarithmic, as for `draw`.
        options: further arguments of `Figure.colorbar`.

    Returns:
        Colour bar.
    """
    from matplotlib import cm, colors

    low, high = clim
    norm = colors.LogNorm(low, high) if log else colors.Normalize(low, high)
    bar = figure.colorbar(cm.ScalarMappable(norm, cmap), ax=axes, label=label, **options)
    bar.ax.grid(False)
    return bar


def show(
    axes: matplotlib.axes.Axes, image: Image, box: Box | None = None, unit: str = "mm", title: str | None = None
) -> None:
    """Show an image in matplotlib axes.

    Args:
        axes: axes.
        image: image of `draw`, (height, width, 3).
        box: xmin, xmax, ymin, ymax of the image, in `unit`; None: the axes have no coordinates.
        unit: unit of the coordinates, for the labels.
        title: title of the axes, or None.
    """
    extent = None if box is None else (box[0], box[1], box[2], box[3])
    axes.imshow(image, extent=extent, aspect="equal", interpolation="lanczos")
    axes.grid(False)
    if box is None:
        axes.set_axis_off()
    else:
        axes.set_xlabel(f"x [{unit}]")
        axes.set_ylabel(f"y [{unit}]")
    if title:
        axes.set_title(title, fontsize=10)


def save(figure: matplotlib.figure.Figure, path: FilePath, colours: int | None = None, dpi: float = 110) -> FilePath:
    """Save a figure as PNG and close it.

    Args:
        figure: figure.
        path: file to write.
        colours: number of colours of the palette, 128 for a quarter of the file's size; None: all colours [1].
        dpi: resolution [dots per inch].

    Returns:
        `path`.
    """
    import io

    import PIL.Image
    from matplotlib import pyplot

    buffer = io.BytesIO()
    figure.savefig(buffer, dpi=dpi, format="png")
    pyplot.close(figure)
    image = PIL.Image.open(buffer).convert("RGB")
    if colours:
        image = image.quantize(colours, method=PIL.Image.Quantize.MAXCOVERAGE, dither=PIL.Image.Dither.NONE)
    image.save(path, optimize=True)
    return path
