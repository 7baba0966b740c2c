# SPDX-License-Identifier: MIT
"""Automatic penalty from material and mesh."""

from typing import TYPE_CHECKING

import numpy as np
from mpi4py import MPI

from ... import _cpp
from ...common.types import FloatArray
from ..nodal_sum import NodalSum

if TYPE_CHECKING:  # it imports this module
    from .penalty import PenaltyContact

# Largest ratio of a given penalty to the automatic one. Of the sixteen digits of an entry of the matrix, a larger one
# leaves fewer than six for the bodies' stiffness, of which a residual needs four.
LARGEST = 1e10


def check_penalty(contact: "PenaltyContact", penalty: float, factor: float) -> None:
    """Refuse a given penalty that is much larger than the stiffness of the bodies. Collective.

    Args:
        contact: the contact.
        penalty: its given penalty [F/L^3].
        factor: factor of the automatic penalty [1].

    Raises:
        ValueError: the penalty is more than LARGEST times the automatic one; on all ranks.
    """
    automatic = automatic_penalty(contact, factor, verbose=False)
    if penalty > LARGEST * automatic:
        ratio = penalty / automatic
        raise ValueError(
            f"{contact.pair.name}: penalty is {penalty:g}, {ratio:.1g} times what material "
            f"and mesh ask for ({automatic:.3e}): nothing is left of the bodies' stiffness in the sum; use "
            "penalty='auto' or some thousand times that, or multipliers (Lagrange)"
        )


def automatic_penalty(contact: "PenaltyContact", factor: float, verbose: bool = True) -> float:
    """Penalty from the nodal stiffness per area of the softer surface where its facets are smallest. Collective.

    Args:
        contact: the contact.
        factor: factor of the stiffness per area [1].
        verbose: whether rank 0 prints the penalty.

    Returns:
        The penalty [F/L^3].
    """
    index_map, gdim = contact.V.dofmap.index_map, contact.gdim
    total = NodalSum(index_map, 1)
    diagonal = contact.problem.tangent.assemble().getDiagonal()
    stiffness = np.zeros(index_map.size_local + index_map.num_ghosts)
    stiffness[: index_map.size_local] = np.abs(diagonal.array.reshape(-1, gdim)).mean(axis=1)
    diagonal.destroy()
    stiffness = total.forward(stiffness).ravel()
    surfaces = [(contact.slave, contact._points)]
    if not contact.pair.rigid:
        points = _cpp.penalty.Points(contact.master, *contact._rule, contact.problem.axisymmetric)
        surfaces.append((contact.master, points))
    penalty = factor * min(_per_area(total, stiffness, *s, contact.comm) for s in surfaces)
    if verbose and contact.comm.rank == 0:
        print(f"{contact.pair.name}: penalty {penalty:.3e} from material and mesh", flush=True)
    return penalty


def _per_area(
    total: NodalSum,
    stiffness: FloatArray,
    surface: _cpp.surface.Facets,
    points: _cpp.penalty.Points,
    comm: MPI.Comm,
) -> float:
    """Largest mean stiffness of a facet's nodes per area of the facet, times the surface's nodes per facet [F/L^3].
    Collective."""
    marker = np.zeros(len(stiffness))
    marker[surface.nodes.ravel()] = 1.0
    num_nodes = np.count_nonzero(total(marker).ravel()[: total.index_map.size_local])
    area = np.asarray(points.weight).reshape(-1, points.per_facet).sum(axis=1)
    num_nodes, num_facets = (comm.allreduce(n) for n in (num_nodes, len(area)))
    largest = np.max(stiffness[surface.nodes].mean(axis=1) / area, initial=0.0)
    return comm.allreduce(float(largest), MPI.MAX) * num_nodes / num_facets
