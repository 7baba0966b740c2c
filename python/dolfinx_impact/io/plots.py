# SPDX-License-Identifier: MIT
"""Pictures: deformed meshes with a field on them (drawn by PyVista without a screen), framed by matplotlib.

The axes, labels and colour bars are matplotlib's, so that they can be read; the image inside is VTK's. Everything here
works on gathered arrays (gather.py) and is called on rank 0.
"""

import atexit
import os
import shutil
import subprocess

import numpy as np

COLOURS = ("#0b5394", "#c8501e", "#3a7d44", "#6b6b6b")
_STYLE = {"font.size": 10, "axes.grid": True, "grid.color": "#dddddd", "axes.axisbelow": True, "legend.frameon": False}


class NoScreen(RuntimeError):
    """There is nothing VTK could draw on."""


def screen():
    """Make sure that VTK has a display: the present one, else an Xvfb of this process, ended with it.

    Raises:
        NoScreen: neither is there.
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

    def stop():
        server.terminate()
        server.wait()
        os.environ.pop("DISPLAY", None)

    atexit.register(stop)


def pyplot():
    """matplotlib.pyplot without a screen, in the style of these figures."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    plt.rcParams.update(_STYLE)
    return plt


def grid(field, displacement=None, scale=1.0, cell_mask=None):
    """PyVista grid of a gathered field.

    Args:
        field: Gathered, of the mesh or of any field.
        displacement: at its nodes, shape (num_nodes, gdim) [L]; moves them, multiplied by `scale`.
        cell_mask: cells to keep.
    """
    import pyvista

    points = np.zeros((len(field.points), 3))
    points[:, : field.points.shape[1]] = field.points
    if displacement is not None:
        points[:, : displacement.shape[1]] += scale * displacement
    cells, kind = field.vtk()
    if cell_mask is not None:
        cells = cells[cell_mask]
    flat = np.hstack([np.full((len(cells), 1), cells.shape[1]), cells]).ravel()
    return pyvista.UnstructuredGrid(flat, np.full(len(cells), kind, dtype=np.uint8), points)


def draw(grids, clim, cmap="viridis", size=(900, 700), box=None, view=None, log=False, edges=True, zoom=1, above=None):
    """Image (height, width, 3) of grids coloured by the point data "value".

    Args:
        grids: list of PyVista grids.
        clim: range of the colours.
        size: in pixels.
        box: (xmin, xmax, ymin, ymax) of a view along z, which fills the image; None: everything.
        view: (direction towards the eye, up, focal point or None) of a parallel projection in 3D.
        log: colours by logarithm.
        edges: draw the cells' edges.
        zoom: of the camera, where there is no box.
        above: colour of values beyond the range.
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


def colour_bar(figure, axes, clim, label, cmap="viridis", log=False, **options):
    """Colour bar for an image made by `draw`."""
    from matplotlib import cm, colors

    norm = colors.LogNorm(*clim) if log else colors.Normalize(*clim)
    bar = figure.colorbar(cm.ScalarMappable(norm, cmap), ax=axes, label=label, **options)
    bar.ax.grid(False)
    return bar


def show(axes, image, box=None, unit="mm", title=None):
    """Put an image into matplotlib axes; `box` (xmin, xmax, ymin, ymax) gives it coordinates in `unit`."""
    axes.imshow(image, extent=box, aspect="equal", interpolation="lanczos")
    axes.grid(False)
    if box is None:
        axes.set_axis_off()
    else:
        axes.set_xlabel(f"x [{unit}]")
        axes.set_ylabel(f"y [{unit}]")
    if title:
        axes.set_title(title, fontsize=10)


def save(figure, path, colours=None, dpi=110):
    """Save a figure as PNG and close it; `colours` reduces the palette (a quarter of the size at 128)."""
    import io

    from matplotlib import pyplot
    from PIL import Image

    buffer = io.BytesIO()
    figure.savefig(buffer, dpi=dpi, format="png")
    pyplot.close(figure)
    image = Image.open(buffer).convert("RGB")
    if colours:
        image = image.quantize(colours, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    image.save(path, optimize=True)
    return path
