# SPDX-License-Identifier: MIT
"""What drives an implicit run: loads, supports and rigid masters as functions of time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import dolfinx.fem.petsc as petsc
import numpy as np
import ufl
from mpi4py import MPI
from petsc4py import PETSc

from ... import _cpp
from ...assembly.ffcx_form import ffcx_form
from ...common.collective import agree, attempt
from ...common.described import Described
from ...common.types import FloatArray, IntArray
from ..functions_of_time import FunctionsOfTime
from .loads_in_time import LoadsInTime
from .obstacle_motions import ObstacleMotions

DIFFERENCE = 0.01  # of a step: half the distance at which functions of time are differentiated

Part = tuple[IntArray, FloatArray, int]  # of Supports.parts


class Excitation(Described):
    """Loads, supports and rigid masters of an implicit problem at a time.

    Args:
        comm: communicator of the mesh.
        functions: functions of time of the problem.
        supports: prescribed owned degrees of freedom, their values [L] and the column of their function of time
            (-1: constant), for every support.
        num_owned: number of owned degrees of freedom [1].
        loads: loads in time.
        work: form of the virtual work of loads; None: there are none.
        obstacles: motions of rigid masters.
    """

    def __init__(
        self,
        comm: MPI.Intracomm,
        functions: FunctionsOfTime,
        supports: Sequence[Part],
        num_owned: int,
        loads: LoadsInTime,
        work: ufl.Form | None,
        obstacles: ObstacleMotions,
    ) -> None:
        self.comm, self.functions, self.supports, self.num_owned = comm, functions, supports, num_owned
        self.loads, self.obstacles = loads, obstacles
        self._work = None if work is None else ffcx_form(work)

    def sample(self, step: float | None, time: float) -> Any:
        """Sample all functions of time; an error on one rank is raised on all. Collective.

        Args:
            step: length of the step that ends or begins then; None: not known, velocities and accelerations are not
                computed [T].
            time: time [T].

        Returns:
            What they prescribe, TimeValues (C++).
        """
        found, error = attempt(self._sample, step, time)
        agree(self.comm, error, "functions of time")
        return found

    def _sample(self, step: float | None, time: float) -> Any:
        factors, places = self.loads.factors(time), self.obstacles.places(time)
        return _cpp.integrators.TimeValues(time, *self._prescribed(step, time), factors, places)

    def _prescribed(self, step: float | None, time: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Displacement, velocity and acceleration of the prescribed degrees of freedom, over owned ones; derivatives by
        central differences over a small part of a step."""
        small = DIFFERENCE * (step or 0.0)
        middle = max(time, small)  # there is no time before the start
        table = self.functions.table(np.array([middle - small, middle, middle + small, time]))
        u, v, a = np.zeros(self.num_owned), np.zeros(self.num_owned), np.zeros(self.num_owned)
        for dofs, values, column in self.supports:
            u[dofs] = values
            if column >= 0:
                before, now, after, exact = table[:, column]
                u[dofs] = values * exact
                if small > 0.0:
                    v[dofs] = values * (after - before) / (2.0 * small)
                    a[dofs] = values * (after - 2.0 * now + before) / small**2
        return u, v, a

    def scale(self, factors: FloatArray) -> None:
        """Multiply the constants of the loads with amplitudes, until `unscale`.

        Args:
            factors: amplitudes, (num_loads) [1].
        """
        self.loads.scale(factors)

    def unscale(self) -> None:
        """Let the constants of the loads have the user's values again."""
        self.loads.unscale()

    def external_forces(self) -> FloatArray:
        """Nodal forces of the loads as they are scaled now, over owned degrees of freedom [F]. Collective."""
        if self._work is None:
            return np.zeros(self.num_owned)
        b = petsc.assemble_vector(self._work)
        b.ghostUpdate(PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE)
        values = np.array(b.array_r)
        b.destroy()
        return values
