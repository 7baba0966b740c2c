# SPDX-License-Identifier: MIT
"""Functions of displacement, velocity and acceleration of an implicit problem."""

from __future__ import annotations

import numpy as np
from dolfinx import fem

from ...common.described import Described
from ...common.types import FloatArray
from .motion import State


class MotionFunctions(Described):
    """Sets the functions that users see from arrays over owned degrees of freedom.

    Args:
        displacement: displacement [L].
        velocity: velocity, on the same space [L/T].
        acceleration: acceleration, on the same space [L/T^2].
    """

    def __init__(self, displacement: fem.Function, velocity: fem.Function, acceleration: fem.Function) -> None:
        self._space = displacement.function_space
        self._num_owned = self._space.dofmap.index_map.size_local * self._space.dofmap.index_map_bs
        self._velocity, self._acceleration = velocity, acceleration

    def set(self, state: State) -> None:
        """Set velocity and acceleration, ghosts included. Collective.

        Args:
            state: motion.
        """
        for f, values in ((self._velocity, state.velocity), (self._acceleration, state.acceleration)):
            f.x.array[: self._num_owned] = values
            f.x.scatter_forward()

    def shows_velocity(self, state: State) -> bool:
        """Whether the velocity function has a state's values, on this rank; it has them afterwards.

        Args:
            state: motion.
        """
        shown = self._velocity.x.array[: self._num_owned]
        same = bool(np.array_equal(shown, state.velocity))
        shown[:] = state.velocity
        return same

    def save(self) -> tuple[FloatArray, FloatArray]:
        """Values of this rank, ghosts included, for `bring_back`."""
        return self._velocity.x.array.copy(), self._acceleration.x.array.copy()

    def bring_back(self, saved: tuple[FloatArray, FloatArray]) -> None:
        """Set velocity and acceleration to values that `save` has returned; it does not communicate.

        Args:
            saved: values of velocity [L/T] and acceleration [L/T^2].
        """
        self._velocity.x.array[:], self._acceleration.x.array[:] = saved

    def with_ghosts(self, values: FloatArray) -> FloatArray:
        """Values whose ghosts are those of their owners. Collective.

        Args:
            values: over owned and ghost degrees of freedom.

        Returns:
            A new array.
        """
        f = fem.Function(self._space)
        f.x.array[:] = values
        f.x.scatter_forward()
        return f.x.array.copy()
