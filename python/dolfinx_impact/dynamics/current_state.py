# SPDX-License-Identifier: MIT
"""State of an explicit problem at the present time: functions, energies and contact results."""

from collections.abc import Sequence

import numpy as np
from dolfinx import fem

from .. import _cpp
from ..common.types import FloatArray
from ..contact.protocol import ExplicitContact
from .advance_calls import check_not_written
from .hourglass import HourglassEnergy
from .penetration_share import PenetrationShare
from .read_once import ReadOnce
from .run_history import ENERGIES, RunHistory, total_energy


class CurrentState:
    """Functions, results and energies of the present time of a C++ problem.

    Args:
        problem: C++ ExplicitProblem.
        displacement: function that receives the displacement [L].
        velocity: function that receives the velocity [L/T].
        acceleration: function that receives the acceleration [L/T^2].
        contacts: contacts whose results are updated.
        history: RunHistory; the energy drift is computed from it.
        share: PenetrationShare, which the contacts get their share from.
        hourglass: HourglassEnergy of the bodies.
        read: what was read of supports and rigid masters.

    Attributes:
        energy: energies at the present time by name, with `total` [F L] and `drift` [1].
    """

    def __init__(
        self,
        problem: _cpp.problems.ExplicitProblem,
        displacement: fem.Function,
        velocity: fem.Function,
        acceleration: fem.Function,
        contacts: Sequence[ExplicitContact],
        history: RunHistory,
        share: PenetrationShare,
        hourglass: HourglassEnergy,
        read: ReadOnce,
    ) -> None:
        self._cpp_object, self.integrator = problem, problem.integrator
        self.contacts, self.history, self.share, self.read = contacts, history, share, read
        self.hourglass = hourglass
        self.functions = (displacement, velocity, acceleration)
        V = displacement.function_space
        self.num_owned: int = V.dofmap.index_map.size_local * V.dofmap.index_map_bs
        self.energy: dict[str, float] = {}
        # What displacement and velocity were set to last.
        self._shown: tuple[FloatArray, ...] = tuple(np.empty(self.num_owned) for _ in range(2))

    def update_functions(self) -> None:
        """Set the functions to their values at the present time, ghosts included. Collective."""
        self._cpp_object.update_motion()
        for shown, function in zip(self._shown, self.functions):
            shown[:] = function.x.array[: self.num_owned]

    def check_not_written(self) -> None:
        """Refuse that others have written to displacement or velocity since the last update, on this rank, and take it
        back, or have set what was read when the problem was made. It does not communicate: a callback may have
        failed on one rank alone.

        Raises:
            ValueError: they have.
        """
        own = [(f.x.array[: self.num_owned], values) for f, values in zip(self.functions[:2], self._shown)]
        # Bit by bit: NaN is NaN, and nothing is computed.
        same = [np.array_equal(shown.view(np.uint64), values.view(np.uint64)) for shown, values in own]
        for (shown, values), is_same in zip(own, same):
            if not is_same:
                shown[:] = values
        check_not_written(*same)
        self.read.check()

    def update(self) -> None:
        """Update functions, contact results and energies to the present time. Collective."""
        self.update_functions()
        for contact in self.contacts:
            contact.update_results()
        values = dict(zip(ENERGIES, map(float, self.integrator.energies())))
        self.share.update(values)
        for contact in self.contacts:
            contact.penetration_share = self.share.of(contact.stored, values) if contact.is_penalty else 0.0
        self.hourglass.add(values["internal"])
        own = self.hourglass.entry()
        self.energy = {**values, **own, "total": total_energy(values), "drift": self.history.drift(values)}
