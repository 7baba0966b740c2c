# SPDX-License-Identifier: MIT
"""Changes of constants and functions that stiffness or damping depend on, since the stable step was found."""

from __future__ import annotations

import math
from dataclasses import dataclass

EFFECT = 0.1  # change of ln(omega^2) between two looks at the stable step; 0.9 of it leaves 0.21
LEAST = 0.01  # change of an input that is always allowed before the next look
MARGIN = 1.5  # by which the effect that was seen may be exceeded


@dataclass
class InputChanges:
    """Sum of relative changes since the stable step was found, and how far it may go before that is found again.

    Attributes:
        stale: whether there was any change.
        total: sum of relative changes [1].
        allowed: sum that is allowed [1].
    """

    stale: bool = False
    total: float = 0.0
    allowed: float = EFFECT

    def add(self, change: float) -> None:
        """Add a change.

        Args:
            change: relative to the value before; 1 for one that was zero [1].
        """
        self.stale = True
        self.total += change

    @property
    def due(self) -> bool:
        """Whether the stable step should be found anew."""
        return self.stale and not self.total <= self.allowed

    def done(self, before: float, after: float) -> None:
        """The stable step was found anew: the sums begin again; what is allowed follows from the effect of the change.

        Args:
            before: stable step before [T].
            after: stable step now [T].
        """
        if self.stale and 0.0 < before < math.inf and 0.0 < after < math.inf and 0.0 < self.total < math.inf:
            effect = MARGIN * abs(2.0 * math.log(after / before))
            most = 2.0 * max(self.total, self.allowed)
            self.allowed = max(LEAST, min(most, EFFECT * self.total / effect if effect > 0.0 else most))
        self.stale, self.total = False, 0.0
