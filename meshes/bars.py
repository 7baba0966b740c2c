# SPDX-License-Identifier: MIT
"""Two bars in line, for impact."""

from .blocks import brick
from .layout import Layout, at, count, positive, require


def two_bars(
    lengths=(0.2, 0.2), section=(0.01,), striker_cells=(80, 1), target_cells=(80, 1), gap=1.0e-4, target_section=None
):
    """A striker (slave body, left) and a target (master body, right) along x, separate nodes.

    lengths: of striker and target [m]
    section: height, or (depth, height) which makes it 3D [m]
    striker_cells, target_cells: numbers of cells along x and across; different ones across do not match at the
        contact [1]
    gap: between the bars [m]
    target_section: as section, default the same, centred [m]

    The contact faces meet around x = 0.
    """
    require(len(lengths) == 2, f"lengths = {lengths!r}: two are needed")
    positive(**{f"lengths[{i}]": v for i, v in enumerate(lengths)})
    require(len(section) in (1, 2), f"section = {section!r}: a height, or a depth and a height")
    dim = 1 + len(section)
    target_section = section if target_section is None else target_section
    require(len(target_section) == dim - 1, f"target_section = {target_section!r}: not like section = {section!r}")
    positive(**{f"section[{i}]": v for i, v in enumerate((*section, *target_section))})
    require(gap >= 0, f"gap = {gap!r}: not negative")
    for name, cells in (("striker_cells", striker_cells), ("target_cells", target_cells)):
        require(len(cells) == dim, f"{name} = {cells!r}: {dim} numbers are needed in {dim}D")
        count(**{f"{name}[{i}]": v for i, v in enumerate(cells)})
    layout = Layout(dim, max(lengths), structured=True)
    for name, x0, length, across, cells in (
        ("slave_body", -lengths[0] - gap, lengths[0], section, striker_cells),
        ("master_body", 0.0, lengths[1], target_section, target_cells),
    ):
        body = layout.body(name)
        low, high = [x0, *(-s / 2 for s in across)], [x0 + length, *(s / 2 for s in across)]
        brick(body, low, high, cells)
        slave = name == "slave_body"
        body.tag("slave_surface" if slave else "master_surface", at(0, high[0] if slave else low[0]))
        body.tag("slave_left" if slave else "right", at(0, low[0] if slave else high[0]))
        if dim == 3:
            body.tag("slave_front" if slave else "front", at(1, low[1]))
            body.tag("slave_back" if slave else "back", at(1, high[1]))
        if not slave:
            body.tag("bottom", at(dim - 1, low[-1]))
    return layout


RECIPES = (two_bars,)
