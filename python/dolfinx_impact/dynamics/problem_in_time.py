# SPDX-License-Identifier: MIT
"""What recorders read of a problem in time, explicit or implicit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from dolfinx.fem import Function, FunctionSpace
from mpi4py import MPI

from ..assembly.history import MaterialHistory
from ..contact.pair import ContactPair


class RecordedContact(Protocol):
    """What a recorder reads of a contact."""

    @property
    def pair(self) -> ContactPair:
        """Pair of surfaces."""


class ProblemInTime(Protocol):
    """Problem whose state changes with time.

    Attributes:
        comm: communicator.
        u: displacement at the present time [L].
        velocity: velocity at the present time [L/T].
        acceleration: acceleration at the present time [L/T^2].
        space: displacement space.
    """

    comm: MPI.Intracomm
    u: Function
    velocity: Function
    acceleration: Function
    space: FunctionSpace

    @property
    def contact(self) -> Sequence[RecordedContact]:
        """Contacts."""

    @property
    def time(self) -> float:
        """Present time [T]."""

    @property
    def step(self) -> int:
        """Number of the present step [1]."""

    @property
    def has_history(self) -> bool:
        """Whether a material has internal variables."""

    @property
    def history(self) -> MaterialHistory:
        """Internal variables of the materials."""
