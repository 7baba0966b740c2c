# SPDX-License-Identifier: MIT
"""Table of all functions of time of an explicit problem, for the C++ integrator."""

import numpy as np

from ..common.described import Described
from ..amplitude import Amplitude
from ..common.types import FloatArray


class FunctionsOfTime(Described):
    """Amplitudes of loads, prescribed motion and rigid masters as columns of one table.

    A scalar amplitude has one column, a vector has three.

    Attributes:
        amplitudes: amplitudes in the order of their columns.
    """

    def __init__(self) -> None:
        self.amplitudes: list[Amplitude] = []

    def add(self, amplitude: Amplitude) -> list[int]:
        """Append a function of time.

        Args:
            amplitude: function of time.

        Returns:
            Numbers of its columns.
        """
        first = sum(a.size for a in self.amplitudes)
        self.amplitudes.append(amplitude)
        return [first + k for k in range(amplitude.size)]

    def table(self, times: FloatArray) -> FloatArray:
        """Sample all functions.

        Args:
            times: times, (num_times) [T].

        Returns:
            Values, (num_times, num_columns), in the units of the functions.

        Raises:
            ValueError: a function has values of another shape or not finite.
        """
        columns = [a.sample(times) for a in self.amplitudes]
        return np.hstack(columns) if columns else np.zeros((len(times), 0))
