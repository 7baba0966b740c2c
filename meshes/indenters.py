# SPDX-License-Identifier: MIT
"""Indenters with an edge or a tip: punch with a square (or rounded) corner, wedge, cone."""

import math

import numpy as np

from .hertz import QUARTERS, SIDES, fine_zone, graded_half_plane, graded_half_space, tag_half_space, tag_symmetry
from .layout import Layout, at, positive, require


def _rows(low, corner, high, h, coarse):
    """Points and cell sizes of a grid line that is fine at `corner` and coarse at its ends."""
    ends = [(x, min(coarse, max(h, abs(x - corner) / 3))) for x in (low, high) if abs(x - corner) > 1e-12]
    return sorted([*ends, (corner, h)])


def _grid(body, xs, ys):
    """Rectangular blocks on grid lines [(coordinate, size)...]; the cell sizes follow the lines."""
    p = [[body.point((x, y), max(sx, sy)) for y, sy in ys] for x, sx in xs]
    sizes = body.layout.edge_sizes

    def edge(a, b, sa, sb):
        sizes[(min(a, b), max(a, b))] = (sa, sb) if a < b else (sb, sa)

    for i in range(len(xs)):
        for j in range(len(ys)):
            if i:
                edge(p[i - 1][j], p[i][j], xs[i - 1][1], xs[i][1])
            if j:
                edge(p[i][j - 1], p[i][j], ys[j - 1][1], ys[j][1])
            if i and j:
                body.block(p[i - 1][j - 1], p[i][j - 1], p[i][j], p[i - 1][j])
    return p


def _thicken(layout, depth, depth_cells, height):
    """The plan itself, or its extrusion along y by `depth`, z becoming the vertical axis."""
    if depth is None:
        return layout
    positive(depth=depth, depth_cells=depth_cells)
    size = depth / depth_cells
    return layout.extruded(
        lambda x, t: (x[0], t, x[1]),
        (0.0, depth),
        (size, size),
        lambda body: ("slave_front", "slave_back") if body == "slave_body" else ("front", "back"),
    )


def punch(
    half_width=0.01, height=0.02, block_width=0.06, block_height=0.06, h=None, fillet=0.0, gap=0.0, coarse=None,
    symmetry="half", depth=None, depth_cells=1,
):  # fmt: skip
    """A punch with a square corner on a block; with symmetry="half" also a round punch, x being the radius.

    half_width, height: of the punch [m]
    block_width: half-width of the block [m]
    block_height: of the block [m]
    h: cell size at the corner, default half_width/20 [m]
    fillet: radius of the punch's corner, 0 for a square one [m]
    gap: between the bodies [m]
    coarse: largest cell size, default half_width/4 [m]
    symmetry: "half" (x >= 0) or "none"
    depth: thickness along y, which makes it 3D [m]
    depth_cells: number of cells along y [1]
    """
    positive(half_width=half_width, height=height, block_width=block_width, block_height=block_height)
    h = half_width / 20 if h is None else h
    coarse = half_width / 4 if coarse is None else coarse
    positive(h=h, coarse=coarse)
    require(block_width > half_width, f"block_width = {block_width!r}: not larger than half_width = {half_width!r}")
    require(symmetry in SIDES, f"symmetry = {symmetry!r}: one of {', '.join(SIDES)}")
    require(0 <= fillet < min(half_width, height), f"fillet = {fillet!r}: 0, or less than half_width and height")
    a, f = half_width, fillet
    layout = Layout(2, max(block_width, block_height, height))
    master, slave = layout.body("master_body"), layout.body("slave_body")
    coarse = max(coarse, h)
    for s in SIDES[symmetry]:
        xs = sorted(
            (s * x, size) for x, size in [*_rows(0, a - f, a - f, h, coarse), *_rows(a, a, block_width, h, coarse)]
        )
        xs = sorted({round(x / h * 1e9): (x, size) for x, size in xs}.values())
        _grid(master, xs, _rows(-block_height, 0.0, 0.0, h, coarse))
        xs = sorted((s * x, size) for x, size in _rows(0, a - f, a - f, h, coarse))
        if not f:
            _grid(slave, xs, [(y + gap, size) for y, size in _rows(0, 0, height, h, coarse)])
            continue
        _grid(slave, xs, [(gap, h), (gap + f / 2, h), (gap + f, h), (gap + height, min(coarse, height / 3))])
        middle = sorted((s * x, h) for x in (a - f, a - f / 2, a))
        _grid(slave, middle, [(gap + f, h), (gap + height, min(coarse, height / 3))])
        q = math.sqrt(0.5) * f

        def p(x, y):
            return slave.point((s * x, y + gap), h)

        c, low, side, mid = p(a - f, f), p(a - f, f / 2), p(a - f / 2, f), p(a - f + 0.45 * f, f - 0.45 * f)
        start, half, end = p(a - f, 0), p(a - f + q, f - q), p(a, f)
        slave.block(c, low, mid, side)
        slave.block(low, start, half, mid)
        slave.block(mid, half, end, side)
        for i, j in ((start, half), (half, end)):
            slave.arc(i, j, (s * (a - f), f + gap))
            slave.facet("slave_surface", i, j)
    master.tag("master_surface", at(1, 0.0))
    master.tag("bottom", at(1, -block_height))
    slave.tag("slave_surface", at(1, gap))
    slave.tag("top", at(1, gap + height))
    if symmetry == "half":
        master.tag("symmetry_x", at(0, 0.0))
        slave.tag("symmetry_x", at(0, 0.0))
    else:
        master.tag("left", at(0, -block_width))
        slave.tag("slave_left", at(0, -a))
    master.tag("right", at(0, block_width))
    slave.tag("slave_right", at(0, a))
    return _thicken(layout, depth, depth_cells, height)


def wedge(
    angle=math.radians(80), a=5.0e-3, width=0.015, height=None, block_width=0.1, block_height=0.1, h=None, core=None,
    gap=0.0, coarse=None, symmetry="half", depth=None, depth_cells=1,
):  # fmt: skip
    """A wedge on a block; with symmetry="half" also a cone on a half-space, x being the radius.

    angle: between the axis and the flank, near pi/2 for a blunt wedge [rad]
    a: expected half-width of the contact [m]
    width: half-width of the wedge [m]
    height: from tip to top, default the rise of the flank plus 0.8 widths [m]
    block_width: half-width of the block [m]
    block_height: of the block [m]
    h: cell size in the contact, default a/10 [m]
    core: half-width of the fine zone, default 1.5 a [m]
    gap: between tip and block [m]
    coarse: largest cell size [m]
    symmetry: "half" or "none"
    depth: thickness along y, which makes it 3D [m]
    depth_cells: cells along y [1]
    """
    positive(width=width, block_width=block_width, block_height=block_height, angle=angle)
    require(angle < math.pi / 2, f"angle = {angle!r}: between 0 and pi/2")
    require(symmetry in SIDES, f"symmetry = {symmetry!r}: one of {', '.join(SIDES)}")
    h, core = fine_zone(a, h, core, 10)
    cot = 1 / math.tan(angle)
    height = cot * width + 0.8 * width if height is None else height
    require(height > cot * width, f"height = {height!r}: lower than the end of the flank, {cot * width!r}")
    require(core < width, f"core = {core!r}: not smaller than the wedge, width = {width!r}")
    layout = Layout(2, max(block_width, block_height, width))
    master, slave = layout.body("master_body"), layout.body("slave_body")
    graded_half_plane(master, block_width, block_height, h, core, SIDES[symmetry], coarse)
    far = width / 4 if coarse is None else coarse
    for s in SIDES[symmetry]:
        xs = [(0.0, h), (core, h), (width, max(h, min(far, width / 4)))]
        low = [slave.point((s * x, gap + cot * x), size) for x, size in xs]
        high = [slave.point((s * x, gap + height), far) for x, size in xs]
        for k in (0, 1):
            slave.block(low[k], low[k + 1], high[k + 1], high[k])
            slave.facet("slave_surface", low[k], low[k + 1])
            pair, size = (high[k], high[k + 1]), (xs[k][1], xs[k + 1][1])
            layout.edge_sizes[(min(pair), max(pair))] = size if pair[0] < pair[1] else size[::-1]
    master.tag("master_surface", at(1, 0.0))
    master.tag("bottom", at(1, -block_height))
    master.tag("right", at(0, block_width))
    slave.tag("slave_right", at(0, width))
    slave.tag("top", at(1, gap + height))
    if symmetry == "half":
        master.tag("symmetry_x", at(0, 0.0))
        slave.tag("symmetry_x", at(0, 0.0))
    else:
        master.tag("left", at(0, -block_width))
        slave.tag("slave_left", at(0, -width))
    return _thicken(layout, depth, depth_cells, height)


def cone(
    angle=math.radians(80), a=2.0e-3, width=0.012, height=0.012, block_width=0.016, block_height=0.016, h=None,
    core=None, gap=0.0, coarse=None, symmetry="quarter",
):  # fmt: skip
    """A cone, cut out of a square prism, on a block, 3D (for the axisymmetric cone in 2D take `wedge`).

    angle: between the axis and the flank [rad]
    a: expected radius of the contact [m]
    width: half-width of the prism [m]
    height: from tip to top [m]
    block_width: half-width of the block [m]
    block_height: of the block [m]
    h: cell size in the contact, default a/4 [m]
    core: half-width of the fine zone, default 1.5 a [m]
    gap: between tip and block [m]
    coarse: largest cell size [m]
    symmetry: "quarter", "half" or "none"
    """
    positive(width=width, height=height, block_width=block_width, block_height=block_height, angle=angle)
    require(angle < math.pi / 2, f"angle = {angle!r}: between 0 and pi/2")
    require(symmetry in QUARTERS, f"symmetry = {symmetry!r}: one of {', '.join(QUARTERS)}")
    h, core = fine_zone(a, h, core, 4)
    cot = 1 / math.tan(angle)
    require(
        height > math.sqrt(2) * width * cot,
        f"height = {height!r}: lower than the flank, {math.sqrt(2) * width * cot!r}",
    )
    layout = Layout(3, max(block_width, block_height, width))
    master, slave = layout.body("master_body"), layout.body("slave_body")
    graded_half_space(master, block_width, block_height, h, core, QUARTERS[symmetry], coarse)
    graded_half_space(slave, width, height, h, core, QUARTERS[symmetry], coarse, up=True)
    tag_half_space(master, block_width, block_height, symmetry)
    tag_symmetry(slave, symmetry)
    slave.tag("slave_surface", at(2, 0.0))
    slave.tag("top", at(2, height))
    for side, axis, value in (("right", 0, width), ("left", 0, -width), ("back", 1, width), ("front", 1, -width)):
        slave.tag("slave_" + side, at(axis, value))

    def raise_flank(x):
        x[:, 2] += gap + cot * np.hypot(x[:, 0], x[:, 1]) * (1 - x[:, 2] / height)
        return x

    slave.map(raise_flank)
    return layout


RECIPES = (punch, wedge, cone)
