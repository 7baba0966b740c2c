# SPDX-License-Identifier: MIT
"""Round on flat, graded to the contact: cylinder on half-plane (also the axisymmetric sphere), sphere on half-space.

The contact point is the origin. A fine zone of half-width `core` with cells of size `h` is surrounded by blocks whose
cells grow outwards; the same building blocks serve the cone and the wheel on rail.
"""

import math

import numpy as np

from .layout import Layout, at, positive, require

SIDES = {"none": (1.0, -1.0), "half": (1.0,)}
QUARTERS = {
    "none": ((1, 1), (-1, 1), (-1, -1), (1, -1)),
    "half": ((1, 1), (-1, 1)),  # one half y >= 0: symmetry_y
    "quarter": ((1, 1),),
}


def fine_zone(a, h, core, default_cells):
    """Sizes of the fine zone, with their defaults: h = a/default_cells, core = 1.5 a."""
    positive(a=a)
    h = a / default_cells if h is None else h
    core = 1.5 * a if core is None else core
    positive(h=h, core=core)
    require(h <= core, f"h = {h!r}: larger than the fine zone, core = {core!r}")
    return h, core


def graded_half_plane(body, width, height, h, core, sides, coarse=None):
    """Blocks of 0 >= y >= -height, |x| <= width, with the fine zone at the origin. `coarse`: largest cell size."""
    near = min(width, height)
    require(core < near, f"core = {core!r}: not smaller than the block, {near!r}")
    far = max(h, near / 4 if coarse is None else coarse)
    for s in sides:
        p = {}
        for name, (x, y), size in (
            ("a", (0, 0), h), ("b", (core, 0), h), ("c", (core, -core), h), ("d", (0, -core), h),
            ("e", (near, 0), far), ("f", (near, -near), far), ("g", (0, -near), far),
        ):  # fmt: skip
            p[name] = body.point((s * x, y), size)
        for corners in ("abcd", "befc", "dcfg"):
            body.block(*(p[k] for k in corners))
        if width > near * (1 + 1e-9):
            body.block(p["e"], body.point((s * width, 0), far), body.point((s * width, -near), far), p["f"])
        elif height > near * (1 + 1e-9):
            body.block(p["g"], p["f"], body.point((s * near, -height), far), body.point((0, -height), far))


def graded_disc(body, radius, gap, h, core, sides, whole, coarse=None):
    """Blocks of a disc whose lowest point is (0, gap): the lower half, or the `whole`."""
    far = max(h, radius / 4 if coarse is None else coarse)
    require(core <= 0.36 * radius, f"core = {core!r}: larger than 0.36 of the radius, {radius!r}")
    t = core / radius
    centre = (0, radius + gap)
    for s in sides:
        p = {}
        for name, (x, y), size in (
            ("a", (0, 0), h), ("b", (radius * math.sin(t), radius * (1 - math.cos(t))), h), ("c", (core, core), h),
            ("d", (0, core), h), ("e", (radius, radius), far), ("f", (0.62 * radius, radius), far),
            ("g", (0, radius), far),
            ("h", (0.52 * radius, 1.45 * radius), far), ("i", (0, 1.57 * radius), far), ("k", (0, 2 * radius), far),
            ("j", (radius * math.sqrt(0.5), radius * (1 + math.sqrt(0.5))), far),
        ):  # fmt: skip
            if whole or name in "abcdefg":
                p[name] = body.point((s * x, y + gap), size)
        body.arc(p["a"], p["b"], centre)
        body.arc(p["b"], p["e"], centre)
        for corners in ("abcd", "befc", "dcfg") + (("gfhi", "fejh", "ihjk") if whole else ()):
            body.block(*(p[k] for k in corners))
        body.facet("slave_surface", p["a"], p["b"])
        body.facet("slave_surface", p["b"], p["e"])
        if whole:
            body.arc(p["e"], p["j"], centre)
            body.arc(p["j"], p["k"], centre)
            body.facet("load", p["j"], p["k"])


def cylinder_on_half_plane(
    radius=0.05, a=6.0e-3, h=None, core=None, width=0.1, height=0.2, gap=0.0, symmetry="half", whole=False, coarse=None
):
    """A long cylinder on a block, plane; with symmetry="half" also a sphere on a half-space, x being the radius.

    radius: of the cylinder [m]
    a: expected half-width of the contact [m]
    h: cell size in the contact, default a/10 [m]
    core: half-width of the fine zone, default 1.5 a [m]
    width: half-width of the block [m]
    height: of the block [m]
    gap: between the bodies [m]
    symmetry: "half" (x >= 0) or "none"
    whole: the whole disc with "load" as its uppermost quarter, else the lower half disc with "top" as its flat
        side
    coarse: largest cell size, default a quarter of the radius and of the block [m]
    """
    positive(radius=radius, width=width, height=height)
    require(symmetry in SIDES, f"symmetry = {symmetry!r}: one of {', '.join(SIDES)}")
    h, core = fine_zone(a, h, core, 10)
    layout = Layout(2, max(radius, width, height))
    master, slave = layout.body("master_body"), layout.body("slave_body")
    graded_half_plane(master, width, height, h, core, SIDES[symmetry], coarse)
    graded_disc(slave, radius, gap, h, core, SIDES[symmetry], whole, coarse)
    master.tag("master_surface", at(1, 0.0))
    master.tag("bottom", at(1, -height))
    master.tag("right", at(0, width))
    master.tag("symmetry_x" if symmetry == "half" else "left", at(0, 0.0 if symmetry == "half" else -width))
    if symmetry == "half":
        slave.tag("symmetry_x", at(0, 0.0))
    if not whole:
        slave.tag("top", at(1, radius + gap))

    def on_circle(x):
        r = x - (0, radius + gap, 0)
        return (0, radius + gap, 0) + r * (radius / np.linalg.norm(r, axis=1))[:, None]

    layout.snap["slave_surface"] = layout.snap["load"] = on_circle
    return layout


def graded_half_space(body, width, height, h, core, quarters, coarse=None, up=False):
    """Blocks of |x|, |y| <= width, 0 >= z >= -height (`up`: 0 <= z <= height), fine zone at the origin."""
    near = min(width, height)
    require(core < near, f"core = {core!r}: not smaller than the block, {near!r}")
    far = max(h, near / 4 if coarse is None else coarse)
    sz = 1 if up else -1
    for sx, sy in quarters:

        def p(x, y, z, size):
            return body.point((sx * x, sy * y, sz * z), size)

        def box(f, size):
            """The eight corners of the cube of side f, as f(i, j, k)."""
            return {(i, j, k): p(i * f, j * f, k * f, size) for i in (0, 1) for j in (0, 1) for k in (0, 1)}

        inner, outer = box(core, h), box(near, far)
        cube_in_cube(body, inner, outer)
        for x0, x1 in ((0, near), (near, width)):
            for y0, y1 in ((0, near), (near, width)):
                for z0, z1 in ((0, near), (near, height)):
                    if max(x1, y1, z1) > near * (1 + 1e-9) and min(x1 - x0, y1 - y0, z1 - z0) > 1e-9 * near:
                        body.block(
                            *(p(x, y, z0, far) for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))),
                            *(p(x, y, z1, far) for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))),
                        )


def cube_in_cube(body, inner, outer):
    """Core cube at the corner (0, 0, 0) and the three blocks between its far faces and those of the outer cube."""
    ring = ((0, 0), (1, 0), (1, 1), (0, 1))
    body.block(*(inner[(i, j, k)] for k in (0, 1) for i, j in ring))
    body.block(*(inner[(i, j, 1)] for i, j in ring), *(outer[(i, j, 1)] for i, j in ring))
    body.block(*(inner[(1, j, k)] for j, k in ring), *(outer[(1, j, k)] for j, k in ring))
    body.block(*(inner[(i, 1, k)] for i, k in ring), *(outer[(i, 1, k)] for i, k in ring))


def graded_ball(body, radius, gap, h, core, quarters, whole, coarse=None):
    """Blocks of a ball whose lowest point is (0, 0, gap): the lower half, or the `whole`."""
    layout = body.layout
    far = max(h, radius / 4 if coarse is None else coarse)
    require(core <= 0.36 * radius, f"core = {core!r}: larger than 0.36 of the radius, {radius!r}")
    centre = np.array((0, 0, radius + gap))
    for sx, sy in quarters:

        def p(x, y, z, size):
            return body.point((sx * x, sy * y, z + gap), size)

        def sphere(*corners):
            """A face on the sphere: its edges are great circles."""
            for i, j in zip(corners, corners[1:] + corners[:1]):
                body.arc(i, j, centre)
            layout.spheres[frozenset(corners)] = centre
            return corners

        inner, outer = {}, {}
        for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)):
            flat = np.array((i, j)) / max(1.0, math.hypot(i, j))
            x, y = core * np.array((i, j)) / (1.0 if i + j < 2 else math.sqrt(1.3))
            inner[(i, j, 0)] = p(x, y, radius - math.sqrt(radius**2 - x**2 - y**2), h)
            inner[(i, j, 1)] = p(x, y, core, h)
            outer[(i, j, 1)] = p(*(0.62 * radius * np.array((i, j)) / (1.0 if i + j < 2 else 1.25)), radius, far)
            if (i, j) != (0, 0):
                outer[(i, j, 0)] = p(*(radius * flat), radius, far)
        cube_in_cube(body, inner, outer)
        lower = [
            sphere(*(inner[(i, j, 0)] for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)))),
            sphere(inner[(1, 0, 0)], outer[(1, 0, 0)], outer[(1, 1, 0)], inner[(1, 1, 0)]),
            sphere(inner[(0, 1, 0)], outer[(0, 1, 0)], outer[(1, 1, 0)], inner[(1, 1, 0)]),
        ]
        for face in lower:
            body.facet("slave_surface", *face)
        if whole:
            ring = ((0, 0), (1, 0), (1, 1), (0, 1))
            core_top, shell = {}, {}
            for i, j in ring:
                direction = np.array((i, j, 1)) / math.sqrt(i + j + 1)
                side = (1.0, 0.9, 0.85)[i + j]
                core_top[(i, j)] = p(*(0.58 * radius * side * np.array((i, j))), radius * (1 + 0.55 * side), far)
                shell[(i, j)] = p(*(radius * direction[:2]), radius * (1 + direction[2]), far)
            base, rim = {k: outer[(*k, 1)] for k in ring}, {k: outer[(*k, 0)] for k in ring[1:]}
            body.block(*(base[k] for k in ring), *(core_top[k] for k in ring))
            body.block(*(core_top[k] for k in ring), *(shell[k] for k in ring))
            body.facet("load", *sphere(*(shell[k] for k in ring)))
            for m, n in (((1, 0), (1, 1)), ((1, 1), (0, 1))):
                body.block(base[m], rim[m], rim[n], base[n], core_top[m], shell[m], shell[n], core_top[n])
                sphere(rim[m], rim[n], shell[n], shell[m])


def sphere_on_half_space(
    radius=0.01,
    a=1.0e-3,
    h=None,
    core=None,
    width=0.01,
    height=0.01,
    gap=0.0,
    symmetry="quarter",
    whole=False,
    coarse=None,
):
    """A sphere on a block, 3D.

    radius: of the sphere [m]
    a: expected radius of the contact [m]
    h: cell size in the contact, default a/4 [m]
    core: half-width of the fine zone, default 1.5 a [m]
    width: half-width of the block [m]
    height: of the block [m]
    gap: between the bodies [m]
    symmetry: "quarter" (x, y >= 0), "half" (y >= 0) or "none"
    whole: the whole ball with "load" as its uppermost part, else the lower half with "top" as its flat side
    coarse: largest cell size, default a quarter of the radius and of the block [m]
    """
    positive(radius=radius, width=width, height=height)
    require(symmetry in QUARTERS, f"symmetry = {symmetry!r}: one of {', '.join(QUARTERS)}")
    h, core = fine_zone(a, h, core, 4)
    layout = Layout(3, max(radius, width, height))
    master, slave = layout.body("master_body"), layout.body("slave_body")
    graded_half_space(master, width, height, h, core, QUARTERS[symmetry], coarse)
    graded_ball(slave, radius, gap, h, core, QUARTERS[symmetry], whole, coarse)
    tag_half_space(master, width, height, symmetry)
    tag_symmetry(slave, symmetry)
    if not whole:
        slave.tag("top", at(2, radius + gap))

    def on_sphere(x):
        r = x - (0, 0, radius + gap)
        return (0, 0, radius + gap) + r * (radius / np.linalg.norm(r, axis=1))[:, None]

    layout.snap["slave_surface"] = layout.snap["load"] = on_sphere
    return layout


def tag_symmetry(body, symmetry):
    """Name the planes of symmetry of a 3D body."""
    if symmetry == "quarter":
        body.tag("symmetry_x", at(0, 0.0))
    if symmetry != "none":
        body.tag("symmetry_y", at(1, 0.0))


def tag_half_space(body, width, height, symmetry):
    """Name the faces of a graded half-space."""
    body.tag("master_surface", at(2, 0.0))
    body.tag("bottom", at(2, -height))
    tag_symmetry(body, symmetry)
    body.tag("right", at(0, width))
    body.tag("left", at(0, -width))
    body.tag("back", at(1, width))
    body.tag("front", at(1, -width))


RECIPES = (cylinder_on_half_plane, sphere_on_half_space)
