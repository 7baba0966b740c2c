# SPDX-License-Identifier: MIT
"""Stable step of a body as it deforms, found anew where it may have changed; docs/explicit/stable_step.md."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from dolfinx import la
from mpi4py import MPI

from ..common.types import FloatArray
from .stable_step import cell_sizes

if TYPE_CHECKING:
    from .explicit import ExplicitProblem

START = 6.0  # change of ln(omega^2) by a deformation of one that is expected at first; compressed rubber has 4
LEAST = 0.6  # that is always expected: a rotation changes nothing, what follows it may
MARGIN = 1.5  # by which what was seen may be exceeded
DECAY = 0.7  # of what was seen, from one look to the next
SHARE = 0.5  # of the way to the limit that a cell may be expected to go between two looks
CLOSE = 0.02  # least distance from the limit, in ln(omega^2): a step that the user gives may be the stable one
SEEN = 0.002  # deformation from which on a change of frequency says something


class StableStepWatch:
    """Frequencies of the cells, each at the deformation at which it was computed last.

    A cell whose frequency has a distance from what the steps bear may deform for a while before it is looked at again:
    the integrator stops when one has deformed by more than the distance allows, if ln(omega^2) changes by
    `sensitivity` times the deformation at most, which is learned.

    Args:
        problem: ExplicitProblem; its frequencies depend on the displacement.

    Attributes:
        squares: square of the highest angular frequency of each owned cell [1/T^2].
        rates: largest eigenvalue of damping over mass of each owned cell [1/T].
        since: deformation of each cell since its frequency was computed, at the last look [1].
        reference: displacement at the last look, owned and ghosts [L].
        sensitivity: expected change of ln(omega^2) by a deformation of one [1].
    """

    def __init__(self, problem: ExplicitProblem) -> None:
        V = problem.space
        self._problem, self._integrator, self._sizes = problem, problem._cpp_object, cell_sizes(V.mesh)
        none = np.zeros(len(self._sizes))
        self.squares: FloatArray = none
        self.rates: FloatArray = none
        self.since: FloatArray = none
        self.reference: FloatArray = np.zeros(len(problem.u.x.array))
        self.sensitivity, self._nominal = START, math.inf
        nodes = V.dofmap.list[: len(self._sizes)]
        self._integrator.add_watch(np.ascontiguousarray(nodes, dtype=np.int32).ravel(), nodes.shape[1])

    def find_all(self) -> float:
        """Compute the frequencies of all cells. Collective.

        Returns:
            Stable step [T].

        Raises:
            ValueError: the stiffness of a cell is not finite; on all ranks.
        """
        self.squares, self.rates = self._problem.frequencies_by_cell()
        self.since = np.zeros(len(self.squares))
        self.reference = self._problem.u.x.array.copy()
        return self._step()

    def find_changed(self) -> float:
        """Compute the frequencies of the cells that have deformed on their way to the limit. Collective.

        Returns:
            Stable step [T].

        Raises:
            ValueError: the stiffness of a cell is not finite; on all ranks.
        """
        self.since += self._integrator.deformations(self._problem.u.x.array) / self._sizes
        self.reference = self._problem.u.x.array.copy()
        chosen = self.since > 0.5 * self._allowed(self._nominal)
        before = self.squares[chosen]
        self.squares[chosen], self.rates[chosen] = self._problem.frequencies_by_cell(chosen)
        self._learn(before, self.squares[chosen], self.since[chosen])
        self.since[chosen] = 0.0
        return self._step()

    def resume(
        self, squares: FloatArray, rates: FloatArray, since: FloatArray, reference: FloatArray, sensitivity: float
    ) -> None:
        """Set the attributes from a checkpoint. Collective.

        Args:
            squares: squares of frequencies by cell [1/T^2].
            rates: damping over mass by cell [1/T].
            since: deformations by cell [1].
            reference: displacement at the last look, owned degrees of freedom [L].
            sensitivity: change of ln(omega^2) by a deformation of one [1].
        """
        self.squares, self.rates, self.since, self.sensitivity = squares, rates, since, sensitivity
        map_, bs = self._problem.space.dofmap.index_map, self._problem.space.dofmap.index_map_bs
        vector = la.vector(map_, bs)
        vector.array[: len(reference)] = reference
        vector.scatter_forward()
        self.reference = vector.array.copy()

    def begin(self, nominal: float) -> None:
        """Tell the integrator how far cells may deform under steps of a length. Collective.

        Args:
            nominal: largest step; 0: cells may deform as they like [T].
        """
        if nominal == 0.0:
            self._integrator.set_watch(self.reference, np.full(len(self.since), np.inf))
            return
        self._nominal = nominal
        left = np.maximum(self._allowed(nominal) - self.since, 0.0)
        self._integrator.set_watch(self.reference, np.ascontiguousarray(left * self._sizes))

    def _allowed(self, nominal: float) -> FloatArray:
        """Deformations that cells may have before their frequency is computed again [1]."""
        steps = self._problem.steps_by_cell(self.squares, self.rates)
        with np.errstate(divide="ignore"):  # cells without stiffness have no distance: they may get some
            distance = np.where(np.isfinite(steps), 2.0 * np.log(steps / nominal), 0.0)
        return SHARE * np.maximum(distance, CLOSE) / self.sensitivity

    def _step(self) -> float:
        smallest = float(np.min(self._problem.steps_by_cell(self.squares, self.rates), initial=math.inf))
        return self._problem.comm.allreduce(smallest, MPI.MIN)

    def _learn(self, before: FloatArray, after: FloatArray, deformed: FloatArray) -> None:
        """Adapt the sensitivity to changes of frequencies that were seen. Collective."""
        told = (deformed > SEEN) & (before > 0.0) & (after > 0.0)
        ratios = np.abs(np.log(after[told] / before[told])) / deformed[told]
        seen = self._problem.comm.allreduce(float(np.max(ratios, initial=0.0)), MPI.MAX)
        self.sensitivity = max(MARGIN * seen, DECAY * self.sensitivity, LEAST)
