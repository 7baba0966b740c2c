# SPDX-License-Identifier: MIT
"""Calls of `advance` of explicit and implicit problems: one at a time, forwards in time."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from typing import Any

from ..common.arguments import number


def check_not_written(displacement: bool, velocity: bool) -> None:
    """Refuse that a user's function has written to the motion, on this rank.

    Args:
        displacement: whether the displacement is that of the problem still.
        velocity: whether the velocity is.

    Raises:
        ValueError: one is not.
    """
    names = [name for name, same in (("u", displacement), ("velocity", velocity)) if not same]
    if names:
        raise ValueError(
            f"a callback, or update, has written to {' and '.join(names)}: the motion is that of the integrator, which "
            "does not read these functions. Prescribe motion with PrescribedMotion, push bodies with loads, or make a "
            "new problem from the state that is wanted"
        )


class AdvanceCalls:
    """Knows whether a call of `advance` is running."""

    def __init__(self) -> None:
        self._running = False

    def check(
        self,
        time: float,
        until: float,
        callback: Callable[[Any], object] | None,
        update: Callable[[Any, float], object] | None,
    ) -> float:
        """Check a call on this rank; for use under a guard.

        Args:
            time: present time [T].
            until: time to advance to [T].
            callback: function of the problem, or None.
            update: function of problem and time, or None.

        Returns:
            `until` as a number [T].

        Raises:
            RuntimeError: `advance` was called by a callback of `advance`.
            TypeError: `until` is no number, `callback` or `update` no function.
            ValueError: `until` has passed.
        """
        if self._running:
            raise RuntimeError(
                "advance was called while it runs, by a callback: let the callback return, and call advance again after"
            )
        until = number("until", until, unit=" [T]")
        if until < time:
            raise ValueError(f"until is {until:g}, but the time is {time:g} already")
        if callback is not None and not callable(callback):
            raise TypeError(f"callback must be a function of the problem, found {type(callback).__name__}")
        if update is not None and not callable(update):
            raise TypeError(f"update must be a function of problem and time, found {type(update).__name__}")
        return until

    @staticmethod
    def at_present(
        callback: Callable[[Any], object] | None, update: Callable[[Any, float], object] | None, every: int = 1
    ) -> Callable[[Any], object] | None:
        """What is called at a time level whose forces come next, in explicit runs.

        Args:
            callback: function of the problem, or None.
            update: function of problem and time, or None; it comes first.
            every: with `update`, which has to be called in each step, steps between calls of `callback` [1].

        Returns:
            Function of the problem; None: nothing is called.
        """
        if update is None:
            return callback

        def both(problem: Any) -> None:
            update(problem, problem.time)
            if callback is not None and problem.step % every == 0:
                callback(problem)

        return both

    @contextlib.contextmanager
    def running(self) -> Iterator[None]:
        """Inside a `with` block a call is running."""
        self._running = True
        try:
            yield
        finally:
            self._running = False
