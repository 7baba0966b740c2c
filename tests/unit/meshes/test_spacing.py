# SPDX-License-Identifier: MIT
"""Where the nodes of a rolling contact lie: the edge of its ellipse is at the same distance beyond the outermost."""

import numpy as np
import pytest

from dolfinx_impact.meshes.rolling_contact import BEYOND, FEWEST, NARROWEST, Spacing


@pytest.mark.parametrize("cells", [3, 5, 8, 12])
def test_the_edge_is_where_friction_finds_it(cells):
    spacing = Spacing(cells, 0.0)
    assert (cells + BEYOND[0]) * spacing.along == pytest.approx(1.0) == (cells + BEYOND[1]) * spacing.across
    places, widths = spacing.rows()
    assert places[0] == 0.0 and widths[0] == pytest.approx(1.0, rel=1e-14) and places[-1] >= spacing.core[1] - 1e-12
    assert widths.min() >= 0.5 * NARROWEST and spacing.core[0] >= 1.2
    seen = 0
    for y, width in zip(places, widths):
        if y < 1.0 and (inside := np.sqrt(1 - y**2) / (width * spacing.along) - BEYOND[0]) > FEWEST - 0.5:
            assert inside == pytest.approx(round(inside), abs=1e-9)
            seen += 1
    assert seen >= cells // 2


def test_columns_are_bent_near_the_contact_alone():
    spacing, reach = Spacing(6, 0.0), (10.0, 8.0, 9.0)
    bend = spacing.columns(reach)
    places, widths = spacing.rows()
    for far in ((10.0, 0.5, 0.0), (0.5, 8.0, 0.0), (0.5, 0.5, -9.0)):
        assert bend(np.array([far]))[0] == pytest.approx(far)
    near = bend(np.array([(spacing.along, y, 0.0) for y in places[:4]]))
    assert near[:, 0] == pytest.approx(spacing.along * widths[:4], rel=1e-14)
    assert near[:, 1] == pytest.approx(places[:4])
    along = np.linspace(-10, 10, 201)
    moved = bend(np.column_stack([along, np.full(201, places[3]), np.zeros(201)]))[:, 0]
    assert np.all(np.diff(moved) > 0.0) and moved == pytest.approx(-moved[::-1])


def test_with_a_path_all_cells_are_alike():
    spacing = Spacing(4, 1.0)
    assert spacing.straight and spacing.along == spacing.across == 0.25
    assert spacing.core == pytest.approx((1.25, 1.25))
