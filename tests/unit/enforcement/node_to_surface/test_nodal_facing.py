# SPDX-License-Identifier: MIT
"""Facing is judged in the present configuration: nothing depends on when candidates are searched."""

import facing_checks
import numpy as np
import pytest
from mpi4py import MPI
from on_ranks import rank_tests

test_one_rank, test_several_ranks = rank_tests(facing_checks, ranks=(2, 3), timeout=300)


@pytest.mark.parametrize("options", ({"friction": 0.3}, {"kinematic": True, "friction": 0.3}))
@pytest.mark.parametrize("cell", ("quadrilateral", "hexahedron"))
def test_runs_do_not_depend_on_searches(cell, options):
    one, other = (facing_checks.driven(MPI.COMM_SELF, cell, always, **options) for always in (False, True))
    assert np.abs(one - other).max() < 1e-11 * np.abs(one).max()  # round-off of 250 steps with dampers


@pytest.mark.parametrize("cell, degree", (("quadrilateral", 1), ("hexahedron", 1)))
def test_normals_of_the_last_search_are_seen(cell, degree):
    """The comparison fails where facing is judged by old normals."""
    error, changed, _ = facing_checks.searched_or_not(MPI.COMM_SELF, cell, degree, {}, keep=True)
    assert error > 1e-3 and changed > 0


def test_normals_are_seldom_evaluated():
    """Bodies that slide and tremble by a hundredth of a cell in a step: a bound tells that they have not turned."""
    model = facing_checks.two_bodies("hexahedron", seed=1, gap=0.0, lower_cells=(5,) * 3, upper_cells=(4,) * 3)
    before = None
    for step in range(200):
        u = facing_checks.smooth(model.x, 0.002, 0.5 * step)
        u[model.slave_body, 0] += 0.1 * np.sin(0.02 * step)
        u[model.slave_body, -1] -= 0.004
        du = np.zeros_like(u) if before is None else u - before
        model.forces(u, du, search=before is None or model.again())
        before = u
    counters = model.contact.counters()
    assert counters["nodes"] > 100 * len(model.contact.nodes)
    assert counters["normals"] < 0.05 * counters["nodes"]
