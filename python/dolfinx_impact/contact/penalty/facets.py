# SPDX-License-Identifier: MIT
"""Assignment of quadrature points to the master's facets during the iterations of Newton's method."""

import numpy as np
from mpi4py import MPI

from ... import _cpp
from ...common.types import BoolArray, IntArray

# Iterations in which points may change facets freely after convergence; at a kink the changes may never end.
FREE_ITERATIONS = 10
# Distance from its facet, in reference coordinates, up to which a point is assigned to it, and its largest value.
MARGIN, WIDEST = 0.01, 0.32
MEMORY = 3  # number of earlier iterations whose facets are compared with the present one


class FacetKeeper:
    """Prevents points from alternating between two facets of the master that meet at a kink.

    Args:
        comm: communicator of the mesh.
        points: quadrature points of the slave.
        search: search of the pair.

    Attributes:
        stay: whether points remain assigned to a facet whose boundary they have crossed by less than their margin.
    """

    stay: bool

    def __init__(self, comm: MPI.Comm, points: _cpp.penalty.Points, search: _cpp.search.PairSearch) -> None:
        self.comm, self.points, self.search = comm, points, search
        self.begin()

    def begin(self, margin: float = MARGIN) -> None:
        """Begin an increment.

        Args:
            margin: distance from its facet up to which a point is assigned to it, in reference coordinates [1].
        """
        self.stay, self._free = True, FREE_ITERATIONS
        self._facets: list[IntArray] = []
        self.points.margin = np.full(self.points.size, margin)

    def watch(self, closed: BoolArray) -> int:
        """Compare the facets of an iteration with those of earlier ones. Collective.

        The margin of points that return to an earlier facet is doubled while `stay` is true. Otherwise `stay` becomes
        true when a point returns, or after FREE_ITERATIONS iterations.

        Args:
            closed: mask of the closed points, (n).

        Returns:
            Number of this rank's closed points that have changed their facet.
        """
        if not self.search.kept:  # a new search numbers the facets anew
            self._facets = []
        here = np.where(closed, self.points.master, -1)
        back, moved = np.zeros(len(here), dtype=bool), np.zeros(len(here), dtype=bool)
        if self._facets:
            moved = (here != self._facets[-1]) & (here >= 0) & (self._facets[-1] >= 0)
            for before in self._facets[:-1]:
                back |= moved & (here == before)
        self._facets = [*self._facets[-MEMORY:], here]
        returned = self.comm.allreduce(int(np.count_nonzero(back)))
        if self.stay:
            margin = self.points.margin
            self.points.margin = np.where(back, np.minimum(2.0 * margin, WIDEST), margin)
        else:
            self._free -= 1
            self.stay = self._free == 0 or returned > 0
        return int(np.count_nonzero(moved))

    def leave(self) -> bool:
        """Release the points from their facets after convergence, once in an increment.

        Returns:
            Whether they have been released now.
        """
        if not self.stay or self._free < FREE_ITERATIONS:
            return False
        self.stay = False
        return True
