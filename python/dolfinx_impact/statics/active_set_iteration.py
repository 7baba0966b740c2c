# SPDX-License-Identifier: MIT
"""Updates of an active set that may cycle, and the message of an increment that does not converge."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from mpi4py import MPI

from .. import _cpp
from ..common.types import AnyArray
from ..contact.mortar.shared_nodes import over_constrained
from ..contact.protocol import MultiplierContact

if TYPE_CHECKING:
    from .newton import Newton

NOBODY = -2  # a number that no node has
VIOLATION = 1e-11  # largest violation of the contact conditions in a converged state, in sizes of the bodies
# Relative difference of the pressures of states that are the same, above the round-off of a linear solution.
REPEATED = 1e-6
PATIENCE = 3  # updates of all nodes in succession that may fail to reduce the number of wrong nodes


class ActiveSetIteration:
    """Updates active sets without cycling.

    All wrong nodes change at once while that reduces their number. If it fails to do so several times in succession,
    one node changes at a time, the wrong one with the largest number, until there are fewer wrong nodes than ever
    before. This ends after finitely many changes for P-matrices. Judice and Pires (1994), Murty (1974).

    Attributes:
        count: number of updates so far [1].
        best: smallest number of wrong nodes so far [1].
        patience: updates of all nodes that may still fail before single nodes change [1].
    """

    def __init__(self) -> None:
        self.count, self.patience = 0, PATIENCE
        self.best: float = np.inf

    def change(self, contacts: Sequence[MultiplierContact]) -> int:
        """Update the active sets of contacts. Collective.

        Args:
            contacts: contacts with multipliers.

        Returns:
            Number of nodes that were wrong, of all ranks [1].
        """
        single = self.patience == 0
        found = sum([c.update_active_set(False, NOBODY if single else None) for c in contacts])
        self.count += 1
        if found < self.best:
            self.best, self.patience = found, PATIENCE
        elif not single:
            self.patience -= 1
        if single and found:
            contact = next((c for c in contacts if c.last_change >= 0), contacts[0])
            contact.update_active_set(False, None if self.patience else contact.last_change)
        return found


class RepeatedStates:
    """Recognises active sets of a linearised problem that come again, although single nodes change.

    Such a problem has no active set that fits: with friction there need not be one, as normal and friction forces of a
    node depend on each other. Its updates would go round for ever.

    Args:
        comm: communicator of the problem.
        later: number of updates after the first repetition at which to stop, so that linearised problems that follow
            each other begin from different states of a cycle [1].
    """

    def __init__(self, comm: MPI.Comm, later: int = 0) -> None:
        self._comm, self._later = comm, later
        self._states: list[list[AnyArray]] = []
        self._end: int | None = None

    def stops(self, contacts: Sequence[MultiplierContact]) -> bool:
        """Add the present state, and decide whether further updates are useless. Collective.

        Args:
            contacts: contacts with multipliers, after an update of a single node.

        Returns:
            Whether the updates are to end here.
        """
        state: list[AnyArray] = []
        for c in contacts:
            state += [c.active.copy(), c.sliding.copy(), c.multiplier.copy()]
        same = [all(_equal(a, b) for a, b in zip(state, before)) for before in self._states]
        again = [k for k, equal in enumerate(zip(*self._comm.allgather(same))) if all(equal)]
        self._states.append(state)
        if again and self._end is None:
            period = len(self._states) - 1 - again[-1]
            self._end = len(self._states) + self._later % period
        return self._end is not None and len(self._states) >= self._end

    def forget(self) -> None:
        """Forget all states: all nodes have changed at once."""
        self._states, self._end = [], None


def _equal(one: AnyArray, other: AnyArray) -> bool:
    """Whether masks are equal, and numbers to REPEATED of the largest."""
    if one.dtype == bool:
        return bool(np.array_equal(one, other))
    return bool(np.abs(one - other).max(initial=0.0) <= REPEATED * np.abs(other).max(initial=0.0))


def did_not_converge(
    result: _cpp.solve.Increment, newton: Newton, moved: bool, small: bool, pending: int, violation: float
) -> _cpp.solve.Increment:
    """Write into an increment why it did not converge, and what to do. Collective.

    Args:
        result: iterations of the increment.
        newton: Newton's method that ran it.
        moved: whether prescribed values are reached.
        small: whether the residual is within its tolerance.
        pending: number of points whose contact status changes [1].
        violation: largest violation of the contact conditions, in sizes of the bodies [1].

    Returns:
        `result`.
    """
    contacts, norms = newton.problem.contact, result.residual_norms
    period = result.cycle()
    found = []
    if not small:
        found.append(f"the residual is {norms[-1]:.3e}")
    if pending:
        found.append(f"{pending} contact points change their state")
    if violation >= VIOLATION:
        found += [text for text in [c.largest_violation() for c in contacts] if text]
    crowded = over_constrained(newton.multipliers) if newton.multipliers else ""
    if crowded:
        found.append(crowded)
    if not moved:
        found.append("prescribed values are not reached")
    if result.stalled():
        found.append("the linearised problems have no active set that fits, and the residual does not fall")
    if period:
        found.append(f"the same states come again after {period} iterations")
    text = (
        f"Newton's method did not converge in {result.iterations} iterations: {', '.join(found)}; residual norms: "
        f"{', '.join(f'{n:.3e}' for n in norms)}"
    )
    if small and moved and not pending:
        # Equilibrium and active set have converged, but a condition is violated: smaller increments do not help.
        return result.failed(text, hopeless=True)
    meshes = [text for text in [c.mesh_advice() for c in contacts] if text]
    advice = f"{'; '.join(meshes)}. {result.advice}" if meshes else None
    return result.failed(text, advice=advice)
