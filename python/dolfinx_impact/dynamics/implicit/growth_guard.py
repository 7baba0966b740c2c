# SPDX-License-Identifier: MIT
"""Guard of implicit runs against bodies that take energy from a residual without end; docs/implicit/energies.md."""

from __future__ import annotations

from ...common.collective import common
from ...common.described import Described
from ..energy_gain import GROWTH, released_message


class GrowthGuard(Described):
    """Stops a run whose kinetic energy grows beyond all that was put in. Its values are the same on all ranks.

    Args:
        limit: energy that the residual may give; see energy_gain.release_limit [F L].
        kinetic: kinetic energy at the start [F L].

    Attributes:
        reference: energy that was there at the start or was put in since [F L].
    """

    def __init__(self, limit: float, kinetic: float) -> None:
        self.limit, self.reference = limit, kinetic

    def check(self, energy: dict[str, float], time: float) -> None:
        """Look at the end of a step.

        Args:
            energy: energies by name [F L].
            time: end of the step [T].

        Raises:
            RuntimeError: the body moves ever faster. A further call of `advance` goes on from there.
        """
        released = -energy["internal"]
        put_in = max(energy["external"], min(max(released, 0.0), self.limit))
        self.reference = max(self.reference, put_in)
        if released > self.limit and energy["kinetic"] > GROWTH * self.reference:
            self.reference = energy["kinetic"]
            text = released_message(released, self.limit, "A further call of advance goes on from here")
            raise common(RuntimeError(f"{text}. The run was stopped at the time {time:.6g}"))
