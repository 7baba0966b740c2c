"""Rail joint: two rail ends with a gap, an end post in it, and a wheel above if wanted."""

import math

from .hertz import SIDES
from .layout import Layout, at, positive, require
from .wheel_rail import HEAD_HALF_WIDTH, RAIL_HEIGHT, rail_plan, wheel_plan


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
    rail_length=0.6, rail_height=RAIL_HEIGHT, gap=8.0e-3, end_post="glued", h=4.0e-3, coarse=0.03, wheel=False,
    wheel_x=0.0, wheel_gap=0.0, wheel_radius=0.46, hub_radius=0.1, a=4.5e-3,
):  # fmt: skip
    """Rail joint in the longitudinal plane. The running surface is y = 0, the joint is at x = 0.

    rail_length: of each rail [m]
    rail_height: [m]
    gap: between the rail ends [m]
    end_post: "glued" (shares the nodes of the rail ends), "loose" (separate nodes) or "none"
    h: cell size at the joint [m]
    coarse: at the far ends [m]
    wheel: whether there is a wheel above
    wheel_x: position of its lowest point [m]
    wheel_gap: height of that point [m]
    wheel_radius, hub_radius: [m]
    a: expected half-width of the contact, the wheel's cells there are a/4 [m]
    """
    _common(rail_length, gap, h, coarse, end_post)
    positive(rail_height=rail_height, a=a)
    layout = Layout(2, max(rail_length, rail_height))
    deep = max(h, min(coarse, rail_height / 6))
    left = None
    for name, x0, x1, first, last in _spans(rail_length, gap, h, coarse, end_post):
        body = layout.body(name, glued_to=left if name == "end_post" and end_post == "glued" else None)
        if end_post == "glued":
            left = left or body
            body.nodes = left.nodes
        p = [body.point((x, y), s) for y, s in ((-rail_height, deep), (0.0, h)) for x in (x0, x1)]
        body.block(p[0], p[1], p[3], p[2])
        for i, j, sizes in ((0, 1, (first, last)), (2, 3, (first, last)), (0, 2, (deep, h)), (1, 3, (deep, h))):
            layout.edge_sizes[(min(p[i], p[j]), max(p[i], p[j]))] = sizes if p[i] < p[j] else sizes[::-1]
        _tag_rail(body, x0, x1, 1, -rail_height)
        body.tag("master_surface", at(1, 0.0))
    if wheel:
        add_wheel(layout, wheel_x, wheel_gap, wheel_radius, hub_radius, a / 4, 1.5 * a)
    return layout


def _tag_rail(body, x0, x1, vertical, bottom):
    ends = {"master_body": ("left", "joint_left"), "second_rail": ("joint_right", "right")}
    for name, x in zip(ends.get(body.name, ("post_left", "post_right")), (x0, x1)):
        body.tag(name, at(0, x))
    body.tag("bottom", at(vertical, bottom))


def add_wheel(layout, x, gap, radius, hub_radius, h, core):
    """A wheel of 2D blocks above the point (x, 0)."""
    positive(wheel_radius=radius, hub_radius=hub_radius)
    require(
        gap >= 0 and math.isfinite(x), f"wheel_gap = {gap!r}, wheel_x = {x!r}: a height of at least 0 and a position"
    )
    wheel = layout.body("slave_body")
    wheel_plan(wheel, radius, hub_radius, gap, h, core, SIDES["none"], None)

    def move(points):
        points[:, 0] += x
        return points

    if x:
        wheel.map(move)


def rail_joint_3d(
    rail_length=0.3, rail_height=RAIL_HEIGHT, crown_radius=0.30, gap=8.0e-3, end_post="glued", h=5.0e-3, coarse=0.04,
    symmetry="half", wheel=False, wheel_x=0.0, wheel_gap=0.0, wheel_radius=0.46, hub_radius=0.1, wheel_width=0.06,
):  # fmt: skip
    """Rail joint in 3D, the rail section of `wheel_on_rail_3d`, all hexahedra or tetrahedra. The joint is at x = 0.

    rail_length: of each rail [m]
    rail_height: [m]
    crown_radius: transverse radius of the head [m]
    gap: between the rail ends [m]
    end_post: "glued", "loose" or "none"
    h: cell size at the running surface of the joint [m]
    coarse: at the far ends [m]
    symmetry: "half" (y >= 0) or "none"
    wheel: whether there is a wheel above, its fine zone with cells of size h
    wheel_x: position of its lowest point [m]
    wheel_gap: height of that point [m]
    wheel_radius, hub_radius, wheel_width: [m]
    """
    _common(rail_length, gap, h, coarse, end_post)
    positive(rail_height=rail_height, crown_radius=crown_radius, wheel_width=wheel_width)
    require(symmetry in SIDES, f"symmetry = {symmetry!r}: one of {', '.join(SIDES)}")
    core = max(h, 0.3 * HEAD_HALF_WIDTH)
    layout = None
    for name, x0, x1, first, last in _spans(rail_length, gap, h, coarse, end_post):
        section = Layout(2, rail_height)
        body = section.body(name)
        rail_plan(body, crown_radius, rail_height, h, core, SIDES[symmetry], max(h, min(coarse, 0.02)))
        if symmetry == "half":
            body.tag("symmetry_y", at(0, 0.0))
        ends = {"master_body": ("left", "joint_left"), "second_rail": ("joint_right", "right")}
        part = section.extruded(
            lambda x, t: (t, x[0], x[1]), (x0, x1), (first, last), ends.get(name, ("post_left", "post_right"))
        )
        if layout is None:
            layout = part
        else:
            layout.merge(part, glued=end_post == "glued")
    if wheel:
        plan = Layout(2, wheel_radius)
        add_wheel(plan, 0.0, wheel_gap, wheel_radius, hub_radius, h, core)
        half = wheel_width / 2
        ys = (0.0, core, half) if symmetry == "half" else (-half, -core, core, half)
        sizes = (h, h, max(h, half / 4)) if symmetry == "half" else (max(h, half / 4), h, h, max(h, half / 4))
        require(core < half, f"wheel_width = {wheel_width!r}: too small for the fine zone, {core!r}")
        ends = ("symmetry_y" if symmetry == "half" else "slave_front", "slave_back")
        layout.merge(plan.extruded(lambda x, t: (x[0] + wheel_x, t, x[1]), ys, sizes, ends))
    return layout


RECIPES = (rail_joint_2d, rail_joint_3d)
