# SPDX-License-Identifier: MIT
"""Wheel on rail: in the longitudinal plane, and in 3D with a rail of standard height and a crowned head.

x is the rolling direction, y (3D) the transverse one, the last axis is vertical; the contact point is the origin, the
rail lies below it. Wheel and rail are separate bodies with separate nodes.
"""

import math

import numpy as np

from .hertz import SIDES, fine_zone, graded_half_plane
from .layout import Layout, at, positive, require

# Simplified 60E1 section, right half, as (y, z) with z = 0 at the top of the head [m]. Its area is within 3 % of the
# 76.7 cm^2 of the standard rail; gauge corners and fillets are left out, the crown is one arc.
RAIL_HEIGHT = 0.172
HEAD_HALF_WIDTH = 0.036
HEAD_SIDE_DEPTH = 0.036
HEAD_DEPTH = 0.047
WEB_HALF_WIDTH = 0.00825
FOOT_HALF_WIDTH = 0.075
FOOT_EDGE = 0.0115
FOOT_DEPTH = 0.030


def wheel_plan(
    body, radius, hub_radius, gap, h, core, sides, coarse, deep=None, num_arcs=3, depth=None, corner=(0.13, 0.15, 0.185)
):  # fmt: skip
    """Blocks of a wheel (annulus) whose lowest point is (0, gap), fine at that point; `deep`: cell size at the upper
    end of the fine zone, default h; `num_arcs`: those of the rim, from below, that may touch, the first is fine;
    `depth` of the fine zone, default core; `corner`: where blocks above it meet, over the radius: forward, upward, and
    upward in the middle."""
    require(hub_radius < 0.5 * radius, f"hub_radius = {hub_radius!r}: not less than half the radius, {radius!r}")
    require(core <= 0.1 * radius, f"core = {core!r}: larger than 0.1 of the wheel radius, {radius!r}")
    centre = np.array((0.0, radius + gap))
    far, t = max(h, radius / 8 if coarse is None else coarse), core / radius
    deep, depth = h if deep is None else deep, core if depth is None else depth

    def polar(s, r, degrees, size):
        angle = math.radians(degrees)
        return body.point((s * r * math.sin(angle), centre[1] - r * math.cos(angle)), size)

    near, bore_size = min(far, h + 0.03 * radius), max(h, min(far, 0.35 * hub_radius))
    for s in sides:
        a, d = body.point((0, gap), h), body.point((0, depth + gap), deep)
        b, c = polar(s, radius, math.degrees(t), h), body.point((s * core, depth + gap), deep)
        e, f = polar(s, radius, 15, near), body.point((s * corner[0] * radius, corner[1] * radius + gap), near)
        g, lowest = body.point((0, corner[2] * radius + gap), near), polar(s, hub_radius, 0, bore_size)
        rim, bore = [], []
        for outer, inner in ((60, 50), (105, 100), (145, 140), (180, 180)):
            rim.append(polar(s, radius, outer, far))
            bore.append(polar(s, hub_radius, inner, bore_size))
        for block in ((a, b, c, d), (b, e, f, c), (d, c, f, g), (e, rim[0], bore[0], f), (g, f, bore[0], lowest)):
            body.block(*block)
        for k in range(3):
            body.block(rim[k], rim[k + 1], bore[k + 1], bore[k])
        arcs = [(a, b), (b, e), (e, rim[0]), *zip(rim, rim[1:])]
        for k, (p, q) in enumerate(arcs):
            body.arc(p, q, centre)
            body.facet("slave_surface" if k < num_arcs else "free", p, q)
        for p, q in [(lowest, bore[0]), *zip(bore, bore[1:])]:
            body.arc(p, q, centre)
            body.facet("hub", p, q)
    return centre


def wheel_on_rail_2d(
    radius=0.46, hub_radius=0.1, a=4.5e-3, h=None, core=None, rail_length=1.2, rail_height=RAIL_HEIGHT, gap=0.0,
    symmetry="none", coarse=None,
):  # fmt: skip
    """Wheel on rail in the longitudinal plane (plane strain or stress), quadrilaterals or triangles.

    radius: of the wheel [m]
    hub_radius: of its bore, tagged "hub" [m]
    a: expected half-width of the contact [m]
    h: cell size in the contact, default a/6 [m]
    core: half-width of the fine zone, default 1.5 a [m]
    rail_length: [m]
    rail_height: [m]
    gap: between wheel and rail [m]
    symmetry: "none" or "half" (x >= 0)
    coarse: largest cell size, default radius/8 in the wheel and rail_height/4 in the rail [m]
    """
    positive(radius=radius, hub_radius=hub_radius, rail_length=rail_length, rail_height=rail_height)
    require(symmetry in SIDES, f"symmetry = {symmetry!r}: one of {', '.join(SIDES)}")
    h, core = fine_zone(a, h, core, 6)
    layout = Layout(2, max(radius, rail_length))
    rail, wheel = layout.body("master_body"), layout.body("slave_body")
    graded_half_plane(rail, rail_length / 2, rail_height, h, core, SIDES[symmetry], coarse)
    centre = wheel_plan(wheel, radius, hub_radius, gap, h, core, SIDES[symmetry], coarse)
    rail.tag("master_surface", at(1, 0.0))
    rail.tag("bottom", at(1, -rail_height))
    rail.tag("right", at(0, rail_length / 2))
    if symmetry == "half":
        rail.tag("symmetry_x", at(0, 0.0))
        wheel.tag("symmetry_x", at(0, 0.0))
    rail.tag("left", at(0, -rail_length / 2))

    def on_wheel(x):
        r = x - (*centre, 0)
        return (*centre, 0) + r * (radius / np.linalg.norm(r, axis=1))[:, None]

    layout.snap["slave_surface"] = on_wheel
    return layout


def crown(y, crown_radius):
    """Height of the rail head at the transverse coordinate y, zero at the top [m]."""
    return math.sqrt(crown_radius**2 - y**2) - crown_radius


def rail_plan(body, crown_radius, height, h, core, sides, coarse, head=True):
    """Blocks of the rail section in (y, z), fine at the top of the head; `height` stretches the web. Without its
    `head` the section begins at HEAD_DEPTH."""
    w, foot = WEB_HALF_WIDTH, height - FOOT_DEPTH
    require(height > HEAD_DEPTH + FOOT_DEPTH + 0.01, f"rail_height = {height!r}: no room for a web")
    require(core < 0.6 * HEAD_HALF_WIDTH, f"core = {core!r}: not smaller than 0.6 of the head's half-width")
    require(crown_radius >= HEAD_HALF_WIDTH * 2, f"crown_radius = {crown_radius!r}: smaller than the head is wide")
    far = max(h, 0.02 if coarse is None else coarse)
    near = max(h, min(far, 0.008))
    for s in sides:

        def p(y, z, size):
            return body.point((s * y, z), size)

        i, j = p(w, -HEAD_DEPTH, near), p(0, -HEAD_DEPTH, near)
        k, m = p(w, -foot, near), p(0, -foot, near)
        n, o = p(w, -height, near), p(0, -height, near)
        q, r = p(FOOT_HALF_WIDTH, -height + FOOT_EDGE, far), p(FOOT_HALF_WIDTH, -height, far)
        if head:
            side, middle = crown(HEAD_HALF_WIDTH, crown_radius), -HEAD_SIDE_DEPTH / 2
            a, b, c, d = p(0, 0, h), p(core, crown(core, crown_radius), h), p(core, -core, h), p(0, -core, h)
            e, f, g = (p(HEAD_HALF_WIDTH, z, near) for z in (side, middle, -HEAD_SIDE_DEPTH))
            body.arc(a, b, (0, -crown_radius))
            body.arc(b, e, (0, -crown_radius))
            body.facet("master_surface", a, b)
            body.facet("master_surface", b, e)
            for block in ((a, b, c, d), (b, e, f, c), (c, f, g, i), (d, c, i, j)):
                body.block(*block)
        for block in ((j, i, k, m), (m, k, n, o), (k, q, r, n)):
            body.block(*block)
    body.tag("bottom", at(1, -height))


def rail_area(crown_radius, height):
    """Area of the simplified rail section [m^2]."""
    b, r = HEAD_HALF_WIDTH, crown_radius
    cap = b * math.sqrt(r * r - b * b) / 2 + r * r * math.asin(b / r) / 2 - r * b  # integral of crown, 0 to b: negative
    head = b * HEAD_SIDE_DEPTH + cap + (b + WEB_HALF_WIDTH) / 2 * (HEAD_DEPTH - HEAD_SIDE_DEPTH)
    return 2 * head + web_and_foot_area(height)


def web_and_foot_area(height):
    """Area of the section below the head [m^2]."""
    web = WEB_HALF_WIDTH * (height - HEAD_DEPTH)
    wing = (FOOT_HALF_WIDTH - WEB_HALF_WIDTH) * (FOOT_EDGE + FOOT_DEPTH) / 2
    return 2 * (web + wing)


def wheel_on_rail_3d(
    radius=0.46, hub_radius=0.1, crown_radius=0.30, wheel_crown_radius=math.inf, a=7.0e-3, h=None, core=None,
    rail_length=0.6, rail_height=RAIL_HEIGHT, wheel_width=0.06, gap=0.0, symmetry="half", coarse=None,
):  # fmt: skip
    """Wheel on rail in 3D, hexahedra or tetrahedra.

    radius: of the wheel [m]
    hub_radius: of its bore, tagged "hub" [m]
    crown_radius: transverse radius of the rail head [m]
    wheel_crown_radius: transverse radius of the tread, default flat [m]
    a: expected half-axis of the contact [m]
    h: cell size in the contact, default a/3 [m]
    core: half-width of the fine zone, default 1.5 a [m]
    rail_length: [m]
    rail_height: [m]
    wheel_width: along y [m]
    gap: between wheel and rail [m]
    symmetry: "half" (y >= 0), "quarter" (x, y >= 0) or "none"
    coarse: largest cell size, default radius/8 in the wheel, 20 mm in the rail section, rail_length/ 12 along
        the rail [m]
    """
    positive(radius=radius, hub_radius=hub_radius, crown_radius=crown_radius, rail_length=rail_length)
    positive(rail_height=rail_height, wheel_width=wheel_width)
    require(symmetry in ("none", "half", "quarter"), f"symmetry = {symmetry!r}: one of none, half, quarter")
    h, core = fine_zone(a, h, core, 3)
    half_width, half_length = wheel_width / 2, rail_length / 2
    require(core < half_width, f"wheel_width = {wheel_width!r}: too small for the fine zone, core = {core!r}")
    require(core < half_length, f"rail_length = {rail_length!r}: too small for the fine zone, core = {core!r}")
    require(wheel_crown_radius > 2 * half_width, f"wheel_crown_radius = {wheel_crown_radius!r}: not above wheel_width")
    x_sides = SIDES["half" if symmetry == "quarter" else "none"]
    y_sides = SIDES["none" if symmetry == "none" else "half"]

    def levels(end, far, sides):
        right = [(0.0, h), (core, h), (end, far)]
        return [(-x, size) for x, size in right[:0:-1]] + right if len(sides) == 2 else right

    section = Layout(2, rail_height)
    rail_plan(section.body("master_body"), crown_radius, rail_height, h, core, y_sides, coarse)
    section.bodies[0].tag("symmetry_y", at(0, 0.0))
    along = levels(half_length, max(h, rail_length / 12 if coarse is None else coarse), x_sides)
    layout = section.extruded(
        lambda x, t: (t, x[0], x[1]), *zip(*along), ("left" if symmetry != "quarter" else "symmetry_x", "right")
    )

    plan = Layout(2, radius)
    centre = wheel_plan(plan.body("slave_body"), radius, hub_radius, gap, h, core, x_sides, coarse)
    if symmetry == "quarter":
        plan.bodies[0].tag("symmetry_x", at(0, 0.0))
    across = levels(half_width, max(h, half_width / 4), y_sides)
    wheel = plan.extruded(
        lambda x, t: (x[0], t, x[1]),
        *zip(*across),
        ("symmetry_y" if symmetry != "none" else "slave_front", "slave_back"),
    )
    layout.merge(wheel)

    def on_wheel(x):
        r = x[:, [0, 2]] - centre
        x[:, [0, 2]] = centre + r * (radius / np.linalg.norm(r, axis=1))[:, None]
        return tread(x)

    def tread(x):
        if math.isfinite(wheel_crown_radius):
            drop = wheel_crown_radius - np.sqrt(wheel_crown_radius**2 - x[:, 1] ** 2)
            r = x[:, [0, 2]] - centre
            distance = np.linalg.norm(r, axis=1)
            share = (distance - hub_radius) / (radius - hub_radius)
            x[:, [0, 2]] -= r * (share * drop / distance)[:, None]
        return x

    if math.isfinite(wheel_crown_radius):
        layout.bodies[-1].map(tread)
    else:
        layout.snap["slave_surface"] = on_wheel

    def on_crown(x):
        x[:, 2] = np.sqrt(crown_radius**2 - x[:, 1] ** 2) - crown_radius
        return x

    layout.snap["master_surface"] = on_crown
    return layout


RECIPES = (wheel_on_rail_2d, wheel_on_rail_3d)
