# SPDX-License-Identifier: MIT
"""A coarse slave under a fine, round master, degree 2, by penalty: points go to and fro over the master's kinks."""

import numpy as np
import pytest
from contact_model import Model

import dolfinx_impact as di
from dolfinx_impact import compat

RADIUS, DEPTH = 4.0, 0.05


def bodies(coarse_is_slave):
    """A parabola of 42 cells over a block of 9; the problem, and the constant that presses it down."""
    m = Model(
        "two_blocks",
        {
            "master_body": di.LinearElastic(200.0, 0.3, hypothesis="plane_strain"),
            "slave_body": di.LinearElastic(100.0, 0.3, hypothesis="plane_strain"),
        },
        degree=2,
        lower=(3.0, 1.0),
        upper=(2.0, 1.0),
        lower_cells=(9, 2),
        upper_cells=(42, 14),
        offset=(0.5,),
    )
    x = m.mesh.geometry.x
    upper = np.zeros(len(x), dtype=bool)
    upper[compat.geometry_dofmap(m.mesh)[m.cells.find(m.tags["slave_body"])]] = True
    height, across = x[upper, 1] - 1.0, x[upper, 0] - 1.5
    x[upper, 1] += (1.0 - height) * across**2 / (2 * RADIUS)
    m.hold("bottom")
    m.hold("top", 0)
    down = m.hold("top", 1)
    names = ("master_surface", "slave_surface") if coarse_is_slave else ("slave_surface", "master_surface")
    problem = m.problem(di.Penalty(m.pair(*names)))
    return problem, down


@pytest.mark.timeout(200)
def test_points_that_go_to_and_fro_over_a_kink_come_to_rest():
    """Pressed in small increments: in the tenth two points of a symmetric pair come back to facets that they have left,
    by 0.011 of a facet, with every iteration."""
    problem, down = bodies(True)
    for part in (*range(1, 10), 9.25):
        down.value = -DEPTH * part / 16
        report = problem.solve()
        assert report.cut_backs == 0 and max(report.iterations) <= 25, (part, report.table())
    force = problem.contact[0].force
    assert abs(force[0]) < 1e-9 * abs(force[1])
    problem, down = bodies(False)
    down.value = -DEPTH * 9.25 / 16
    problem.solve(steps=2)
    # Between its points, seven of its facets apart, the master is dented: it looks softer.
    assert 0.93 < -force[1] / problem.contact[0].force[1] < 1.0


def test_a_coarse_slave_is_named():
    problem, _ = bodies(True)
    assert "the slave's facets are 6.9 times as long as the master's" in problem.contact[0].mesh_advice()
    assert bodies(False)[0].contact[0].mesh_advice() == ""
