# SPDX-License-Identifier: MIT
"""The two surfaces of a pair as they move, and the master facets near a rank's slave facets."""

import numpy as np
from mpi4py import MPI

from .. import _cpp


def distances(values, nodes, gdim):
    """Largest length of nodal vectors on the nodes of a surface."""
    nodes = np.unique(nodes.ravel())
    return float(np.max(np.linalg.norm(values.reshape(-1, gdim)[nodes], axis=1), initial=0.0))


class Neighbours:
    """Search for a pair of deformable surfaces.

    Args:
        pair: ContactPair.
        V: displacement space. slave, master: this rank's facets.

    Attributes:
        reach: within which slave and master are paired when nothing moves [L].
        slave, master: facets after `update`, their nodes numbered by `map`. kept: the last update kept the candidates
        and their numbers.
    """

    def __init__(self, pair, V, slave, master):
        self.V, self.comm, self.gdim = V, V.mesh.comm, V.mesh.geometry.dim
        self.surfaces = slave, master
        self._built, self._reach = None, 0.0
        sizes = np.concatenate([np.ptp(s.X, axis=1) for s in (slave, master)])
        largest = float(np.max(np.linalg.norm(sizes, axis=-1), initial=0.0))
        self.reach = pair.search_distance or 2.0 * self.comm.allreduce(largest, MPI.MAX)

    def update(self, u, start):
        """Move both surfaces to u and search anew; returns the reach. Collective.

        Surfaces may have passed through each other by as much as they moved since `start`: no contact is missed.
        """
        u = np.ascontiguousarray(u)
        nodes = [surface.nodes for surface in self.surfaces]
        moved = max(distances(u - start, n, self.gdim) for n in nodes)
        since = np.inf if self._built is None else max(distances(u - self._built, n, self.gdim) for n in nodes)
        moved, since = (self.comm.allreduce(float(v), MPI.MAX) for v in (moved, since))
        reach = max(self.reach, 2.0 * moved)
        # Candidates were taken from half as far again: they hold while nothing moves by a quarter of the reach.
        self.kept = reach <= self._reach and since < 0.25 * self.reach
        if self.kept:
            self.exchange.move(u)
        else:
            for surface in self.surfaces:
                surface.move(u)
            self.exchange = _cpp.search.Exchange(self.V._cpp_object, *self.surfaces, 1.5 * reach)
            self._built, self._reach = u.copy(), reach
        self.map, self.slave, self.master = self.exchange.map, self.exchange.slave, self.exchange.master
        return reach
