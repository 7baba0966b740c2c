# SPDX-License-Identifier: MIT
"""Results of explicit contacts whose points are nodes: totals of their forces, and what a checkpoint has of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from mpi4py import MPI

from ... import _cpp
from ...common.types import AnyArray, FloatArray
from ..output import ContactOutput

Place = _cpp.state.Place


class NodalOutput(ContactOutput):
    """Results at the nodes of a contact in an explicit problem.

    Attributes:
        stored: energy stored in the springs, of all ranks; zero without [F L].
    """

    stored = 0.0
    _cpp_object: _cpp.nodal.NodalPair

    def sum_up(self, forces: FloatArray, resultant: FloatArray, touched: AnyArray, *more: float) -> Sequence[float]:
        """Set the totals: force, moment, area, work of friction and stored energy. Collective.

        Args:
            forces: on this rank's nodes, (n, gdim) [F].
            resultant: their part of the total force, (gdim) [F].
            touched: which nodes are in contact, (n).
            more: further numbers of this rank that are summed up.

        Returns:
            Their sums over all ranks.
        """
        gdim, moments = self.gdim, np.cross(self.points, forces) if self.gdim == 3 else None
        if moments is None:
            moments = (self.points[:, 0] * forces[:, 1] - self.points[:, 1] * forces[:, 0])[:, None]
        energy = self._cpp_object.energy()
        numbers = [self.weight[touched].sum(), energy["friction"], energy["stored"], *more]
        sums = self.comm.allreduce(np.concatenate([resultant, moments.sum(axis=0), numbers]), MPI.SUM)
        end = len(sums) - len(numbers)
        self.force, self.moment = sums[:gdim], sums[gdim:end]
        self.area, self.dissipated, self.stored, *others = (float(value) for value in sums[end:])
        return others

    def state_of(self, names: Sequence[str]) -> tuple[_cpp.state.State, _cpp.state.State]:
        """What a checkpoint holds: arrays by node, and totals.

        Args:
            names: of the arrays.
        """
        rows, totals = _cpp.state.State("results"), _cpp.state.State("contact")
        rows.at(Place.node, self.nodes.astype(np.int64))
        for name in names:
            rows.add(name, Place.node, np.ascontiguousarray(getattr(self, name)))
        for name in ("force", "moment"):
            totals.add(name, Place.all, np.array(getattr(self, name), dtype=float))
        totals.add("area", Place.all, np.array([self.area, self.dissipated]))
        return rows, totals

    def resume_totals(self, totals: _cpp.state.State) -> None:
        """Take the totals of a checkpoint.

        Args:
            totals: as `state_of` returns.
        """
        self.force, self.moment = totals.array("force"), totals.array("moment")
        self.area, self.dissipated = (float(value) for value in totals.array("area"))
