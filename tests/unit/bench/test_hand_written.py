# SPDX-License-Identifier: MIT
"""The step that is written by hand makes the package's motion, and a difference is no row of the benchmark."""

import numpy as np
import pytest
from dolfinx_impact import _cpp
from impact_studies.bench import explicit
from impact_studies.bench.setup import Setup

WIDTHS = _cpp.bench.HandWrittenStep.widths()
pytestmark = pytest.mark.skipif(not WIDTHS, reason="the loops are for AVX2 and AVX-512")


@pytest.mark.parametrize(
    "cell, degree, integration", [*((*case, "full") for case in explicit.HAND_WRITTEN), ("hexahedron", 1, "reduced")]
)
def test_same_motion_as_the_package(cell, degree, integration):
    """27 hexahedra and 162 tetrahedra leave lanes of the last batch over. Nodes are moved: on cubes the parts of one
    point that only distorted cells have are zero."""
    setup = Setup(cell, degree, 3)
    x = setup.V.mesh.geometry.x
    x[:] += 0.03 * np.sin(7.0 * x[:, [1, 2, 0]])
    row = explicit.hand_written_row(setup, cell, steps=4, rounds=1, integration=integration)
    assert row["ratio"] > 0.0 and row["baseline"] > 0.0


def test_another_motion_is_no_row(monkeypatch):
    """Half of the velocity makes other displacements."""
    start = _cpp.bench.HandWrittenStep.start

    class Slower:
        def __init__(self, *args, **options):
            self.loop = _cpp.bench.HandWrittenStep(*args, **options)

        widths = staticmethod(_cpp.bench.HandWrittenStep.widths)

        def start(self, u, v):
            start(self.loop, u, 0.5 * v)

        def __getattr__(self, name):
            return getattr(self.loop, name)

    class Bench:
        HandWrittenStep = Slower

    class Module:
        bench = Bench

    monkeypatch.setattr(explicit, "_cpp", Module)
    with pytest.raises(RuntimeError, match="differ by"):
        explicit.hand_written_row(Setup("hexahedron", 1, 2), "hexahedron", steps=2, rounds=1)


@pytest.mark.parametrize(
    "cells, nodes, width, message",
    [
        ([0, 1, 2, 3], 4, 3, "there is no step written by hand for cells with 4 nodes, 3 at a time"),
        ([0, 1, 2, 3], 4, -4, "for cells with 4 nodes and one point, 4 at a time"),
        ([0, 1, 2, 3, 4], 5, WIDTHS[0] if WIDTHS else 4, "there is no step written by hand for cells with 5 nodes"),
        ([0, 1, 2, 4], 4, WIDTHS[0] if WIDTHS else 4, "a cell has a node that does not exist"),
        ([0, 1, 2], 4, WIDTHS[0] if WIDTHS else 4, "do not fit together"),
    ],
)
def test_errors(cells, nodes, width, message):
    with pytest.raises(ValueError, match=message):
        _cpp.bench.HandWrittenStep(
            np.zeros(12), np.array(cells, dtype=np.int32), nodes, 1.0, 1.0, np.ones(4), abs(width), one_point=width < 0
        )
