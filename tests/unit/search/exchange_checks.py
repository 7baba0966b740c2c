# SPDX-License-Identifier: MIT
"""What Exchange brings to a rank, against the whole surface gathered on it. See
on_ranks.py."""

import numpy as np
import partitioned_bodies
from dolfinx import fem
from mpi4py import MPI

from dolfinx_impact import _cpp

COMM = MPI.COMM_WORLD
ROUND_OFF = 1e-13  # interpolated and scattered positions of order one
CASES = [(2, None, 1, 1), (2, "triangle", 2, 2), (2, None, 2, 1), (3, None, 1, 1), (3, "tetrahedron", 1, 2)]


def displaced(V):
    """A linear displacement: degree 1 has it exactly."""
    u = fem.Function(V)
    u.interpolate(lambda x: (0.1 * x + 0.2 * np.roll(x, 1, axis=0))[: V.mesh.geometry.dim])
    return u


def gathered(facets):
    """Facets of all ranks, sorted by id: id, X, orientation."""
    parts = COMM.allgather((facets.id, facets.X, facets.orientation))
    arrays = [np.concatenate(a) for a in zip(*parts)]
    order = np.argsort(arrays[0])
    return [a[order] for a in arrays]


def boxes_touch(a, b, dim):
    return np.all(a[..., :dim] <= b[..., dim:], axis=-1) & np.all(b[..., :dim] <= a[..., dim:], axis=-1)


def check_candidates():
    """Exactly the facets whose boxes touch the widened box of this rank's slave facets; nodes where they should be."""
    for dim, cell, geometry_degree, degree in CASES:
        for seed, reach in ((None, 0.1), (1, 0.05), (2, 0.0)):
            V, slave, master = partitioned_bodies.two_bodies(COMM, dim, cell, geometry_degree, degree, seed)
            exchange = _cpp.search.Exchange(V._cpp_object, slave, master, reach)
            ids, X, orientation = gathered(master)
            boxes = np.concatenate(COMM.allgather(_cpp.search.bounding_boxes(master)))
            boxes = boxes[np.argsort(np.concatenate(COMM.allgather(master.id)))]
            if slave.size:
                mine = _cpp.search.bounding_boxes(slave)
                box = np.concatenate([mine[:, :dim].min(axis=0) - reach, mine[:, dim:].max(axis=0) + reach])
                expected = boxes_touch(boxes, box[None], dim)
            else:
                expected = np.zeros(len(ids), dtype=bool)
            assert np.array_equal(exchange.master.id, ids[expected])
            assert np.array_equal(exchange.master.X, X[expected])
            assert np.array_equal(exchange.master.orientation, orientation[expected])
            assert np.array_equal(exchange.slave.id, slave.id)
            compare_nodes(V, exchange)


def compare_nodes(V, exchange):
    """The nodal map continues V's; forward brings values, move positions, reverse adds."""
    dim = V.mesh.geometry.dim
    imap = V.dofmap.index_map
    assert exchange.map.size_local == imap.size_local and exchange.map.local_range == imap.local_range
    u = displaced(V)
    spoilt = u.x.array.copy()
    spoilt[imap.size_local * dim :] = 1e9  # ghosts are not read
    values = exchange.forward(spoilt)
    assert values.size == exchange.size == dim * (imap.size_local + exchange.map.num_ghosts)
    exchange.move(spoilt)
    for facets in (exchange.slave, exchange.master):
        n = facets.displacement.num_nodes  # on curved facets u is not linear in between if its degree is 1
        X = facets.X[:, :n]
        padded = np.pad(X, ((0, 0), (0, 0), (0, 3 - dim)))
        expected = (0.1 * padded + 0.2 * np.roll(padded, 1, axis=2))[:, :, :dim]
        assert np.allclose(values.reshape(-1, dim)[facets.nodes], expected, atol=ROUND_OFF)
        assert np.allclose(facets.x[:, :n] - X, expected, atol=ROUND_OFF)
    compare_reverse(V, exchange, dim)


def compare_reverse(V, exchange, dim):
    ones = np.zeros(exchange.size)
    for facets in (exchange.slave, exchange.master):
        np.add.at(ones.reshape(-1, dim), facets.nodes.reshape(-1), np.arange(1, dim + 1))
    b = np.full(V.dofmap.index_map.size_local * dim, 0.5)
    exchange.reverse(ones, b)
    b -= 0.5
    total = COMM.allreduce(b.sum())
    count = COMM.allreduce(float(exchange.slave.nodes.size + exchange.master.nodes.size))
    assert abs(total - count * dim * (dim + 1) / 2) < 1e-9 and np.all(b > -1e-9)


def check_nothing():
    """No facets at all; no slave; no master."""
    V, slave, master = partitioned_bodies.two_bodies(COMM, 2, seed=3)
    none = _cpp.surface.make_surface(V._cpp_object, np.zeros(0, dtype=np.int32))
    for s, m in ((none, none), (none, master), (slave, none)):
        exchange = _cpp.search.Exchange(V._cpp_object, s, m, 0.1)
        exchange.move(displaced(V).x.array)
        assert exchange.master.size == 0 and exchange.slave.size == s.size
