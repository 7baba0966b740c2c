# SPDX-License-Identifier: MIT
"""Numbers of cells that a user knows and that do not depend on the ranks."""

import numpy as np


def has_input(topology) -> bool:
    """Whether a mesh was made from an input in which its cells have numbers; a submesh was not."""
    try:
        return len(topology.original_cell_index) > 0 or topology.index_map(topology.dim).size_local == 0
    except RuntimeError:  # this is how DOLFINx 0.9 says that there are none
        return False


def input_cell_numbers(topology) -> np.ndarray:
    """Numbers of this rank's cells, ghosts included, in the input that the mesh was made from, (num_cells).

    A submesh (dolfinx.mesh.create_submesh) has no input: its cells have their global numbers.
    """
    if has_input(topology):
        return np.asarray(topology.original_cell_index)
    cells = topology.index_map(topology.dim)
    return cells.local_to_global(np.arange(cells.size_local + cells.num_ghosts, dtype=np.int32))
