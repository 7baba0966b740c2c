# SPDX-License-Identifier: MIT
"""Slave nodes that several pairs have in common and whose normals agree: one constraint for all; docs/contact.md."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from mpi4py import MPI

from ... import _cpp
from ...common.types import BoolArray, FloatArray, IntArray
from .geometry import RigidGeometry, SurfaceGeometry

# Covered part of a facet below which it counts as not covered, where other pairs may cover the rest: what is left out
# is missing in the balance of pressures. By degree of the displacement; the mass matrix of a part h of a facet has a
# condition of h^-2 and h^-4.
LEAST_COVER = {1: 1e-6, 2: 1e-3}
# Nodes whose functions are covered by so much more than their whole integral lie under two masters, one behind the
# other. Less is an overlap of masters side by side that do not feel each other.
LAYERED = 1.5


class JoinedNodes:
    """Adds up the mortar integrals of pairs at the slave nodes that they share.

    Pairs number the nodes that they join alike: nodes of one number are one node of the mesh with one normal. Its
    weight, weighted gap, weighted jump and row of M are the sums over the pairs, so that it has one constraint and one
    multiplier; each pair's force is its own part of it.

    Args:
        geometries: of the pairs.
        numbers: of the nodes of each pair, (n) each; alike where they are joined.
        count: of the numbers.

    Attributes:
        geometries: as given.
    """

    def __init__(self, geometries: Sequence[SurfaceGeometry], numbers: Sequence[IntArray], count: int) -> None:
        self.geometries, self._numbers, self._count = list(geometries), list(numbers), count
        self.comm, self._gdim = geometries[0].comm, geometries[0].gdim
        self._updated: list[FloatArray] = []
        self._evaluated: list[FloatArray] = []
        self._elsewhere: list[SurfaceGeometry] = []
        self._sums_of = self._distinct()
        self._share = sum(self._sum(k, geometries[k].share) for k in self._sums_of)
        for k, geometry in enumerate(geometries):
            geometry.joined, geometry.member = self, k
            if not isinstance(geometry, RigidGeometry):
                degree = geometry.slave.displacement.degree
                for integrals in (geometry.integrals, geometry.elsewhere().integrals):  # type: ignore[attr-defined]
                    integrals.least_cover = LEAST_COVER[degree]

    def _distinct(self) -> list[int]:
        """Pairs, of those with the same slave facets the first. Collective."""
        found: list[int] = []
        for k, g in enumerate(self.geometries):
            same = [np.array_equal(g.slave.id, self.geometries[i].slave.id) for i in found]
            if not any(all(ranks) for ranks in zip(*self.comm.allgather(same))):
                found.append(k)
        return found

    # --- sums over the pairs -----------------------------------------------------------------------------------------

    def _sum(self, k: int, values: FloatArray) -> FloatArray:
        """Values of a pair's nodes, (n) or (n, gdim), by number."""
        out = np.zeros((self._count, *values.shape[1:]))
        out[self._numbers[k]] = values
        return out

    def _total(self, values: Sequence[FloatArray]) -> FloatArray:
        """Sum over the pairs of the values of their nodes, by number."""
        return np.sum([self._sum(k, v) for k, v in enumerate(values)], axis=0)

    def update(self, u: FloatArray) -> None:
        """Gaps of all pairs, unless they are those of this state already. Collective.

        Args:
            u: displacements, owned and ghost dofs [L].
        """
        state = self._state(u)
        if self._differ(state, self._updated):
            self._update(self.geometries, u)
            self._updated = state

    def forget(self) -> None:
        """Forget the states that gaps are known of."""
        self._updated, self._evaluated = [], []

    def evaluate_at(self, k: int, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Gap and slip of a pair at other displacements; see SurfaceGeometry. Collective.

        Args:
            k: number of the pair.
            u: displacements, owned and ghost dofs [L].
        """
        state = self._state(u)
        if self._differ(state, self._evaluated):
            self._elsewhere = [g.elsewhere() for g in self.geometries]
            self._update(self._elsewhere, u)
            self._evaluated = state
        there = self._elsewhere[k]
        return there.gap, there.slip_of(self._jump(self._elsewhere, k, there.moved))

    def _state(self, u: FloatArray) -> list[FloatArray]:
        """All that gaps depend on, as copies."""
        state = [np.array(u)]
        for g in self.geometries:
            state += [np.array(v) for v in (g.start, g.start_displacement, g.displacement, g.driven, g.offset)]
        return state

    def _differ(self, state: list[FloatArray], before: list[FloatArray]) -> bool:
        """Is a state another one than before, on any rank? Collective."""
        here = not before or any(not np.array_equal(a, b) for a, b in zip(state, before))
        return bool(self.comm.allreduce(here, MPI.LOR))

    def _update(self, geometries: Sequence[SurfaceGeometry], u: FloatArray) -> None:
        """Gaps, normals, weights and carriers of all pairs. Collective."""
        for g in geometries:
            g.update_cover(u)
        around = self._total([g.around for g in geometries])
        area = np.sum([self._sum(k, geometries[k].area) for k in self._sums_of], axis=0)
        enough = around > _cpp.multipliers.least_share * area
        for k, g in enumerate(geometries):
            g.integrate(np.ones(len(g.nodes), dtype=bool) if isinstance(g, RigidGeometry) else enough[self._numbers[k]])
        parts = [g.participates & (g.own_cover != 0.0) for g in geometries]
        unlocked = self._total([np.where(p[:, None], ~g.own_locked, False) for p, g in zip(parts, geometries)])
        locked = self._total([g.own_locked.astype(float) for g in geometries])
        sums = np.sum([self._sum(k, geometries[k].normal_sums()) for k in self._sums_of], axis=0)
        for k, g in enumerate(geometries):
            at = self._numbers[k]
            g.locked = (unlocked[at] == 0.0) & (locked[at] > 0.0)
            g.update_own_gap(g.locked, sums[at])
        self._keep_nearest(geometries, parts, around)
        parts_of = [p.astype(float) for p in parts]
        weight, cover, gap = (
            self._total([p * v for p, v in zip(parts_of, values)])
            for values in (
                [g.own_weight for g in geometries],
                [g.own_cover for g in geometries],
                [g.weighted_gap for g in geometries],
            )
        )
        any_part = self._total(parts_of) > 0.0
        gap = np.where(any_part, gap, np.inf) / np.where(any_part, cover, 1.0)
        carrier = self._carriers(geometries, parts)
        for k, g in enumerate(geometries):
            at = self._numbers[k]
            g.participates, g.part, g.carrier = any_part[at], parts[k], carrier[k]
            g.weight, g.cover, g.gap = weight[at], cover[at], gap[at]

    def _keep_nearest(self, geometries: Sequence[SurfaceGeometry], parts: list[BoolArray], around: FloatArray) -> None:
        """Where masters lie one behind the other only the nearest counts; changes `parts`."""
        layered = around > LAYERED * self._share
        if not np.any(layered):
            return
        nearest = np.full(self._count, np.inf)
        own = []
        for k, g in enumerate(geometries):
            gap = np.full(len(g.nodes), np.inf)
            gap[parts[k]] = g.weighted_gap[parts[k]] / g.own_cover[parts[k]]
            own.append(gap)
            np.minimum.at(nearest, self._numbers[k], gap)
        for k in range(len(parts)):
            at = self._numbers[k]
            parts[k] = parts[k] & ~(layered[at] & (own[k] > nearest[at]))

    def _carriers(self, geometries: Sequence[SurfaceGeometry], parts: Sequence[BoolArray]) -> list[BoolArray]:
        """Which pair has the multiplier of each node: the first that covers enough of it, or that covers most."""
        most = np.full(self._count, -np.inf)
        rank = []
        for k, g in enumerate(geometries):
            score = np.where(parts[k], np.where(g.covered(), np.inf, g.around), -np.inf)
            rank.append(score)
            np.maximum.at(most, self._numbers[k], score)
        taken = np.zeros(self._count, dtype=bool)
        out = []
        for k in range(len(parts)):
            at = self._numbers[k]
            mine = parts[k] & (rank[k] == most[at]) & ~taken[at]
            taken[at] |= mine
            out.append(mine)
        return [mine | ~taken[at] for mine, at in zip(out, self._numbers)]

    # --- what the pairs' constraints are made of ---------------------------------------------------------------------

    def jump(self, k: int, moved: FloatArray) -> FloatArray:
        """Means over the cover of the displacement of slave against masters; see SurfaceGeometry. Collective.

        Args:
            k: number of the pair.
            moved: increments, owned dofs [L].
        """
        return self._jump(self.geometries, k, moved)

    def _jump(self, geometries: Sequence[SurfaceGeometry], k: int, moved: FloatArray) -> FloatArray:
        total = self._total([np.where(g.part[:, None], g.weighted_jump(moved), 0.0) for g in geometries])
        here = geometries[k]
        any_part = here.participates
        return np.where(any_part[:, None], total[self._numbers[k]], 0.0) / np.where(any_part, here.cover, 1.0)[:, None]

    def over_master(self, k: int, values: FloatArray) -> FloatArray:
        """Sum of M times values over the pairs, at the nodes of one, (n). Collective.

        Args:
            k: number of the pair.
            values: over the owned nodes of V.
        """
        total = self._total([np.where(g.part, g.over_master(values), 0.0) for g in self.geometries])
        return total[self._numbers[k]]

    def rows_in(self, k: int, other: int) -> IntArray:
        """Index among another pair's nodes of each node of a pair, (n); -1 where it has none.

        Args:
            k: number of the pair.
            other: number of the other pair.
        """
        places = np.full(self._count, -1)
        places[self._numbers[other]] = np.arange(len(self._numbers[other]))
        return places[self._numbers[k]]

    def master_rows(self, k: int, rows: IntArray) -> tuple[IntArray, IntArray, FloatArray]:
        """Rows of the sum of D over the sum of M; see SurfaceGeometry.

        Args:
            k: number of the pair.
            rows: index of its nodes.
        """
        lines, columns, values = [], [], []
        for other, g in enumerate(self.geometries):
            index = self.rows_in(k, other)[rows]
            found = np.flatnonzero(index >= 0)
            found = found[g.part[index[found]]]
            pointers, column, value = g.weighted_rows(index[found].astype(np.int32), np.ones(len(g.nodes)))
            lines.append(np.repeat(found, np.diff(pointers)))
            columns.append(column)
            values.append(value)
        line = np.concatenate(lines)
        order = np.argsort(line, kind="stable")
        pointers = np.concatenate([[0], np.cumsum(np.bincount(line, minlength=len(rows)))]).astype(np.int64)
        weight = self.geometries[k].weight[rows]
        value = np.concatenate(values)[order] / weight[line[order]]
        return pointers, np.ascontiguousarray(np.concatenate(columns)[order]), np.ascontiguousarray(value)

    def forces(self, k: int, traction: FloatArray) -> FloatArray:
        """Nodal forces of the tractions at a pair's carriers, of all pairs that share them, owned dofs [F]. Collective.

        Args:
            k: number of the pair.
            traction: (n, gdim) [F/L^2].
        """
        own = self.geometries[k]
        by_number = self._sum(k, np.where(own.carrier[:, None], traction, 0.0))
        forces = [
            g.forces(np.where(g.part[:, None], by_number[at], 0.0)) for g, at in zip(self.geometries, self._numbers)
        ]
        return np.sum(forces, axis=0)

    def mean(self, k: int, values: Sequence[float]) -> FloatArray:
        """Mean over the pairs, weighted with their covers, at the nodes of one, (n).

        Args:
            k: number of the pair.
            values: one of each pair.
        """
        total = self._total([np.where(g.part, v * g.own_cover, 0.0) for g, v in zip(self.geometries, values)])
        here = self.geometries[k]
        return np.where(
            here.participates, total[self._numbers[k]] / np.where(here.participates, here.cover, 1.0), values[k]
        )
