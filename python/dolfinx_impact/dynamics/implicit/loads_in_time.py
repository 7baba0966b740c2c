# SPDX-License-Identifier: MIT
"""Loads of an implicit problem at a given time."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence

import numpy as np

from ...amplitude import Amplitude
from ...loads import Load


class LoadsInTime:
    """Sets the constants of loads to their values at a time: those that the user gave, times the amplitude.

    Args:
        loads: loads whose forms have been made.

    Attributes:
        amplitudes: load and function of time of the loads that have one.

    Raises:
        ValueError: a load that follows the body has an amplitude.
    """

    def __init__(self, loads: Sequence[Load]) -> None:
        self.amplitudes = [
            (load, Amplitude(load.amplitude, f"amplitude of {type(load).__name__}"))
            for load in loads
            if getattr(load, "amplitude", None) is not None
        ]

    @contextlib.contextmanager
    def at(self, time: float) -> Iterator[None]:
        """Inside a `with` block the loads have the values of a time.

        Args:
            time: time [T].
        """
        given = [np.copy(load.constant.value) for load, _ in self.amplitudes]
        for (load, amplitude), value in zip(self.amplitudes, given):
            load.constant.value = value * amplitude.sample([time])[0, 0]
        try:
            yield
        finally:
            for (load, _), value in zip(self.amplitudes, given):
                load.constant.value = value
