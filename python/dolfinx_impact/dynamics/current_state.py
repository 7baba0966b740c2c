# SPDX-License-Identifier: MIT
"""The state of an explicit problem as a user sees it: functions, energies, results of contacts."""

import numpy as np

from .run_history import ENERGIES, RunHistory, total_energy


class CurrentState:
    """Copies the state of the C++ integrator into DOLFINx functions and results.

    Args:
        integrator: C++ CentralDifference.
        displacement: function that follows the run [L].
        velocity: function that follows the run [L/T].
        acceleration: function that follows the run [L/T^2].
        contacts: contacts with results.
        history: RunHistory that the drift is relative to.

    Attributes:
        energy: energies at the present time by name, with `total` [F L] and `drift` [1].
    """

    def __init__(self, integrator, displacement, velocity, acceleration, contacts, history: RunHistory) -> None:
        self.integrator, self.contacts, self.history = integrator, contacts, history
        self.functions = (displacement, velocity, acceleration)
        V = displacement.function_space
        self.num_owned = V.dofmap.index_map.size_local * V.dofmap.index_map_bs
        self.energy: dict[str, float] = {}

    def motion(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Displacement, velocity and acceleration at the present time, owned entries [L, L/T, L/T^2]."""
        v, a = np.empty(self.num_owned), np.empty(self.num_owned)
        self.integrator.motion(v, a)
        return self.integrator.displacement(), v, a

    def update_functions(self) -> None:
        """Give the functions their values at the present time, ghosts too. Collective."""
        for f, values in zip(self.functions, self.motion()):
            f.x.array[: self.num_owned] = values
            f.x.scatter_forward()

    def update(self) -> None:
        """Functions, results of contacts and energies at the present time. Collective."""
        self.update_functions()
        for contact in self.contacts:
            contact.update_results()
        values = dict(zip(ENERGIES, self.integrator.energies().tolist()))
        self.energy = {**values, "total": total_energy(values), "drift": self.history.drift(values)}
