# SPDX-License-Identifier: MIT
"""Constants, functions and load values that a user may change between steps."""

from collections.abc import Sequence

import numpy as np
from mpi4py import MPI

from .. import _cpp
from ..assembly.operators import SplitForce
from ..loads import DeadLoad
from .stable_step import Frequencies


class Inputs:
    """Values that enter the forces of an explicit problem and that a callback may change.

    The C++ integrator works on copies of constants, coefficients and load vectors. This class finds out what has
    changed since they were copied, and copies them again.

    Args:
        comm: communicator of the problem.
        integrator: C++ CentralDifference that holds the copies.
        terms: force terms of the integrator.
        loads: dead loads, in the order of the integrator.
        frequencies: frequencies of the cells, from which the stable step is computed.
        changes: changes of what the stable step depends on, beside the motion.
    """

    def __init__(
        self,
        comm: MPI.Intracomm,
        integrator: _cpp.integrators.CentralDifference,
        terms: Sequence[SplitForce],
        loads: Sequence[DeadLoad],
        frequencies: Frequencies,
        changes: _cpp.problems.InputChanges,
    ) -> None:
        self.comm, self.integrator = comm, integrator
        self.terms, self.loads, self.frequencies = terms, loads, frequencies
        self.changes = changes

    def update_changed(self) -> None:
        """Copy the values that have changed; the forces at the present time are then those of the new values.
        Collective."""
        here = [any(term.changed() for term in self.terms), self.frequencies.changed()]
        here += [load.changed() for load in self.loads]
        changed = np.array(here, dtype=np.int32)
        self.comm.Allreduce(MPI.IN_PLACE, changed, MPI.MAX)
        if changed[0]:
            for term in self.terms:
                term.update()
            self.integrator.revise()
        if changed[1]:
            self.changes.add(self.comm.allreduce(self.frequencies.change(), MPI.MAX))
            self.frequencies.store_inputs()
        for i, load in enumerate(self.loads):
            if changed[2 + i]:
                self.integrator.set_load(i, load.values())

    def update_all(self) -> None:
        """Copy all values, changed or not. Collective."""
        for term in self.terms:
            term.update()
        for i, load in enumerate(self.loads):
            self.integrator.set_load(i, load.values())
        self.frequencies.store_inputs()
