# SPDX-License-Identifier: MIT
"""Equilibrium of the free nodes under the forces that contacts report: the last check of a state that has converged."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from mpi4py import MPI

from ..common.types import FloatArray
from ..contact.body_size import body_size

if TYPE_CHECKING:
    from .equilibrium_problem import EquilibriumProblem

# Round-off of a nodal contact force, in units of the largest relative error of a sum: it is the sum of some ten terms
# (facets around a node times shape functions), on the slave's side and on the master's.
SUMS = 32
# Gaps below this part of the bodies' size are none: a contact without force may open by round-off.
OPEN = 1e-10


class Imbalance(NamedTuple):
    """What is missing to equilibrium.

    Attributes:
        norm: norm of the missing forces [F].
        text: a sentence with the pairs and the node where most is missing.
    """

    norm: float
    text: str


def out_of_balance(problem: EquilibriumProblem, bodies: FloatArray, tolerance: float) -> Imbalance | None:
    """Describe what is missing to equilibrium in a state that has converged. Collective.

    Newton's method with multipliers takes their forces from the residual of the slave's nodes, where equilibrium holds
    by construction. Here the forces that all contacts report are summed up, on slaves and masters, and subtracted from
    the residual of the bodies; what is left at nodes that are free must be within the tolerance.

    Args:
        problem: bodies and contacts, evaluated at the state.
        bodies: residual of the bodies without contact, over owned degrees of freedom [F].
        tolerance: tolerance of the norm of the free residual, without round-off of contact forces [F].

    Returns:
        What is missing; None if the state is in equilibrium.
    """
    if not problem.contact:
        return None  # the residual of the bodies is what Newton's method has made small
    comm, gdim, owned = problem.space.mesh.comm, problem.space.mesh.geometry.dim, problem.num_owned
    forces = [c.contact_forces() for c in problem.contact]
    left = np.where(problem.fixed[:owned], 0.0, bodies - np.sum(forces, axis=0))
    sums = comm.allreduce(np.array([float(left @ left), *(float(f @ f) for f in forces)]))
    norm, *sizes = np.sqrt(sums)
    allowed = tolerance + SUMS * np.finfo(float).eps * sum(sizes)
    if norm <= allowed:  # a norm that is not a number is none
        return None
    lengths = np.linalg.norm(left.reshape(-1, gdim), axis=1)
    place = problem.space.tabulate_dof_coordinates()
    mine: list[tuple[float, Any]] = []
    if len(lengths):
        worst = int(np.argmax(np.where(np.isfinite(lengths), lengths, np.inf)))
        mine = [(float(lengths[worst]), place[worst, :gdim].tolist())]
    missing, x = max(sum(comm.allgather(mine), []))
    size = comm.allreduce(max((float(np.abs(v).max(initial=0.0)) for v in (bodies, *forces)), default=0.0), MPI.MAX)
    names = ", ".join(c.pair.name for c in problem.contact)
    text = (
        f"the forces that the contacts report do not balance those of the bodies: {missing:.3e} is missing at the node "
        f"({', '.join(f'{c:.4g}' for c in x)}), where the largest nodal force is {size:.3e}; the norm of what is "
        f"missing is {norm:.3e}, its tolerance {allowed:.3e} (contacts: {names})"
    )
    return Imbalance(norm, text)


def open_contacts(problem: EquilibriumProblem, closed: Sequence[bool]) -> list[str]:
    """Describe contacts that were closed and are open now, by more than round-off. Collective.

    Args:
        problem: bodies and contacts.
        closed: whether each contact was closed before.

    Returns:
        The name of each pair and its smallest gap.
    """
    comm, found = problem.space.mesh.comm, []
    for contact, was in zip(problem.contact, closed):
        if was and contact.num_active == 0:
            gap = comm.allreduce(float(np.min(contact.gap, initial=np.inf)), MPI.MIN)
            if gap > OPEN * body_size(problem.space.mesh):
                found.append(f"{contact.pair.name}: smallest gap {gap:.3e}")
    return found
