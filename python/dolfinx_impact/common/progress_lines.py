# SPDX-License-Identifier: MIT
"""When work that takes long writes a line of progress."""

from __future__ import annotations

import time
from collections.abc import Callable

FIRST = 5.0  # time after which the first line is written [s]
LATER, LONGEST = 1.3, 60.0  # from one line to the next the time grows by this factor, up to this time [s]


class ProgressLines:
    """Says when a line is due: the first after some seconds, later ones less and less often. Work of an hour writes
    some seventy lines.

    Args:
        now: clock [s].
    """

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now, self._wait = now, FIRST
        self._start = now()
        self._next = self._start + FIRST

    def due(self) -> float | None:
        """Ask whether a line is due, and take it for written.

        Returns:
            Time since the start, or None if no line is due [s].
        """
        now = self._now()
        if now < self._next:
            return None
        self._wait = min(LATER * self._wait, LONGEST)
        self._next = now + self._wait
        return now - self._start
