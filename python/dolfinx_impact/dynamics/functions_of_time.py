# SPDX-License-Identifier: MIT
"""All functions of time of an explicit problem, as one table for the C++ integrator."""

import numpy as np

from ..amplitude import Amplitude


class FunctionsOfTime:
    """Amplitudes of loads, prescribed motion and rigid masters. Each has one column of a table, vectors have three."""

    def __init__(self) -> None:
        self.amplitudes: list[Amplitude] = []

    def add(self, amplitude: Amplitude) -> list[int]:
        """Append a function of time; returns the numbers of its columns."""
        first = sum(a.size for a in self.amplitudes)
        self.amplitudes.append(amplitude)
        return [first + k for k in range(amplitude.size)]

    def table(self, times: np.ndarray) -> np.ndarray:
        """Values at times [T], a row for each time, (num_times, num_columns)."""
        columns = [a.sample(times) for a in self.amplitudes]
        return np.hstack(columns) if columns else np.zeros((len(times), 0))
