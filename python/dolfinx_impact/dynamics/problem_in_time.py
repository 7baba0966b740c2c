# SPDX-License-Identifier: MIT
"""What recorders read of a problem in time, explicit or implicit."""

from __future__ import annotations

from typing import Protocol

from dolfinx.fem import Function
from mpi4py import MPI

from ..recording.field_arguments import RecordedProblem


class ProblemInTime(RecordedProblem, Protocol):
    """Problem whose state changes with time.

    Attributes:
        comm: communicator.
        u: displacement at the present time [L].
        velocity: velocity at the present time [L/T].
        acceleration: acceleration at the present time [L/T^2].
        space: displacement space.
    """

    comm: MPI.Intracomm
    velocity: Function
    acceleration: Function

    @property
    def time(self) -> float: ...

    @property
    def step(self) -> int: ...
