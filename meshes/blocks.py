# SPDX-License-Identifier: MIT
"""Plain blocks: one, and one on another (patch tests, bars, friction)."""

import math

import numpy as np

from .layout import Layout, at, count, positive, require


def _dimension(size, cells):
    require(len(size) in (2, 3), f"size = {size!r}: 2 or 3 lengths are needed")
    require(len(cells) == len(size), f"cells = {cells!r}: as many as lengths in size = {size!r}")
    positive(**{f"size[{i}]": v for i, v in enumerate(size)})
    count(**{f"cells[{i}]": v for i, v in enumerate(cells)})
    return len(size)


def brick(body, low, high, cells):
    """Add one box-shaped block with equal cells to a body; returns its corner points."""
    layout, dim = body.layout, body.layout.dim
    sizes = [(b - a) / n for a, b, n in zip(low, high, cells)]
    square = ((0, 0), (1, 0), (1, 1), (0, 1))
    box = square if dim == 2 else [(*xy, z) for z in (0, 1) for xy in square]
    corners = [body.point([(low, high)[k][i] for i, k in enumerate(place)], min(sizes)) for place in box]
    body.block(*corners)
    for axis, other in enumerate((1, 3, 4)[:dim]):
        layout.set_cells(corners[0], corners[other], cells[axis])
    return corners


def tag_sides(body, low, high, slave=False):
    """Name the sides of a box: left, right, front, back (slave: with the prefix slave_)."""
    prefix = "slave_" if slave else ""
    for axis, pair in enumerate((("left", "right"), ("front", "back"))[: body.layout.dim - 1]):
        body.tag(prefix + pair[0], at(axis, low[axis]))
        body.tag(prefix + pair[1], at(axis, high[axis]))


def block(size=(1.0, 1.0), cells=(8, 8), origin=None, distortion=0.0, seed=1):
    """A box: bottom, top, left, right (front, back).

    size: lengths along x, y (and z: then 3D) [m]
    cells: numbers of cells along the same axes [1]
    origin: lower corner, default zero [m]
    distortion: random displacement of the inner vertices as a fraction of the cell size, 0 to 0.3 [1]
    seed: of that randomness [1]
    """
    dim = _dimension(size, cells)
    low = np.zeros(dim) if origin is None else np.array(origin, dtype=float)
    require(low.shape == (dim,), f"origin = {origin!r}: {dim} coordinates are needed")
    require(0 <= distortion <= 0.3, f"distortion = {distortion!r}: 0 to 0.3 keeps the cells valid")
    high = low + np.array(size)
    layout = Layout(dim, max(size), structured=True)
    body = layout.body("master_body")
    brick(body, low, high, cells)
    body.tag("bottom", at(dim - 1, low[-1]))
    body.tag("top", at(dim - 1, high[-1]))
    tag_sides(body, low, high)
    if distortion > 0:
        step = np.array(size) / np.array(cells)

        def jitter(x):
            inner = np.all((x[:, :dim] > low + 1e-6 * step) & (x[:, :dim] < high - 1e-6 * step), axis=1)
            shift = np.random.default_rng(seed).uniform(-distortion, distortion, (len(x), dim)) * step
            x[inner, :dim] += shift[inner]
            return x

        body.map(jitter, straight=True)
    return layout


def two_blocks(
    lower=(1.0, 0.5), upper=(1.0, 0.5), lower_cells=(8, 4), upper_cells=(11, 5), offset=None, gap=0.0, incline=0.0
):
    """A block on another, separate nodes: the patch test (matching or not), sliding block, square block on a wider one.

    lower, upper: lengths along x, y (and z: then 3D) of the master and of the slave block [m]
    lower_cells, upper_cells: numbers of cells along the same axes [1]
    offset: of the upper block's lower corner in the horizontal directions, default centred [m]
    gap: vertical distance between the blocks, negative to overlap [m]
    incline: angle of the interface with the x axis, the outer faces staying straight [rad]
    """
    dim = _dimension(lower, lower_cells)
    require(_dimension(upper, upper_cells) == dim, f"upper = {upper!r} and lower = {lower!r}: not the same dimension")
    lower, upper = np.array(lower, dtype=float), np.array(upper, dtype=float)
    offset = (lower - upper)[:-1] / 2 if offset is None else np.atleast_1d(np.array(offset, dtype=float))
    require(offset.shape == (dim - 1,), f"offset = {offset!r}: {dim - 1} horizontal distances are needed")
    require(
        math.isfinite(gap) and gap > -min(lower[-1], upper[-1]), f"gap = {gap!r}: a finite number, or a small overlap"
    )
    rise = math.tan(incline) * max(lower[0], upper[0]) / 2
    room = 0.95 * min(lower[-1], upper[-1])
    require(abs(incline) < 1.5 and abs(rise) < room, f"incline = {incline!r}: the interface would cut the outer faces")
    layout = Layout(dim, max(*lower, *upper), structured=True)
    top_of_lower, low = lower[-1], np.array([*offset, lower[-1] + gap])

    master = layout.body("master_body")
    brick(master, np.zeros(dim), lower, lower_cells)
    master.tag("bottom", at(dim - 1, 0.0))
    master.tag("master_surface", at(dim - 1, top_of_lower))
    tag_sides(master, np.zeros(dim), lower)

    slave = layout.body("slave_body")
    brick(slave, low, low + upper, upper_cells)
    slave.tag("top", at(dim - 1, low[-1] + upper[-1]))
    slave.tag("slave_surface", at(dim - 1, low[-1]))
    tag_sides(slave, low, low + upper, slave=True)
    if incline:
        middle, slope = lower[0] / 2, math.tan(incline)

        def tilt_lower(x):
            x[:, dim - 1] += slope * (x[:, 0] - middle) * x[:, dim - 1] / lower[-1]
            return x

        def tilt_upper(x):
            x[:, dim - 1] += slope * (x[:, 0] - middle) * (1 - (x[:, dim - 1] - low[-1]) / upper[-1])
            return x

        master.map(tilt_lower)
        slave.map(tilt_upper)
    return layout


RECIPES = (block, two_blocks)
