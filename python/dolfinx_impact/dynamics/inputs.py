# SPDX-License-Identifier: MIT
"""What a user may change between steps: constants and functions of forms, values of loads."""

import numpy as np
from mpi4py import MPI


class Inputs:
    """Values that enter the forces of an explicit problem and that a callback may change.

    The C++ integrator works on copies of constants, coefficients and load vectors. This class finds out what has
    changed since they were copied, and copies them again.

    Args:
        comm: communicator of the problem.
        integrator: C++ CentralDifference that holds the copies.
        terms: force terms (SplitForce) of the integrator.
        loads: dead loads (DeadLoad), in the order of the integrator.
        frequencies: Frequencies of the cells, from which the stable step is found.
    """

    def __init__(self, comm, integrator, terms, loads, frequencies) -> None:
        self.comm, self.integrator = comm, integrator
        self.terms, self.loads, self.frequencies = terms, loads, frequencies

    def take_changes(self) -> bool:
        """Copy what has changed: forces of the present time level are those of the new values. Collective.

        Returns:
            Whether the stable step has to be found anew, the same on all ranks.
        """
        changed = [any(term.changed() for term in self.terms), self.frequencies.changed()]
        changed += [load.changed() for load in self.loads]
        changed = np.array(changed, dtype=np.int32)
        self.comm.Allreduce(MPI.IN_PLACE, changed, MPI.MAX)
        if changed[0]:
            for term in self.terms:
                term.update()
            self.integrator.revise()
        if changed[1]:
            self.frequencies.take()
        for i, load in enumerate(self.loads):
            if changed[2 + i]:
                self.integrator.set_load(i, load.values())
        return bool(changed[1])

    def take_all(self) -> None:
        """Copy everything, changed or not. Collective."""
        for term in self.terms:
            term.update()
        for i, load in enumerate(self.loads):
            self.integrator.set_load(i, load.values())
        self.frequencies.take()
