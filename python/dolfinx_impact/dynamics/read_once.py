# SPDX-License-Identifier: MIT
"""What a problem in time reads of supports and rigid masters when it is made, and goes on with."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from ..common.described import Described
from ..common.types import FloatArray

if TYPE_CHECKING:
    from ..contact.pair import ContactPair
    from ..contact.rigid import _Rigid


class _Supports(Protocol):
    def check(self) -> None: ...


class _OfPair(Protocol):
    pair: ContactPair


class ReadOnce(Described):
    """Values of supports, displacements and motions of rigid masters, as they were when a problem was made.

    Args:
        supports: supports of the problem.
        contacts: contacts of the problem.
    """

    def __init__(self, supports: _Supports, contacts: Sequence[_OfPair]) -> None:
        self._supports = supports
        masters = [(c.pair.name, c.pair.rigid_master) for c in contacts if c.pair.rigid]
        self._masters: list[tuple[str, _Rigid, FloatArray, Any, Any]] = [
            (name, master, master.displacement, master.motion, master.angle) for name, master in masters
        ]

    def check(self) -> None:
        """Refuse that others have been set, on this rank. It does not communicate: a callback may have failed on one
        rank alone.

        Raises:
            ValueError: one has.
        """
        self._supports.check()
        for name, master, displacement, motion, angle in self._masters:
            moved = not np.array_equal(master.displacement, displacement)
            turned = master.angle is not angle
            if moved or turned or master.motion is not motion:
                what = "displacement" if moved else "angle" if turned else "motion"
                raise ValueError(
                    f"{name}: the {what} of the rigid master was changed after the "
                    "problem was made, which goes on with the old one. Give a `motion`, a function of time, before "
                    "the problem is made, or make another obstacle and problem"
                )
