# SPDX-License-Identifier: MIT
"""Insulated rail joint in 3D: rails, end post, joint bars that are glued to the webs, and a wheel above.

x is the rolling direction, y the transverse one, z is vertical; the running surface at the middle of the head is z = 0
and the joint is at x = 0.
"""

import math

import numpy as np
import scipy  # which imports scipy.interpolate where it is used

from .hertz import SIDES
from .layout import Layout, at, positive, require
from .rail_joint import add_wheel, place_wheel
from .wheel_rail import (
    FOOT_DEPTH, HEAD_DEPTH, HEAD_HALF_WIDTH, HEAD_SIDE_DEPTH, RAIL_HEIGHT, WEB_HALF_WIDTH, crown, rail_plan,
)  # fmt: skip

ENDS = {"master_body": ("left", "joint_left"), "second_rail": ("joint_right", "right")}
TIED = ("none", "bars", "all")
FINE_SIDE = 0.3 * HEAD_HALF_WIDTH  # half-width and depth of the fine zone


def section(name, crown_radius, rail_height, h, coarse, sides, core, bars=None, faced=False):
    """Plan (y, z) of the rail, or of the end post, fine in `core`, with the joint bars beside its web: `bars` is their
    thickness and that of the glue. `faced`: the web has a name, as bars of another mesh face it."""
    plan = Layout(2, rail_height)
    rail = plan.body(name)
    rail_plan(rail, crown_radius, rail_height, h, core, sides, coarse)
    if len(sides) == 1:
        rail.tag("symmetry_y", at(0, 0.0))
    if bars:
        add_bars(plan, rail, rail_height, max(h, min(coarse, 0.008)), sides, *bars)
    for s in sides if faced else ():
        rail.facet("web", *(rail.point((s * WEB_HALF_WIDTH, z), coarse) for z in web_ends(rail_height)))
    return plan


def web_ends(rail_height):
    """Heights between which the web is plane."""
    return -HEAD_DEPTH, FOOT_DEPTH - rail_height


def add_bars(plan, rail, rail_height, size, sides, bar, glue):
    """Glue and joint bars beside the web, with the nodes of a rail, or with their own where it is None."""
    top, foot = web_ends(rail_height)
    places = np.cumsum([WEB_HALF_WIDTH, glue, bar])
    layer = plan.body("glue", glued_to=rail)
    bodies = layer, plan.body("joint_bar", glued_to=layer)
    for s in sides:
        for body, inner, outer in zip(bodies, places, places[1:]):
            corners = (inner, top), (outer, top), (outer, foot), (inner, foot)
            body.block(*(body.point((s * y, z), size) for y, z in corners))
        if rail is None:
            layer.facet("bar_face", *(layer.point((s * places[0], z), size) for z in (top, foot)))


def profiled(profile, crown_radius):
    """Map that brings the head from its crown to a profile of points."""
    y, z = np.asarray(profile, dtype=float).T
    top = scipy.interpolate.PchipInterpolator(y, z)
    top_of = top(0.0)

    def to_profile(x):
        across = np.clip(x[:, 1], -HEAD_HALF_WIDTH, HEAD_HALF_WIDTH)
        height = np.array([crown(v, crown_radius) for v in across])
        share = np.clip(1.0 + (x[:, 2] - height) / HEAD_SIDE_DEPTH, 0.0, 1.0)
        x[:, 2] += share * (top(across) - top_of - height)
        return x

    return to_profile


def _check_profile(profile):
    points = np.asarray(profile, dtype=float)
    require(
        points.ndim == 2 and points.shape[1] == 2 and len(points) >= 3, "head_profile: at least three points (y, z)"
    )
    require(np.all(np.isfinite(points)) and np.all(np.diff(points[:, 0]) > 0), "head_profile: y must ascend")
    reach = points[0, 0] <= -HEAD_HALF_WIDTH and points[-1, 0] >= HEAD_HALF_WIDTH
    require(reach, f"head_profile: its points must reach from y = {-HEAD_HALF_WIDTH} to {HEAD_HALF_WIDTH}")


def coned(cone, fillet, fillet_at, radius, hub_radius, height):
    """Map of a cylindrical wheel: tread of slope `cone`, flange fillet, the axis tilted so that the tread is level."""

    def drop(y):
        beyond = np.clip(-y - fillet_at, 0.0, 0.7 * fillet) if fillet else 0.0 * y
        return cone * y - (fillet - np.sqrt(fillet**2 - beyond**2) if fillet else 0.0)

    def to_tread(x):
        across = x[:, 1].copy()
        along, up = x[:, 0].copy(), x[:, 2] - height
        distance = np.hypot(along, up)
        share = (distance - hub_radius) / (radius - hub_radius)
        factor = 1.0 - share * drop(across) / distance
        x[:, 0], up = along * factor, up * factor
        # About the contact point, by the angle of the cone: what was the tread's line is level again.
        cos, sin = 1.0 / math.hypot(1.0, cone), cone / math.hypot(1.0, cone)
        y, z = across, up + radius
        x[:, 1], x[:, 2] = cos * y + sin * z, height - radius - sin * y + cos * z
        return x

    return to_tread


def _extruded(plan, along, ends):
    """The plan (y, z) along x: places and sizes of cells there, names of the ends by body."""
    return plan.extruded(lambda x, t: (t, x[0], x[1]), *zip(*along), lambda body: ends[body])


def insulated_joint_3d(
    rail_length=1.5, rail_height=RAIL_HEIGHT, crown_radius=0.30, head_profile=None, gap=8.0e-3, bar_length=0.9,
    bar=0.022, glue=2.0e-3, h=4.0e-3, coarse=0.05, path=(-0.035, 0.039), margin=8.0e-3, symmetry="half",
    wheel_x=-0.035, wheel_gap=0.0, wheel_radius=0.46, hub_radius=0.1, wheel_width=0.06, cone=0.0, fillet=0.0,
    tied="none", tied_size=1.5,
):  # fmt: skip
    """Insulated rail joint in 3D with a wheel that rolls over it; hexahedra. The joint is at x = 0.

    rail_length: from the joint to the far end of each rail [m]
    rail_height: [m]
    crown_radius: transverse radius of the head [m]
    head_profile: points (y, z) of the head from left to right instead of the crown, for symmetry = "none" [m]
    gap: between the rail ends, filled by the end post [m]
    bar_length: of the joint bars, half of it on each rail [m]
    bar: thickness of the joint bars [m]
    glue: thickness of the insulating layer between web and joint bar [m]
    h: cell size at the running surface on the path [m]
    coarse: largest cell size [m]
    path: from where to where the wheel's centre rolls [m]
    margin: by which the fine zone is longer than the path at both ends [m]
    symmetry: "half" (y >= 0) or "none"
    wheel_x: where the wheel's centre is [m]
    wheel_gap: height of its lowest point [m]
    wheel_radius, hub_radius, wheel_width: [m]
    cone: slope of the tread; the rail is inclined alike, so that wheel and rail touch in the middle of the head [1]
    fillet: radius of the flange's fillet at y = -wheel_width/3, 0: none [m]
    tied: parts with nodes of their own, which a tie has to hold: "none", "bars" (bars and glue, whose "bar_face" faces
        "web") or "all" (the end post, too: "post_left" faces "joint_left", "post_right" "joint_right")
    tied_size: size of their cells over that of the rails' beside them [1]
    """
    positive(rail_length=rail_length, rail_height=rail_height, crown_radius=crown_radius, gap=gap, bar=bar, glue=glue)
    positive(h=h, coarse=coarse, margin=margin, wheel_radius=wheel_radius, wheel_width=wheel_width)
    positive(bar_length=bar_length)
    require(symmetry in SIDES, f"symmetry = {symmetry!r}: one of {', '.join(SIDES)}")
    require(len(path) == 2 and path[0] < path[1], f"path = {path!r}: from where to where")
    first, last = path[0] - margin, path[1] + margin
    ends = max(-first, last, gap / 2 + h)
    require(bar_length / 2 > ends, f"bar_length = {bar_length!r}: half of it must exceed the fine zone, {ends:.3g}")
    require(bar_length / 2 < rail_length, f"bar_length = {bar_length!r}: longer than the rails")
    require(path[0] <= wheel_x <= path[1], f"wheel_x = {wheel_x!r}: outside the path {path!r}")
    require(abs(cone) < 0.2 and 0.0 <= fillet < wheel_width, f"cone = {cone!r}, fillet = {fillet!r}: too large")
    whole = symmetry == "none"
    require(whole or (cone == 0.0 and fillet == 0.0), f"symmetry = {symmetry!r}: a coned tread needs the whole model")
    if head_profile is not None:
        require(whole, "head_profile: a profile of points needs the whole model, symmetry = 'none'")
        _check_profile(head_profile)
    require(tied in TIED, f"tied = {tied!r}: one of {', '.join(TIED)}")
    positive(tied_size=tied_size)
    half, sides = gap / 2, SIDES[symmetry]
    left, right = min(first, -half - h), max(last, half + h)
    middle = max(h, min(coarse, 0.25 * bar_length))
    own = tied_size * min(h, gap) if tied == "all" else min(h, gap)
    parts = [
        ("master_body", False, ((-rail_length, coarse), (-bar_length / 2, middle))),
        ("master_body", True, ((-bar_length / 2, middle), (left, h), (-half, h))),
        ("end_post", True, ((-half, own), (half, own))),
        ("second_rail", True, ((half, h), (right, h), (bar_length / 2, middle))),
        ("second_rail", False, ((bar_length / 2, middle), (rail_length, coarse))),
    ]
    post = ("post_left", "post_right") if tied == "all" else ("free", "free")
    outer = {"glue": ("free", "free"), "joint_bar": ("free", "free"), "end_post": post, **ENDS}
    core, layout = max(h, FINE_SIDE), None
    for name, barred, along in parts:
        apart = name == "end_post" and tied == "all"
        sizes = (tied_size * h, tied_size * coarse) if apart else (h, coarse)
        beside = (bar, glue) if barred and tied == "none" else None
        plan = section(name, crown_radius, rail_height, *sizes, sides, core, beside, barred and tied != "none")
        part = _extruded(plan, along, outer)
        if layout is None:
            layout = part
        else:
            layout.merge(part, glued=not apart)
    if tied != "none":
        plan, end, fine = Layout(2, rail_height), tied_size * middle, tied_size * h
        add_bars(plan, None, rail_height, tied_size * max(h, min(coarse, 0.008)), sides, bar, glue)
        along = [(-bar_length / 2, end), (left, fine), (right, fine), (bar_length / 2, end)]
        layout.merge(_extruded(plan, along, outer))
    if head_profile is not None:
        to_profile = profiled(head_profile, crown_radius)
        for body in layout.bodies:
            if body.name in (*ENDS, "end_post"):
                body.map(to_profile)
    layout.made_of = ("hexahedron",)  # gmsh's free tetrahedra do not fill the thin layers of glue well
    _add_wheel(layout, h, path, margin, whole, wheel_x, wheel_gap, wheel_radius, hub_radius, wheel_width, cone, fillet)
    return layout


def _add_wheel(layout, h, path, margin, whole, x, gap, radius, hub_radius, width, cone, fillet):
    """The wheel; its fine zone is what will touch on the path, symmetric about where it touches half way."""
    plan, core = Layout(2, radius), 0.5 * (path[1] - path[0]) + margin
    side, half = max(h, FINE_SIDE), width / 2
    add_wheel(plan, gap, radius, hub_radius, h, core, True, depth=max(2 * h, 2 * side), corner=(0.2, 0.19, 0.24))
    require(side < half, f"wheel_width = {width!r}: too small for the fine zone, {side!r}")
    ys, sizes = [0.0, side, half], [h, h, max(h, half / 4)]
    if whole:
        ys, sizes = [-y for y in ys[:0:-1]] + ys, sizes[:0:-1] + sizes
    ends = ("slave_front" if whole else "symmetry_y", "slave_back")
    layout.merge(plan.extruded(lambda p, t: (p[0], t, p[1]), ys, sizes, ends))
    wheel, turn = layout.bodies[-1], (0.5 * (path[0] + path[1]) - x) / radius
    place_wheel(wheel, 0.0, gap, radius, turn)
    if cone or fillet:
        wheel.map(coned(cone, fillet, width / 3, radius, hub_radius, radius + gap))
    if x:
        place_wheel(wheel, x, gap, radius, 0.0)


RECIPES = (insulated_joint_3d,)
