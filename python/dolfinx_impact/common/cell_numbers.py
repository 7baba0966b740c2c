# SPDX-License-Identifier: MIT
"""Cell numbers that a user knows and that do not depend on the distribution over ranks."""

import numpy as np
from dolfinx.mesh import Topology

from .types import IntArray


def has_input(topology: Topology) -> bool:
    """Whether the cells of a mesh have numbers in an input; those of a submesh have none.

    Args:
        topology: topology of the mesh.

    Returns:
        True if DOLFINx knows the original numbers, or if this rank owns no cells.
    """
    try:
        return len(topology.original_cell_index) > 0 or topology.index_map(topology.dim).size_local == 0
    except RuntimeError:  # DOLFINx raises when there are no original numbers
        return False


def input_cell_numbers(topology: Topology) -> IntArray:
    """Numbers of this rank's cells in the input from which the mesh was made.

    A submesh (dolfinx.mesh.create_submesh) has no input: its cells have their global numbers.

    Args:
        topology: topology of the mesh.

    Returns:
        Numbers of the owned and ghost cells, (num_cells).
    """
    if has_input(topology):
        return np.asarray(topology.original_cell_index)
    cells = topology.index_map(topology.dim)
    return cells.local_to_global(np.arange(cells.size_local + cells.num_ghosts, dtype=np.int32))
