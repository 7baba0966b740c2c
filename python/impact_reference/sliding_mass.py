# SPDX-License-Identifier: MIT
"""A mass on a moving floor, held by a spring: Coulomb's friction with a coefficient that depends on the slip velocity.

One equation, stepped by the trapezoidal rule, m x'' + k x = f; the slip velocity is that of the step, s/h with the slip
s = x_1 - x_0 - V h. |f| <= mu(0) P where s is zero, else f = -mu(|s|/h) P sign(s).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .array_types import FloatArray

BISECTIONS = 200


@dataclass(frozen=True)
class SlidingMass:
    """The mass, its spring and its floor.

    Attributes:
        mass: m [M].
        spring: k [F/L].
        load: P, that presses it on the floor [F].
        floor: V, velocity of the floor [L/T].
        coefficient: of friction, of the size of the slip velocity [1].
    """

    mass: float
    spring: float
    load: float
    floor: float
    coefficient: Callable[[float], float]

    def run(self, start: float, step: float, count: int) -> FloatArray:
        """Places after each step, (count) [L].

        Args:
            start: place at first, at rest; without friction there [L].
            step: h [T].
            count: number of steps.
        """
        x, v, a = start, 0.0, -self.spring * start / self.mass
        out = np.zeros(count)
        for n in range(count):
            slip = self._slip(x, v, a, step)
            new = x + self.floor * step + slip
            after = 4.0 * (new - x - step * v) / step**2 - a
            v += 0.5 * step * (a + after)
            x, a = new, after
            out[n] = x
        return out

    def _slip(self, x: float, v: float, a: float, h: float) -> float:
        """Slip of a step."""

        def needed(slip: float) -> float:
            """Friction that the equation of motion asks for."""
            new = x + self.floor * h + slip
            return self.mass * (4.0 * (new - x - h * v) / h**2 - a) + self.spring * new

        held = needed(0.0)
        if abs(held) <= self.coefficient(0.0) * self.load:
            return 0.0
        # The slip goes against the friction that would be needed; what is needed less what there is grows with it.
        side = -1.0 if held > 0.0 else 1.0
        low, high = 0.0, abs(self.floor) * h
        while side * needed(side * high) < -self.coefficient(high / h) * self.load:
            high *= 2.0
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            if side * needed(side * middle) < -self.coefficient(middle / h) * self.load:
                low = middle
            else:
                high = middle
        return side * 0.5 * (low + high)
