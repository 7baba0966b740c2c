# SPDX-License-Identifier: MIT
"""Rail joint: two rail ends with a gap, an end post in it, and a wheel above if wanted."""

import math

import numpy as np

from .hertz import SIDES
from .layout import Layout, at, positive, require
from .wheel_rail import HEAD_DEPTH, HEAD_HALF_WIDTH, RAIL_HEIGHT, rail_plan, wheel_plan


def _spans(length, gap, h, coarse, end_post):
    """(body name, start, end, size at start, size at end) along x: left rail, end post, right rail."""
    post = min(h, gap)
    spans = [
        ("master_body", -length - gap / 2, -gap / 2, coarse, h),
        ("second_rail", gap / 2, length + gap / 2, h, coarse),
    ]
    return spans + ([("end_post", -gap / 2, gap / 2, post, post)] if end_post != "none" else [])


def _common(rail_length, gap, h, coarse, end_post):
    positive(rail_length=rail_length, gap=gap, h=h, coarse=coarse)
    require(end_post in ("glued", "loose", "none"), f"end_post = {end_post!r}: one of glued, loose, none")
    require(h <= coarse < rail_length, f"h = {h!r}, coarse = {coarse!r}, rail_length = {rail_length!r}: should grow")


def rail_joint_2d(
    rail_length=0.6, rail_height=RAIL_HEIGHT, gap=8.0e-3, end_post="glued", h=4.0e-3, coarse=0.03, core=None,
    corner=0.0, step=0.0, joined=None, wheel=False, wheel_x=0.0, wheel_gap=0.0, wheel_radius=0.46, hub_radius=0.1,
    a=4.5e-3, wheel_turn=0.0,
):  # fmt: skip
    """Rail joint in the longitudinal plane. The running surface is y = 0, the joint is at x = 0.

    rail_length: of each rail [m]
    rail_height: [m]
    gap: between the rail ends [m]
    end_post: "glued" (shares the nodes of the rail ends), "loose" (separate nodes) or "none"
    h: cell size at the joint [m]
    coarse: at the far ends [m]
    core: half-length of a zone of cells of size h along the running surface, and as much of the wheel's rim: the way
        that a wheel can roll, only there it may touch; default none: the cells grow from the joint on, those of the
        wheel are a/4 over 3 a [m]
    corner: radius of the parabola that rounds the rail ends, which meets the end faces at 45 degrees; 0: sharp [m]
    step: by how much the right rail's running surface is higher, at most a hundredth of its height [m]
    joined: depth below which the rails are one, as joint bars make them; what fills the gap there is "end_post" [m]
    wheel: whether there is a wheel above
    wheel_x: position of its lowest point [m]
    wheel_gap: height of that point [m]
    wheel_radius, hub_radius: [m]
    a: expected half-width of the contact [m]
    wheel_turn: angle by which the wheel's fine zone is turned forward from below (towards x), or back [rad]
    """
    _common(rail_length, gap, h, coarse, end_post)
    positive(rail_height=rail_height, a=a)
    _check_core(core, corner, step, joined, h, gap, rail_length, rail_height, end_post)
    layout = Layout(2, max(rail_length, rail_height))
    deep = max(h, min(coarse, rail_height / 6))
    levels = [(-rail_height, deep), (0.0, h)]
    if core is not None or joined is not None:
        levels.insert(1, (-joined if joined is not None else -min(core, rail_height / 4), 3 * h))
    glued = end_post == "glued" or joined is not None
    left = None
    for name, x0, x1, first, last in _spans(rail_length, gap, h, coarse, "glued" if glued else end_post):
        body = layout.body(name, glued_to=left if name == "end_post" and glued else None)
        if glued:
            left = left or body
            body.nodes = left.nodes
        columns = [(x0, first), (x1, last)]
        if core is not None and name != "end_post":
            columns.insert(1, (-core if x0 < 0 else core, h))
        _block_rows(layout, body, columns, levels[:2] if name == "end_post" and end_post == "none" else levels)
        _tag_rail(body, x0, x1, 1, -rail_height)
        body.tag("master_surface", at(1, 0.0))
        _shape_ends(body, corner, step, gap / 2, joined or rail_height)
    if wheel:
        fine = (a / 4, 1.5 * a) if core is None else (h, core)
        add_wheel(layout, wheel_gap, wheel_radius, hub_radius, *fine, core is not None)
        place_wheel(layout.bodies[-1], wheel_x, wheel_gap, wheel_radius, wheel_turn)
    return layout


def _check_core(core, corner, step, joined, h, gap, rail_length, rail_height, end_post):
    require(math.isfinite(corner) and corner >= 0, f"corner = {corner!r}: a radius of at least 0")
    require(corner == 0 or end_post == "none", f"corner = {corner!r}: rounded rail ends have no end post between them")
    require(abs(step) <= rail_height / 100, f"step = {step!r}: more than a hundredth of the rail, {rail_height!r}")
    require(step == 0 or end_post != "glued", f"step = {step!r}: a glued end post would be torn")
    require(corner < rail_height / 8, f"corner = {corner!r}: not below an eighth of the rail, {rail_height!r}")
    if joined is not None:
        require(4 * corner < joined < rail_height, f"joined = {joined!r}: between 4 corner and the rail's height")
        require(end_post != "loose", f"joined = {joined!r}: a loose end post reaches through the rail")
    if core is not None:
        positive(core=core)
        require(gap / 2 + h <= core < rail_length, f"core = {core!r}: between half the gap and the rail's length")


def _block_rows(layout, body, columns, levels):
    """Blocks between columns (x, size along x) and levels (y, size along y)."""
    p = [[body.point((x, y), min(sx, sy)) for x, sx in columns] for y, sy in levels]

    def sized(i, j, sizes):
        layout.edge_sizes[(min(i, j), max(i, j))] = sizes if i < j else sizes[::-1]

    for r, row in enumerate(p):
        for c in range(len(columns) - 1):
            sized(row[c], row[c + 1], (columns[c][1], columns[c + 1][1]))
            if r:
                body.block(p[r - 1][c], p[r - 1][c + 1], row[c + 1], row[c])
        if r:
            for c in range(len(columns)):
                sized(p[r - 1][c], row[c], (levels[r - 1][1], levels[r][1]))


def _shape_ends(body, corner, step, end, depth):
    """Maps of a rail: its end rounded within `corner` of x = +-`end`; the right one raised, but not below a depth."""

    def rounded(x):
        up = body.layout.dim - 1
        inside = np.clip(np.abs(x[:, 0]) - end, 0.0, corner)
        x[:, up] -= (corner - inside) ** 2 / (2 * corner) * np.maximum(0.0, 1.0 + x[:, up] / (4 * corner))
        return x

    def raised(x):
        up = body.layout.dim - 1
        x[:, up] += step * np.clip(1.0 + x[:, up] / depth, 0.0, 1.0)
        return x

    if corner > 0 and body.name != "end_post":
        body.map(rounded)
    if step and body.name == "second_rail":
        body.map(raised)


def _tag_rail(body, x0, x1, vertical, bottom):
    ends = {"master_body": ("left", "joint_left"), "second_rail": ("joint_right", "right")}
    for name, x in zip(ends.get(body.name, ("post_left", "post_right")), (x0, x1)):
        body.tag(name, at(0, x))
    body.tag("bottom", at(vertical, bottom))


def add_wheel(layout, gap, radius, hub_radius, h, core, rolling, **more):
    """A wheel of 2D blocks above the origin; if `rolling`, the fine zone is all that may touch, coarser above;
    `more`: of wheel_plan."""
    positive(wheel_radius=radius, hub_radius=hub_radius)
    require(gap >= 0, f"wheel_gap = {gap!r}: a height of at least 0")
    wheel = layout.body("slave_body")
    wheel_plan(
        wheel,
        radius,
        hub_radius,
        gap,
        h,
        core,
        SIDES["none"],
        None,
        3 * h if rolling else h,
        1 if rolling else 3,
        **more,
    )


def place_wheel(wheel, x, gap, radius, turn):
    """Turn a wheel about its axle and move it along x."""
    require(math.isfinite(x) and math.isfinite(turn), f"wheel_x = {x!r}, wheel_turn = {turn!r}: finite numbers")
    cos, sin, height = math.cos(turn), math.sin(turn), radius + gap

    def move(points):
        vertical = wheel.layout.dim - 1
        right, up = points[:, 0].copy(), points[:, vertical] - height
        points[:, 0] = x + cos * right - sin * up
        points[:, vertical] = height + sin * right + cos * up
        return points

    if x or turn:
        wheel.map(move)


def rail_joint_3d(
    rail_length=0.3, rail_height=RAIL_HEIGHT, crown_radius=0.30, gap=8.0e-3, end_post="glued", h=5.0e-3, coarse=0.04,
    core=None, corner=0.0, step=0.0, joined=False, symmetry="half", wheel=False, wheel_x=0.0,
    wheel_gap=0.0, wheel_radius=0.46, hub_radius=0.1, wheel_width=0.06,
    wheel_turn=0.0,
):  # fmt: skip
    """Rail joint in 3D, the rail section of `wheel_on_rail_3d`, all hexahedra or tetrahedra. The joint is at x = 0.

    rail_length: of each rail [m]
    rail_height: [m]
    crown_radius: transverse radius of the head [m]
    gap: between the rail ends [m]
    end_post: "glued", "loose" or "none"
    h: cell size at the running surface of the joint [m]
    coarse: at the far ends [m]
    core, corner, step: as of `rail_joint_2d` [m]
    joined: web and foot are one, as joint bars make them; what fills the gap there is "end_post"
    symmetry: "half" (y >= 0) or "none"
    wheel: whether there is a wheel above, its fine zone with cells of size h
    wheel_x: position of its lowest point [m]
    wheel_gap: height of that point [m]
    wheel_radius, hub_radius, wheel_width: [m]
    wheel_turn: angle by which the wheel's fine zone is turned forward from below [rad]
    """
    _common(rail_length, gap, h, coarse, end_post)
    positive(rail_height=rail_height, crown_radius=crown_radius, wheel_width=wheel_width)
    require(symmetry in SIDES, f"symmetry = {symmetry!r}: one of {', '.join(SIDES)}")
    _check_core(core, corner, step, HEAD_DEPTH if joined else None, h, gap, rail_length, rail_height, end_post)
    side = max(h, 0.3 * HEAD_HALF_WIDTH)
    glued = end_post == "glued" or joined
    layout = None
    for name, x0, x1, first, last in _spans(rail_length, gap, h, coarse, "glued" if joined else end_post):
        section = Layout(2, rail_height)
        body = section.body(name)
        head = name != "end_post" or end_post != "none"
        rail_plan(body, crown_radius, rail_height, h, side, SIDES[symmetry], max(h, min(coarse, 0.02)), head)
        if symmetry == "half":
            body.tag("symmetry_y", at(0, 0.0))
        ends = {"master_body": ("left", "joint_left"), "second_rail": ("joint_right", "right")}
        along = [(x0, first), (x1, last)]
        if core is not None and name != "end_post":
            along.insert(1, (-core if x0 < 0 else core, h))
        part = section.extruded(lambda x, t: (t, x[0], x[1]), *zip(*along), ends.get(name, ("post_left", "post_right")))
        _shape_ends(part.bodies[0], corner, step, gap / 2, HEAD_DEPTH if joined else rail_height)
        if layout is None:
            layout = part
        else:
            layout.merge(part, glued=glued)
    if wheel:
        plan = Layout(2, wheel_radius)
        add_wheel(plan, wheel_gap, wheel_radius, hub_radius, h, side if core is None else core, core is not None)
        half = wheel_width / 2
        ys = (0.0, side, half) if symmetry == "half" else (-half, -side, side, half)
        sizes = (h, h, max(h, half / 4)) if symmetry == "half" else (max(h, half / 4), h, h, max(h, half / 4))
        require(side < half, f"wheel_width = {wheel_width!r}: too small for the fine zone, {side!r}")
        ends = ("symmetry_y" if symmetry == "half" else "slave_front", "slave_back")
        layout.merge(plan.extruded(lambda x, t: (x[0], t, x[1]), ys, sizes, ends))
        place_wheel(layout.bodies[-1], wheel_x, wheel_gap, wheel_radius, wheel_turn)
    return layout


RECIPES = (rail_joint_2d, rail_joint_3d)
