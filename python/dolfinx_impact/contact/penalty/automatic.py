# SPDX-License-Identifier: MIT
"""A penalty from material and mesh."""

import numpy as np
from mpi4py import MPI

from ... import _cpp
from ..nodal_sum import NodalSum


# A given penalty beyond this many times the automatic one leaves no digits of the bodies' stiffness in the matrix: of
# sixteen ten, and four to judge a residual by.
LARGEST = 1e10


def check_penalty(contact, factor):
    """Refuse a given penalty that is out of all proportion to the bodies. Collective.

    Raises:
        ValueError: on all ranks.
    """
    automatic = automatic_penalty(contact, factor, tell=False)
    if contact.penalty > LARGEST * automatic:
        ratio = contact.penalty / automatic
        raise ValueError(
            f"{contact.pair.name}: penalty is {contact.penalty:g}, {ratio:.1g} times what material "
            f"and mesh ask for ({automatic:.3e}): nothing is left of the bodies' stiffness in the sum; use "
            "penalty='auto' or some thousand times that, or multipliers (Lagrange)"
        )


def automatic_penalty(contact, factor, tell=True):
    """Stiffness per area of the softer surface's nodes where its facets are smallest, times a factor [F/L^3].
    Collective.

    Args:
        contact: PenaltyContact. factor: [1]. tell: print it on rank 0.
    """
    index_map, gdim = contact.V.dofmap.index_map, contact.gdim
    total = NodalSum(index_map, 1)
    diagonal = contact.problem._tangent.assemble().getDiagonal()
    stiffness = np.zeros(index_map.size_local + index_map.num_ghosts)
    stiffness[: index_map.size_local] = np.abs(diagonal.array.reshape(-1, gdim)).mean(axis=1)
    diagonal.destroy()
    stiffness = total.forward(stiffness).ravel()
    surfaces = [(contact.slave, contact._points)]
    if not contact.pair.rigid:
        points = _cpp.penalty.Points(contact.master, *contact._rule, contact.problem.axisymmetric)
        surfaces.append((contact.master, points))
    penalty = factor * min(_per_area(total, stiffness, *s, contact.comm) for s in surfaces)
    if tell and contact.comm.rank == 0:
        print(f"{contact.pair.name}: penalty {penalty:.3e} from material and mesh", flush=True)
    return penalty


def _per_area(total, stiffness, surface, points, comm):
    """Largest stiffness per area of a facet: that of its nodes, times the surface's nodes per facet [F/L^3].
    Collective."""
    marker = np.zeros(len(stiffness))
    marker[surface.nodes.ravel()] = 1.0
    num_nodes = np.count_nonzero(total(marker).ravel()[: total.index_map.size_local])
    area = np.asarray(points.weight).reshape(-1, points.per_facet).sum(axis=1)
    num_nodes, num_facets = (comm.allreduce(n) for n in (num_nodes, len(area)))
    largest = np.max(stiffness[surface.nodes].mean(axis=1) / area, initial=0.0)
    return comm.allreduce(float(largest), MPI.MAX) * num_nodes / num_facets
