# SPDX-License-Identifier: MIT
"""Loads of an implicit problem at a given time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...common.described import Described
from ...amplitude import Amplitude
from ...common.types import FloatArray
from ...loads import Load


class LoadsInTime(Described):
    """Sets the constants of loads to their values at a time: those that the user gave, times the amplitude.

    Args:
        loads: loads whose forms have been made.

    Attributes:
        loads: those that have an amplitude.
        amplitudes: their functions of time.
    """

    def __init__(self, loads: Sequence[Load]) -> None:
        self.loads = [load for load in loads if getattr(load, "amplitude", None) is not None]
        self.amplitudes = [Amplitude(load.amplitude, f"amplitude of {type(load).__name__}") for load in self.loads]
        self._given: list[FloatArray] = []  # values of the constants while they are scaled

    def factors(self, time: float) -> FloatArray:
        """Amplitudes at a time.

        Args:
            time: time [T].

        Returns:
            Factors of `loads`, (num_loads) [1].
        """
        return np.array([amplitude.sample([time])[0, 0] for amplitude in self.amplitudes])

    def scale(self, factors: FloatArray) -> None:
        """Multiply the constants with factors, until `unscale`.

        Args:
            factors: factors of `loads`, (num_loads) [1].
        """
        self._given = [np.copy(load.constant.value) for load in self.loads]
        for load, value, factor in zip(self.loads, self._given, factors):
            load.constant.value = value * factor

    def unscale(self) -> None:
        """Set the constants to the values that the user gave."""
        for load, value in zip(self.loads, self._given):
            load.constant.value = value
