# SPDX-License-Identifier: MIT
"""Nodal values travel between owners and ghosts, whatever the number of values per node. See on_ranks.py."""

import time

import numpy as np
import pytest
from dolfinx import fem, mesh
from dolfinx.common import IndexMap
from mpi4py import MPI

from dolfinx_impact import _cpp, compat

COMM = MPI.COMM_WORLD


def maps():
    """Nodes of a mesh; of a ring of ranks with ghosts out of order; without ghosts."""
    V = fem.functionspace(mesh.create_unit_cube(COMM, 3, 4, 5), ("Lagrange", 2))
    yield V.dofmap.index_map
    count, size = 4 + COMM.rank, COMM.size
    starts = np.cumsum([0] + [4 + r for r in range(size)])
    others = [r for r in range(size) if r != COMM.rank]
    ghosts = [starts[r] + k for k in (3, 0) for r in reversed(others)]
    owners = [r for k in (3, 0) for r in reversed(others)]
    yield compat.create_index_map(COMM, count, ghosts, owners)
    yield IndexMap(COMM, count)


def check_forward_and_reverse():
    """Ghosts get their owners' values; owners add up what ghosts have, which stays there."""
    for index_map in maps():
        halo = _cpp.operators.Halo(index_map)
        owned, total = index_map.size_local, index_map.size_local + index_map.num_ghosts
        assert (halo.num_owned, halo.num_nodes) == (owned, total)
        numbers = np.append(np.arange(*index_map.local_range), index_map.ghosts).astype(float)
        for bs in (3, 1, 4, 2, 3):
            full = (numbers[:, None] * 10 + np.arange(bs)).reshape(-1)
            values = full.copy()
            values[owned * bs :] = np.nan
            halo.forward(values, bs)
            assert np.array_equal(values, full)
            copies = np.ones(total)
            halo.reverse(copies, 1)  # how many ranks have it
            halo.reverse(values, bs)
            assert np.allclose(values[: owned * bs], full[: owned * bs] * np.repeat(copies[:owned], bs), rtol=1e-15)
            assert np.array_equal(values[owned * bs :], full[owned * bs :])


def check_long_messages():
    """Messages that MPI leaves in the sender's memory: no exchange overwrites what the one before has sent."""
    count, following = 3000, (COMM.rank + 1) % COMM.size
    ghosts = following * count + np.arange(count if COMM.size > 1 else 0)
    halo = _cpp.operators.Halo(compat.create_index_map(COMM, count, ghosts, np.full(len(ghosts), following)))
    numbers = np.append(COMM.rank * count + np.arange(count), ghosts).astype(float)
    for k in range(6):
        if k % COMM.size == COMM.rank:
            time.sleep(0.01)  # the others are ahead
        bs = (3, 3, 1)[k % 3]
        full = np.repeat(numbers + 1e6 * k, bs)
        values = full.copy()
        values[count * bs :] = np.nan
        halo.forward(values, bs)
        assert np.array_equal(values, full)
        halo.reverse(values, bs)
        assert np.array_equal(values[: count * bs], full[: count * bs] * (2 if COMM.size > 1 else 1))


def check_some_ghosts():
    """Ghosts that are not used keep what they have and send nothing; neighbours without any get no message."""
    for index_map in maps():
        owned, num_ghosts = index_map.size_local, index_map.num_ghosts
        first = min(index_map.owners, default=-1)
        used = (np.asarray(index_map.owners) == first) & (np.arange(num_ghosts) % 2 == 0)
        halo = _cpp.operators.Halo(index_map, used.astype(np.int8))
        numbers = np.append(np.arange(*index_map.local_range), index_map.ghosts).astype(float)
        values = np.where(np.arange(owned + num_ghosts) < owned, numbers, -1.0)
        halo.forward(values, 1)
        assert np.array_equal(values[owned:], np.where(used, numbers[owned:], -1.0))
        copies = np.ones(owned + num_ghosts)
        halo.reverse(copies, 1)
        everywhere = COMM.allgather(np.asarray(index_map.ghosts)[used])
        counted = np.sum([np.isin(numbers[:owned], one) for one in everywhere], axis=0)
        assert np.array_equal(copies[:owned], 1.0 + counted)
        messages, sent = halo.traffic
        assert COMM.allreduce(sent) == 2 * COMM.allreduce(int(used.sum()))
        assert COMM.allreduce(messages) == 2 * COMM.allreduce(int(used.any()))
    with pytest.raises(ValueError, match="used"):
        _cpp.operators.Halo(index_map, np.ones(num_ghosts + 1, dtype=np.int8))


def check_refused():
    """Arrays of wrong sizes, too many values per node."""
    index_map = next(maps())
    halo = _cpp.operators.Halo(index_map)
    for size, bs in ((halo.num_nodes * 3 + 1, 3), (halo.num_nodes * 13, 13), (0, 0)):
        for exchange in (halo.forward, halo.reverse):
            with pytest.raises(ValueError, match="values"):
                exchange(np.zeros(size), bs)
