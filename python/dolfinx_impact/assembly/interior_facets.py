# SPDX-License-Identifier: MIT
"""Facets between two cells, as kernels take them."""

import numpy as np
from dolfinx import cpp
from mpi4py import MPI

from ..common.collective import common
from ..common.types import IntArray


def interior_facets(mesh: cpp.mesh.Mesh_float64, chosen: IntArray | None = None) -> IntArray:
    """Facets between two cells that this rank owns. Collective.

    Args:
        mesh: mesh of any cells.
        chosen: numbers of facets on this rank, of which those between two cells are taken; None: all.

    Returns:
        Triples one after the other: the cell "+", the cell "-", and the numbers and permutations of the facet in both
        (kernels/Kernel.h), (3 num_facets). "+" is the cell that DOLFINx takes for it.

    Raises:
        ValueError: a rank lacks a cell beside a facet that it owns; on all ranks.
    """
    topology = mesh.topology
    tdim = topology.dim
    topology.create_connectivity(tdim - 1, tdim)
    topology.create_connectivity(tdim, tdim - 1)
    topology.create_entity_permutations()
    check_neighbours(mesh)
    num_owned = topology.index_map(tdim - 1).size_local
    to_cells, to_facets = topology.connectivity(tdim - 1, tdim), topology.connectivity(tdim, tdim - 1)
    facets = np.arange(num_owned, dtype=np.int32) if chosen is None else chosen[chosen < num_owned]
    first = to_cells.offsets[facets]
    inner = to_cells.offsets[facets + 1] - first == 2
    facets, first = facets[inner], first[inner]
    num_cells = topology.index_map(tdim).size_local + topology.index_map(tdim).num_ghosts
    of_cells = to_facets.array.reshape(num_cells, -1)
    permutations = topology.get_facet_permutations().reshape(num_cells, -1)
    entities = np.zeros((len(facets), 3), dtype=np.int32)
    for side in range(2):
        cells = to_cells.array[first + side]
        local = np.argmax(of_cells[cells] == facets[:, None], axis=1)
        entities[:, side] = cells
        entities[:, 2] |= (local << 4 * side) | (permutations[cells, local].astype(np.int32) << 8 + 4 * side)
    return entities.ravel()


def check_neighbours(mesh: cpp.mesh.Mesh_float64) -> None:
    """Refuse a mesh on which a rank does not have both cells of a facet that it owns. Collective.

    Args:
        mesh: mesh of any cells.

    Raises:
        ValueError: ranks lack cells beyond their own; on all ranks.
    """
    topology = mesh.topology
    tdim = topology.dim
    topology.create_connectivity(tdim - 1, tdim)
    to_cells = topology.connectivity(tdim - 1, tdim)
    num_owned = topology.index_map(tdim - 1).size_local
    single = np.diff(to_cells.offsets[: num_owned + 1]) == 1
    outer = cpp.mesh.exterior_facet_indices(topology)
    single[outer[outer < num_owned]] = False
    if mesh.comm.allreduce(bool(np.any(single)), MPI.LOR):
        raise common(
            ValueError(
                "integrals over interior facets, ufl.dS, need the cells on both sides of a facet, and ranks of this "
                "mesh have none beyond their own: make it with ghost_mode=dolfinx.mesh.GhostMode.shared_facet"
            )
        )
