# SPDX-License-Identifier: MIT
"""Nodes of trusses and branched surfaces that DOLFINx makes two of when it distributes a mesh."""

import numpy as np
from dolfinx.mesh import Mesh

from ..common.collective import common


def check_nodes(mesh: Mesh) -> None:
    """Refuse a mesh on which a node of the input is several nodes now, on several ranks. Collective.

    DOLFINx finds the nodes that ranks share from the facets with one cell. A node at which three bars meet, or an edge
    of three surfaces, has a cell on either side on one rank already, and is then not known to be another rank's, too:
    the mesh is torn there, without a word. Bodies have no such facets.

    Args:
        mesh: mesh of any cells.

    Raises:
        ValueError: nodes are torn; on all ranks.
    """
    comm, geometry = mesh.comm, mesh.geometry
    if comm.size == 1 or mesh.topology.dim == geometry.dim:
        return
    owned = geometry.input_global_indices[: geometry.index_map().size_local]
    sent = [owned[owned % comm.size == rank] for rank in range(comm.size)]
    numbers, count = np.unique(np.concatenate(comm.alltoall(sent)), return_counts=True)
    torn = np.unique(np.concatenate(comm.allgather(numbers[count > 1])))
    if not len(torn):
        return
    here = np.flatnonzero(owned == torn[0])
    places = [x for x in comm.allgather(geometry.x[here[0]].tolist() if len(here) else None) if x is not None]
    place = ", ".join(f"{x:.6g}" for x in places[0][: geometry.dim])
    raise common(
        ValueError(
            f"{len(torn)} nodes at which more than two bars or surfaces meet have become several nodes as DOLFINx "
            f"distributed the mesh, the first at ({place}): the structure is torn there. Run on one rank, or make the "
            "mesh with a partitioner that gives all cells at such a node to one rank"
        )
    )
