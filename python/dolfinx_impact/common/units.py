# SPDX-License-Identifier: MIT
"""Units in which a problem is given, for names and labels; nothing is computed with them."""

from __future__ import annotations

import re
from dataclasses import dataclass


@dataclass(frozen=True)
class Units:
    """Consistent units of a problem. The defaults are the letters of the dimensions.

    Args:
        length: unit of length.
        force: unit of force.
        time: unit of time.
        pressure: unit of force per area; empty: it is written with those of force and length.
        energy: unit of force times length; empty: likewise.
    """

    length: str = "L"
    force: str = "F"
    time: str = "T"
    pressure: str = ""
    energy: str = ""

    def of(self, dimension: str) -> str:
        """Unit of a dimension.

        Args:
            dimension: powers of L, F and T, as "F/L^2"; "1": none.

        Returns:
            The unit, as "N/m^2".
        """
        named = {"F/L^2": self.pressure, "F L": self.energy}.get(dimension, "")
        letters = {"L": self.length, "F": self.force, "T": self.time}
        return named or re.sub(r"\b[LFT]\b", lambda match: letters[match[0]], dimension)


SI = Units("m", "N", "s", "Pa", "J")
MILLIMETRES = Units("mm", "N", "s", "MPa", "mJ")
