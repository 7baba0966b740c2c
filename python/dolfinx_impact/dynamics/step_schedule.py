# SPDX-License-Identifier: MIT
"""Equal steps from one time to another."""

from dataclasses import dataclass

import numpy as np

from ..common.types import FloatArray, IntArray


@dataclass
class StepSchedule:
    """Equal steps between two times, numbered as the steps of the run.

    Attributes:
        begin: time at the first step [T].
        until: time at the last step [T].
        first: number of the step at `begin`.
        last: number of the step at `until`, greater than `first`.
        auto: whether the schedule was made with dt="auto".
    """

    begin: float
    until: float
    first: int
    last: int
    auto: bool = False

    @property
    def dt(self) -> float:
        """Length of a step [T]."""
        return (self.until - self.begin) / (self.last - self.first)

    def times(self, steps: IntArray) -> FloatArray:
        """Times of steps; the time of step `last` is exactly `until`.

        Args:
            steps: numbers of steps, (n) or a scalar [1].

        Returns:
            Times, in the shape of `steps` [T].
        """
        return np.where(steps == self.last, self.until, self.begin + (steps - self.first) * self.dt)
