# SPDX-License-Identifier: MIT
"""Lengths of implicit steps: equal ones, those that a local error allows, and those after a step that failed."""

from __future__ import annotations

import math
from ...common.described import Described

SAME = 1e-9  # relative difference of steps that count as equal: they share a matrix and its factors
SAFETY = 0.9  # of the step that the error estimate allows
LARGEST_GROWTH, LARGEST_CUT = 2.0, 0.2  # factors from one step to the next
REJECTED = 2.0  # times the tolerance: errors beyond it repeat the step
MANY, FEW = 12, 6  # Newton iterations of a step after which the next one is shorter, and may be longer again


class StepControl(Described):
    """Chooses the length of the next step.

    Args:
        largest: largest step [T].
        smallest: smallest step [T].
        tolerance: local error of the displacement in a step, relative to the largest displacement so far; None: steps
            are equal, unless one fails [1].
        length: step to begin with; None: the largest [T].
        last: length of the step before; a step that differs from it by round-off only gets it. 0: there is none [T].

    Attributes:
        length: wanted length of the next step [T].
        last: length of the last step [T].
    """

    def __init__(
        self,
        largest: float,
        smallest: float,
        tolerance: float | None = None,
        length: float | None = None,
        last: float = 0.0,
    ) -> None:
        self.largest, self.smallest, self.tolerance = largest, smallest, tolerance
        self.length = largest if length is None else min(length, largest)
        self.last = last

    def next(self, time: float, goal: float) -> tuple[float, float]:
        """Next step on the way to a time that must be met.

        Args:
            time: present time [T].
            goal: time to be met, later [T].

        Returns:
            Length of the step and time at its end, which is `goal` for the last one [T].
        """
        left = goal - time
        count = max(1, math.ceil(left / self.length * (1.0 - SAME)))
        step = left / count
        if abs(step - self.last) <= SAME * step:
            step = self.last
        self.last = step
        return step, goal if count == 1 else time + step

    def failed(self, step: float) -> bool:
        """Halve the step after one that did not converge.

        Args:
            step: its length [T].

        Returns:
            Whether the next step is long enough to be tried.
        """
        self.length = 0.5 * step
        return self.length >= self.smallest

    def accepts(self, step: float, error: float | None) -> bool:
        """Judge the error of a converged step; a rejected one is to be repeated with the new length.

        Args:
            step: its length [T].
            error: estimate of its local error, relative as the tolerance; None: there is none [1].

        Returns:
            Whether the step is accepted.
        """
        if self.tolerance is None or error is None or error <= REJECTED * self.tolerance or step <= self.smallest:
            return True
        self.length = max(step * self._factor(error), self.smallest)
        return False

    def _factor(self, error: float) -> float:
        """Factor of the next step: the error is of the third power of the step."""
        assert self.tolerance is not None  # asked only with one
        if error <= 0.0:
            return LARGEST_GROWTH
        return min(max(SAFETY * (self.tolerance / error) ** (1.0 / 3.0), LARGEST_CUT), LARGEST_GROWTH)

    def done(self, step: float, iterations: int, error: float | None) -> None:
        """Choose the length of the next step after an accepted one.

        Args:
            step: length of the accepted step [T].
            iterations: its Newton iterations [1].
            error: estimate of its local error; None: there is none [1].
        """
        if iterations > MANY and step <= self.length * (1.0 + SAME):
            wanted = 0.5 * step
        elif self.tolerance is not None and error is not None:
            # A step that was shortened to meet a time says little about longer ones.
            wanted = max(step * self._factor(error), self.length if error <= self.tolerance else 0.0)
            wanted = min(wanted, LARGEST_GROWTH * max(step, self.length))
        else:
            wanted = 2.0 * self.length if iterations <= FEW and self.length < self.largest else self.length
        self.length = min(max(wanted, self.smallest), self.largest)
