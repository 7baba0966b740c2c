# SPDX-License-Identifier: MIT
"""Sums and updates of nodal values over the ranks, in closed form. See on_ranks.py."""

import numpy as np
from dolfinx import fem, mesh
from mpi4py import MPI

from dolfinx_impact.contact.nodal_sum import NodalSum

COMM = MPI.COMM_WORLD


def nodal_sum(block):
    """Of the nodes of a square's triangles, with their global numbers."""
    domain = mesh.create_unit_square(COMM, 5, 4)
    index_map = fem.functionspace(domain, ("Lagrange", 1)).dofmap.index_map
    total = NodalSum(index_map, block)
    assert total.num_nodes == index_map.size_local + index_map.num_ghosts
    return total, index_map.local_to_global(np.arange(total.num_nodes, dtype=np.int32))


def copies(total, numbers):
    """On how many ranks each node of this rank is, from the numbers of all ranks."""
    everywhere = np.bincount(np.concatenate(COMM.allgather(numbers)), minlength=total.index_map.size_global)
    return everywhere[numbers]


def check_contributions_of_all_ranks_add_up():
    """One from each rank that has a node is the number of these ranks, on all of them."""
    for block in (1, 2, 3):
        total, numbers = nodal_sum(block)
        factors = np.arange(1.0, block + 1)
        found = total(np.outer(np.ones(len(numbers)), factors))
        np.testing.assert_array_equal(found, np.outer(copies(total, numbers), factors))


def check_what_only_ghosts_contribute_reaches_the_owners():
    """The owner adds nothing: one less than the number of ranks."""
    total, numbers = nodal_sum(1)
    given = np.zeros(total.num_nodes)
    given[total.index_map.size_local :] = 1.0
    np.testing.assert_array_equal(total(given)[:, 0], copies(total, numbers) - 1)


def check_ghosts_get_the_values_of_their_owners():
    """Whatever stood there."""
    total, numbers = nodal_sum(2)
    values = np.stack([numbers, -2.0 * numbers], axis=1).astype(float)
    wrong = values.copy()
    wrong[total.index_map.size_local :] = np.nan
    np.testing.assert_array_equal(total.forward(wrong), values)


def check_results_are_copies():
    """What a call has returned stays as it is at the next one."""
    total, numbers = nodal_sum(1)
    first = total(np.ones(total.num_nodes))
    kept = first.copy()
    total(np.zeros(total.num_nodes))
    np.testing.assert_array_equal(first, kept)
