# SPDX-License-Identifier: MIT
"""Facets between two cells, as kernels take them."""

import numpy as np
import ufl
from dolfinx import cpp, la

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
    per_cell = cpp.mesh.cell_num_entities(topology.cell_type, tdim - 1)
    of_cells = to_facets.array.reshape(num_cells, per_cell)
    permutations = topology.get_facet_permutations().reshape(num_cells, per_cell)
    entities = np.zeros((len(facets), 3), dtype=np.int32)
    for side in range(2):
        cells = to_cells.array[first + side]
        local = np.argmax(of_cells[cells] == facets[:, None], axis=1)
        entities[:, side] = cells
        entities[:, 2] |= (local << 4 * side) | (permutations[cells, local].astype(np.int32) << 8 + 4 * side)
    return entities.ravel()


def has_interior_facets(form: ufl.Form) -> bool:
    """Whether a form has integrals over facets between cells.

    Args:
        form: UFL form.
    """
    return any(integral.integral_type() == "interior_facet" for integral in form.integrals())


def check_neighbours(mesh: cpp.mesh.Mesh_float64) -> None:
    """Refuse a mesh on which facets that a rank owns have not two cells there. Collective.

    Args:
        mesh: mesh of any cells.

    Raises:
        ValueError: ranks lack cells beyond their own, or more than two bars or surfaces meet; on all ranks.
    """
    topology = mesh.topology
    tdim = topology.dim
    topology.create_connectivity(tdim - 1, tdim)
    topology.create_connectivity(tdim, tdim - 1)
    facets, num_cells = topology.index_map(tdim - 1), topology.index_map(tdim).size_local
    of_cells = topology.connectivity(tdim, tdim - 1)
    count = la.vector(facets, 1)  # cells at a facet, each counted by its owner: ranks may not see all of them
    np.add.at(count.array, of_cells.array[: of_cells.offsets[num_cells]], 1.0)
    count.scatter_reverse(la.InsertMode.add)
    here = np.diff(topology.connectivity(tdim - 1, tdim).offsets)[: facets.size_local]
    there = count.array[: facets.size_local]
    found = mesh.comm.allgather((int(np.max(there, initial=0)), bool(np.any(here < there))))
    most = max(number for number, _ in found)
    if most > 2:
        raise common(
            ValueError(
                f"integrals over interior facets, ufl.dS, have two sides, but {most} cells meet at one {_kind(tdim)} "
                "of this mesh: write what joins them as a term over dx, or leave such places out of the mesh"
            )
        )
    if any(lacks for _, lacks in found):
        raise common(
            ValueError(
                "integrals over interior facets, ufl.dS, need the cells on both sides of a facet, and ranks of this "
                "mesh have none beyond their own: make it with ghost_mode=dolfinx.mesh.GhostMode.shared_facet"
            )
        )


def _kind(tdim: int) -> str:
    """What a facet is called."""
    return {1: "node", 2: "edge"}.get(tdim, "facet")
