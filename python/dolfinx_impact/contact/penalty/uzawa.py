# SPDX-License-Identifier: MIT
"""Multipliers of penalty contact from the penetrations reached: Uzawa's method, seed (3.48) with (3.47)."""

import numpy as np
from mpi4py import MPI

from ... import _cpp
from ..nodal_sum import NodalSum


class Uzawa:
    """Multipliers at the corners of a slave's facets, with piecewise linear functions: one at every quadrature point
    would be more conditions than the nodes can fulfil. Simo and Laursen (1992).

    Args:
        V: displacement space. slave: this rank's facets. rule: points (n, dimension of the facet) and weights.

    Attributes:
        multiplier: at the nodes, owned and ghosts, zero but at corners [F/L^2].
        rounds: augmentations of the increment so far.
        penetration: largest mean penetration around a corner, or what a multiplier must give way by, of the last round
        and of the one before [L].
    """

    def __init__(self, V, slave, rule):
        self.comm, self.slave = V.mesh.comm, slave
        functions = _cpp.surface.FacetElement(slave.displacement.shape, 1)
        # From the rule: a rank without slave facets has no points, but takes part in the sums.
        places = np.pad(rule[0], ((0, 0), (0, 2 - rule[0].shape[1])))
        self._table = np.array([functions.tabulate(*xi)[0] for xi in places])
        self._corners = slave.nodes[:, : self._table.shape[1]]
        self._sum = NodalSum(V.dofmap.index_map, 1)
        self.multiplier = np.zeros(V.dofmap.index_map.size_local + V.dofmap.index_map.num_ghosts)
        self.begin()

    def begin(self):
        """An increment starts."""
        self.rounds, self.penetration = 0, (np.inf, np.inf)

    def augment(self, gap, weight, penalty, tolerance):
        """Another round, where the surfaces still penetrate. Collective.

        Args:
            gap, weight: of the quadrature points, facet after facet; a gap may be infinite [L], [L^2]. penalty:
            [F/L^3]. tolerance: penetration that may stay [L].

        Returns:
            multipliers at the points [F/L^2], or None: it may stay as it is.
        """
        gap = gap.reshape(-1, len(self._table))
        weight = np.where(np.isfinite(gap), weight.reshape(gap.shape), 0.0)
        sums = []
        for values in (weight * np.where(np.isfinite(gap), gap, 0.0), weight):
            total = np.zeros(len(self.multiplier))
            np.add.at(total, self._corners, values @ self._table)
            sums.append(self._sum(total).ravel())
        mean = np.where(sums[1] > 0.0, sums[0] / np.where(sums[1] > 0.0, sums[1], 1.0), np.inf)
        new = np.maximum(0.0, self.multiplier - penalty * mean)
        change = float(np.max(np.abs(new - self.multiplier), initial=0.0)) / penalty
        self.penetration = self.penetration[1], self.comm.allreduce(change, MPI.MAX)
        if self.penetration[1] <= tolerance:
            return None
        self.multiplier, self.rounds = new, self.rounds + 1
        return (new[self._corners] @ self._table.T).ravel()

    def fault(self, penalty, tolerance):
        """Why the rounds before the last one were too few, and what to do."""
        before, now = self.penetration
        text = f"after {self.rounds - 1} augmentations the penetration is {now:.3e}, more than {tolerance:.3e}"
        rate = now / before if np.isfinite(before) and before > 0.0 else 0.0
        if 0.0 < rate < 1.0:
            more = int(np.ceil(np.log(tolerance / now) / np.log(rate)))
            text += f"; each takes {1.0 - rate:.1%} of it away, some {more} more are needed"
        return (
            f"{text}. The penalty is {penalty:.3e}: take a larger one (penalty='auto' is from material and mesh), "
            "a larger tolerance, or more max_augmentations"
        )
