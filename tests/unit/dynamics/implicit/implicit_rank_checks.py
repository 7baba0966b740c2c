# SPDX-License-Identifier: MIT
"""Implicit runs on several ranks against the same runs on one. See on_ranks.py."""

import numpy as np
from implicit_checks import COMM, DT, SOME, block_on_block
from mpi4py import MPI
from on_ranks import on_rank_0


def check_runs_are_those_of_one_rank():
    """Energies and contact forces of all steps, to 1e-10 of the largest: Newton's method stops earlier."""
    for variant in SOME:

        def histories(comm, variant=variant):
            problem = block_on_block(comm, **variant)
            # The tolerance of Newton's method is relative to forces in a step, which are larger than those that act.
            # With steps of DT bodies that yield take Newton's method to its largest number of iterations, and
            # round-off, which MUMPS does not repeat on several ranks, decides whether a step is halved.
            problem.advance(5 * DT, 0.5 * DT, progress=False, rtol=1e-12)
            assert COMM.size == 1 or problem.step == 10  # of SOME no step is halved
            return problem.energy_history, problem.force_history[0]

        for here, alone in zip(histories(COMM), on_rank_0(COMM, lambda: histories(MPI.COMM_SELF))):
            assert np.abs(alone).max() > 0.0
            assert np.abs(here - alone).max() <= 1e-10 * np.abs(alone).max(), variant
