# SPDX-License-Identifier: MIT
"""Which of the master's facets points stay on while Newton's method iterates."""

import numpy as np

# Iterations in which points may change facets freely after convergence; at a kink they may do so for ever.
FREE_ITERATIONS = 10
# How far beside its facet a point may stay, in reference coordinates, and what that may grow to.
MARGIN, WIDEST = 0.01, 0.32
MEMORY = 3  # iterations in which a point may have left a facet that it comes back to


class FacetKeeper:
    """Keeps points from going to and fro between two facets that meet at a kink.

    Args:
        comm: MPI communicator. points: quadrature points of the slave. search: PairSearch.

    Attributes:
        stay: points that lie a little beside their facet stay on it.
    """

    def __init__(self, comm, points, search):
        self.comm, self.points, self.search = comm, points, search
        self.begin()

    def begin(self):
        """An increment starts."""
        self.stay, self._free, self._facets = True, FREE_ITERATIONS, []
        self.points.margin = np.full(self.points.size, MARGIN)

    def watch(self, closed):
        """Once an iteration: points that come back to a facet they have left stay on it from then on, even a little
        farther beside it; so do all, after some iterations without staying. Collective.

        Args:
            closed: mask of the points.

        Returns:
            number of this rank's closed points that are on another facet than before.
        """
        if not self.search.kept:  # facets have other numbers
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

    def leave(self):
        """May points leave their facets, once an increment? From then on they do not stay."""
        if not self.stay or self._free < FREE_ITERATIONS:
            return False
        self.stay = False
        return True
