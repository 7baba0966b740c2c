# SPDX-License-Identifier: MIT
"""Augmentation of penalty contact by multipliers: Uzawa's method, seed (3.48) with (3.47)."""

from collections.abc import Sequence

import numpy as np
from dolfinx.fem import FunctionSpace
from mpi4py import MPI

from ...common.described import Described
from ... import _cpp
from ...common.types import BoolArray, FloatArray
from ..nodal_sum import NodalSum

# Part of a corner's area, weighted with its function, below which a master covers little of it.
COVERED = 0.2


class Uzawa(Described):
    """Multipliers at the corners of the slave's facets, interpolated linearly. Simo and Laursen (1992).

    Multipliers at every quadrature point would be more conditions than the displacements of the nodes can satisfy.

    Args:
        V: displacement space.
        slave: this rank's facets of the slave.
        rule: quadrature rule of a facet: points, (num_points, dimension of the facet), and weights, (num_points) [1].

    Attributes:
        multiplier: multipliers at owned and ghost nodes, zero at nodes that are not corners [F/L^2].
        rounds: number of augmentations of the present increment.
        penetration: of the round before the last one and of the last one, the largest change of a multiplier divided by
            the penalty: mean penetration around a corner, or its opening where the multiplier decreases [L].
    """

    rounds: int
    penetration: tuple[float, float]

    def __init__(self, V: FunctionSpace, slave: _cpp.surface.Facets, rule: Sequence[FloatArray]) -> None:
        self.comm, self.slave = V.mesh.comm, slave
        functions = _cpp.surface.FacetElement(slave.displacement.shape, 1)
        # The table is made from the rule: a rank without slave facets has no points, but takes part in the sums.
        places = np.pad(rule[0], ((0, 0), (0, 2 - rule[0].shape[1])))
        self._table = np.array([functions.tabulate(*xi)[0] for xi in places])
        self._corners = slave.nodes[:, : self._table.shape[1]]
        self._sum = NodalSum(V.dofmap.index_map, 1)
        self.multiplier: FloatArray = np.zeros(V.dofmap.index_map.size_local + V.dofmap.index_map.num_ghosts)
        self.begin()

    def begin(self) -> None:
        """Begin an increment."""
        self.rounds, self.penetration = 0, (np.inf, np.inf)

    def augment(self, gap: FloatArray, weight: FloatArray, penalty: float, tolerance: float) -> FloatArray | None:
        """Update the multipliers if surfaces still penetrate. Collective.

        Args:
            gap: gaps of the quadrature points, facet by facet, (n), infinite without master [L].
            weight: areas of the quadrature points, (n) [L^2].
            penalty: penalty of the contact [F/L^3].
            tolerance: largest permitted penetration [L].

        Returns:
            Multipliers at the quadrature points, (n); None if the penetration is below the tolerance [F/L^2].
        """
        gap = gap.reshape(-1, len(self._table))
        whole = weight.reshape(gap.shape)
        weight = np.where(np.isfinite(gap), whole, 0.0)
        sums = []
        for values in (weight * np.where(np.isfinite(gap), gap, 0.0), weight, whole):
            total = np.zeros(len(self.multiplier))
            np.add.at(total, self._corners, values @ self._table)
            sums.append(self._sum(total).ravel())
        mean = np.where(sums[1] > 0.0, sums[0] / np.where(sums[1] > 0.0, sums[1], 1.0), np.inf)
        new = self._extrapolated(np.maximum(0.0, self.multiplier - penalty * mean), sums[1] < COVERED * sums[2])
        change = float(np.max(np.abs(new - self.multiplier), initial=0.0)) / penalty
        self.penetration = self.penetration[1], self.comm.allreduce(change, MPI.MAX)
        if self.penetration[1] <= tolerance:
            return None
        self.multiplier, self.rounds = new, self.rounds + 1
        return (new[self._corners] @ self._table.T).ravel()

    def _extrapolated(self, values: FloatArray, little: BoolArray) -> FloatArray:
        """Multipliers where the master covers little around a corner: the mean of the other corners of its facets.
        Collective.

        The few points there hardly tell its multiplier from that of the next corner, and Uzawa's method would take
        hundreds of rounds to do so.

        Args:
            values: multipliers at owned and ghost nodes [F/L^2].
            little: mask of the corners, owned and ghosts.

        Returns:
            Multipliers at owned and ghost nodes [F/L^2].
        """
        if not self.comm.allreduce(int(np.any(little))):
            return values
        others = np.where(little, 0.0, 1.0)[self._corners]
        sums = []
        for v in (others * values[self._corners], others):
            total = np.zeros(len(values))
            np.add.at(total, self._corners, np.repeat(v.sum(axis=1)[:, None], self._corners.shape[1], 1))
            sums.append(self._sum(total).ravel())
        return np.where(little & (sums[1] > 0.0), sums[0] / np.where(sums[1] > 0.0, sums[1], 1.0), values)

    def fault(self, penalty: float, tolerance: float) -> str:
        """Describe why the permitted number of augmentations was too small, and what to do.

        Args:
            penalty: penalty of the contact [F/L^3].
            tolerance: largest permitted penetration [L].

        Returns:
            A text for an error.
        """
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
