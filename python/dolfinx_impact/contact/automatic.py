"""A penalty from material and mesh."""

import numpy as np
from mpi4py import MPI

from .. import _cpp
from .matrices import NodalSum


def automatic_penalty(contact, factor):
    """Stiffness per area of the softer surface's nodes where its facets are smallest, times a factor [F/L^3]; printed
    on rank 0. Collective.

    Args:
        contact: PenaltyContact. factor: [1].
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
    if contact.comm.rank == 0:
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
