# SPDX-License-Identifier: MIT
"""Motions of the rigid masters of an implicit problem."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...common.described import Described
from ...amplitude import Amplitude
from ...common.types import FloatArray
from ..functions_of_time import FunctionsOfTime

if TYPE_CHECKING:
    from ...contact.mortar.lagrange import LagrangeContact
    from ...contact.penalty.quadrature_penalty import QuadraturePenalty


class ObstacleMotions(Described):
    """Displacements of rigid masters as functions of time.

    Args:
        contacts: contacts; masters may be rigid or deformable.
        functions: functions of time of the problem; those of the motions are added.
    """

    def __init__(self, contacts: Sequence[LagrangeContact | QuadraturePenalty], functions: FunctionsOfTime) -> None:
        self._num_contacts = len(contacts)
        self._motions: list[tuple[FloatArray, Amplitude] | None] = []
        for contact in contacts:
            if not contact.pair.rigid:
                self._motions.append(None)
                continue
            master, name = contact.pair.rigid_master, f"motion of the rigid master of {contact.pair.name}"
            motion = Amplitude(master.motion, name, size=3)
            functions.add(motion)
            self._motions.append((master.displacement, motion))

    def places(self, time: float) -> FloatArray:
        """Displacements of the rigid masters at a time.

        Args:
            time: time [T].

        Returns:
            Displacements, (num_contacts, 3), zero for deformable masters [L].
        """
        places = np.zeros((self._num_contacts, 3))
        for row, moving in zip(places, self._motions):
            if moving is not None:
                displacement, motion = moving
                row[:] = displacement + motion.sample([time])[0]
        return places
