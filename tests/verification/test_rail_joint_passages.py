# SPDX-License-Identifier: MIT
"""A wheel that comes again to a rail joint that has yielded."""

import numpy as np
import pytest
from dolfinx import fem
from mpi4py import MPI

from impact_studies.rail_joint import JointModel, Passage, RailJoint

COMM = MPI.COMM_WORLD
JOINT = RailJoint().changed(
    cells=1, coarse=0.1, speed=80.0, begin=-6e-3, end=6e-3, rail_length=0.5, bar_length=0.3, sleepers=0.3,
    yield_stress=300e6, wheel_mass=700.0,
)  # fmt: skip


@pytest.mark.slow
def test_equilibria_of_a_second_passage():
    """They are those that are found without the first one's as a start; the steel keeps what has flowed."""
    passage = Passage(JointModel(JOINT, COMM), progress=False)
    passage.start(passage.preload()).advance(0.2 * JOINT.duration, progress=False)
    flowed = passage.plastic_strain()
    passage.unload()
    unloaded = passage.u.x.array.copy()
    passage.start(passage.preload())
    found, force = passage.u.x.array.copy(), passage.static_force
    passage.u = fem.Function(passage.model.V, name="displacement")
    passage.u.x.array[:] = unloaded
    passage._pressed = passage._sunk = None
    passage.start(passage.preload())
    # Both are solved to 3e-5 of the forces; displacements of a soft contact may differ by thirty times that.
    largest = COMM.allreduce(np.abs(found).max(), MPI.MAX)
    assert COMM.allreduce(np.abs(found - passage.u.x.array).max(), MPI.MAX) < 1e-3 * largest
    assert force == pytest.approx(passage.static_force, rel=1e-4)
    assert passage.plastic_strain() >= flowed > 1e-4
    passage.run.advance(0.2 * JOINT.duration, progress=False)
    again = passage.u.x.array.copy()
    passage.unload()
    assert COMM.allreduce(np.abs(again - unloaded).max(), MPI.MAX) > 0.1 * largest, "the wheel was lifted off"
    moved, rail = np.abs(passage.u.x.array - unloaded).reshape(-1, 3), np.ones(len(unloaded) // 3, dtype=bool)
    rail[np.unique(passage.model.V.dofmap.list[passage.model.wheel.cells])] = False
    assert COMM.allreduce(moved[rail].max(initial=0.0), MPI.MAX) < 0.1 * largest, "a rail that has changed little"
