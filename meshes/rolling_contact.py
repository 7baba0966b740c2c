# SPDX-License-Identifier: MIT
"""Surroundings of the contact of a wheel on a rail: a sector of the wheel and a length of the rail, both as far as the
stress of the contact reaches. All cells are rows along the flow of the material, as for steady rolling.

Both bodies are laid out flat, in coordinates in which the half-axes of the contact are 1, and are then bent.
"""

import math

import numpy as np

from .hertz import SIDES
from .layout import Layout, at, count, positive, require

CORE, LEAST_CORE = 1.25, 1.2  # half-width of the fine zone with a path; without, of whole cells; in half-axes
# Cells between the outermost node in contact and the edge of the contact, along the flow and across it. Friction finds
# the edge at a fixed distance beyond that node, wherever it is (docs/rolling.md): nodes lie so that this is the edge.
# In the plane the distance is 0.40 cells; in space 0.3 meets Kalker's coefficients best.
BEYOND = (0.3, 0.5)
# Least width of a row, of that in the middle, so that cells are not sheared too much where the ellipse ends; rows with
# fewer nodes on either side may have the edge anywhere, they bear little.
NARROWEST, FEWEST = 0.55, 2
CORE_DEPTH = 0.75
FAR = 3.0  # cells at the far ends are this part of the bodies' length


class Spacing:
    """Fine cells along the flow and across it, and the half-widths of their zone, all in half-axes.

    Without a path nodes lie as the edge of the contact asks for it, an ellipse with the half-axes one. With a path the
    contact rolls over the nodes, and all cells are alike.

    cells: in each half-axis.
    path: that an explicit run rolls.
    """

    def __init__(self, cells, path):
        self.straight = path > 0.0
        along, across = (0.0, 0.0) if self.straight else BEYOND
        self.cells, self.along, self.across = cells, 1.0 / (cells + along), 1.0 / (cells + across)
        count = CORE * cells if self.straight else math.ceil(LEAST_CORE * (cells + max(along, across)) - 1e-9)
        self.core = count * self.along, count * self.across

    def rows(self):
        """Places of the rows across the flow, and their widths, of that in the middle."""
        places = self.across * np.arange(1 + round(self.core[1] / self.across))
        widths = np.full(len(places), NARROWEST)
        for k, y in enumerate(places[: self.cells + 1]):
            half = math.sqrt(1.0 - y**2)  # of the ellipse, along
            widths[k] = max(half, NARROWEST)
            inside = round(half / (widths[k] * self.along) - BEYOND[0])  # nodes up to the edge
            if inside >= FEWEST:
                widths[k] = half / ((inside + BEYOND[0]) * self.along)
        return places, widths

    def columns(self, reach):
        """Map of the nodes after which columns of nodes are as far inside the edge in each row, as rows go on along the
        flow. It fades out towards the ends of a body.

        reach: half-length, half-width and depth of the body, scaled.
        """

        places, widths = self.rows()

        def fade(x, first, last):
            return np.clip((last - np.abs(x)) / (last - first), 0.0, 1.0)

        def bend(x):
            along, across, up = x.T
            width = np.interp(np.abs(across), places, widths)
            part = fade(along, self.core[0], reach[0]) * fade(across, self.core[1], reach[1]) * fade(up, 0.0, reach[2])
            return np.stack([along * (1.0 - part * (1.0 - width)), across, up], axis=1)

        return bend


def flat(name, up, reach, spacing, sides, path):
    """One body, flat, in scaled coordinates (along, across, up), its surface at zero.

    name: of the body.
    up: 1 for a body above its surface, -1 for one below.
    reach: half-length, half-width and depth, scaled.
    spacing: of the fine cells.
    sides: those of the plane of symmetry that are there.
    path: by which the fine zone is longer in front, scaled.
    """
    length, width, depth = reach
    h, (along, across) = spacing.across, spacing.core
    plan = Layout(2, max(reach))
    body = plan.body(name)
    surface, held = ("slave_surface", "hub") if up > 0 else ("master_surface", "bottom")
    for s in sides:
        places = {"a": (0, 0), "b": (across, 0), "c": (across, CORE_DEPTH), "d": (0, CORE_DEPTH)}
        far = {"e": (width, 0), "f": (width, depth), "g": (0, depth)}
        p = {k: body.point((s * y, up * z), h) for k, (y, z) in places.items()}
        p |= {k: body.point((s * y, up * z), max(h, max(reach) / FAR)) for k, (y, z) in far.items()}
        for corners in ("abcd", "befc", "dcfg"):
            body.block(*(p[k] for k in corners))
        body.facet(surface, p["a"], p["b"])
        if up < 0:  # a slave node may be opposite to any facet of the master
            body.facet(surface, p["b"], p["e"])
        body.facet(held, p["f"], p["g"])
    body.tag("symmetry_y", at(0, 0.0))
    fine, front = spacing.along, along + path
    coarse = max(fine, length / FAR)
    levels = [-length, -along, front, length + path]
    out = plan.extruded(lambda x, t: (t, x[0], x[1]), levels, [coarse, fine, fine, coarse], (held, held))
    if up > 0:  # the surface that may touch ends with the fine zone
        for corners, found in out.named.items():
            places = [out.points[k][0] for k in corners]
            if found == surface and (min(places) < -1.001 * along or max(places) > 1.001 * front):
                out.named[corners] = "free"
    if not spacing.straight:
        out.bodies[0].map(spacing.columns(reach))
    return out


def rolling_contact_3d(
    radius=0.46, crown_radius=0.30, wheel_crown_radius=math.inf, a=7.16e-3, b=5.39e-3, cells=8, reach=6.0, gap=0.0,
    symmetry="half", path=0.0,
):  # fmt: skip
    """Sector of a wheel and length of a rail around their contact, for steady rolling: rows of cells follow the flow.
    The wheel's "hub" is its inner surface and the sector's ends, "bottom" the rail's underside and ends.

    radius: of the wheel [m]
    crown_radius: transverse radius of the rail head, inf is flat [m]
    wheel_crown_radius: transverse radius of the tread, default flat; negative is hollow [m]
    a: expected half-axis of the contact along the rail [m]
    b: expected half-axis across [m]
    cells: in each half-axis, and a part of one up to the edge of the contact
    reach: half-length, half-width and depth of the bodies, in larger half-axes
    gap: between wheel and rail [m]
    symmetry: "half" (y >= 0) or "none"
    path: what an explicit run rolls, towards x > 0, in half-axes a: the fine zone is so much longer
    """
    positive(radius=radius, a=a, b=b, reach=reach)
    count(cells=cells)
    require(math.isfinite(path) and path >= 0.0, f"path = {path!r}: not a length")
    require(symmetry in SIDES, f"symmetry = {symmetry!r}: one of {', '.join(SIDES)}")
    size = reach * max(a, b)
    for name, value in (("crown_radius", crown_radius), ("wheel_crown_radius", wheel_crown_radius)):
        require(abs(value) > size, f"{name} = {value!r}: smaller than the half-width of the bodies, {size:.3g}")
    require(size + path * a < radius, f"path = {path!r}: the wheel's sector would be longer than its radius")
    require(size < 0.5 * radius, f"reach = {reach!r}: the bodies would be {size:.3g} deep, half the radius or more")
    require(reach >= 2 * CORE, f"reach = {reach!r}: smaller than {2 * CORE}")
    unit = np.array((a, b, math.sqrt(a * b)))

    def drop(y, curvature_radius):
        """By how much a circle through the origin falls behind its tangent."""
        if math.isinf(curvature_radius):
            return np.zeros_like(y)
        return curvature_radius - math.copysign(1.0, curvature_radius) * np.sqrt(curvature_radius**2 - y**2)

    def bend_wheel(x):
        s, y, depth = (x * unit).T
        r = radius - depth - drop(y, wheel_crown_radius) * (1.0 - depth / size)
        angle = s / radius
        return np.stack([r * np.sin(angle), y, radius + gap - r * np.cos(angle)], axis=1)

    def bend_rail(x):
        s, y, height = (x * unit).T
        return np.stack([s, y, height - drop(y, crown_radius) * (1.0 + height / size)], axis=1)

    sides, spacing = SIDES[symmetry], Spacing(cells, path)
    layout = flat("master_body", -1, size / unit, spacing, sides, path)
    layout.bodies[0].map(bend_rail)
    wheel = flat("slave_body", 1, size / unit, spacing, sides, path)
    wheel.bodies[0].map(bend_wheel)
    layout.merge(wheel)
    return layout


RECIPES = (rolling_contact_3d,)
