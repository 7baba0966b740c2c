# SPDX-License-Identifier: MIT
"""The passage over a rail joint on several ranks and on one. See on_ranks.py."""

import numpy as np
from mpi4py import MPI

from impact_studies.rail_joint import JointModel, Passage, RailJoint

COMM = MPI.COMM_WORLD
JOINT = RailJoint().changed(
    cells=1, coarse=0.1, begin=-12e-3, end=12e-3, rail_length=0.5, bar_length=0.3, sleepers=0.3, yield_stress=600e6
)


def check_the_passage_is_that_of_one_rank():
    """Forces of all steps, and the plastic strain: the static stages stop at 3e-5 of the load, on other ranks
    elsewhere."""
    found = []
    for comm in (COMM, MPI.COMM_SELF):
        run = Passage(JointModel(JOINT, comm), False)
        run.start(run.preload())
        history = run.roll()
        found.append((history.force, run.plastic_strain()))
    (here, flowed), (alone, flowed_alone) = found
    assert here.shape == alone.shape and np.abs(alone).max() > 0.5 * JOINT.load
    assert np.abs(here - alone).max() < 1e-4 * JOINT.load
    assert flowed_alone > 0.0 and abs(flowed / flowed_alone - 1.0) < 1e-3
