# SPDX-License-Identifier: MIT
"""Motion over one implicit step: acceleration and velocity as functions of the new displacement."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...common.types import BoolArray, FloatArray
from .scheme import ImplicitScheme


@dataclass
class State:
    """Motion at one time, over owned degrees of freedom.

    Attributes:
        displacement: displacement [L].
        velocity: velocity [L/T].
        acceleration: acceleration, M a = forces [L/T^2].
        mean: the scheme's acceleration A, a mean of accelerations [L/T^2].
    """

    displacement: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    mean: FloatArray

    def copy(self) -> State:
        """Copy all arrays."""
        return State(self.displacement.copy(), self.velocity.copy(), self.acceleration.copy(), self.mean.copy())


@dataclass
class Prescribed:
    """Motion of prescribed degrees of freedom at the end of a step.

    Attributes:
        mask: mask of them, owned.
        displacement: displacements, over owned degrees of freedom [L].
        velocity: velocities, over owned degrees of freedom [L/T].
        acceleration: accelerations, over owned degrees of freedom [L/T^2].
    """

    mask: BoolArray
    displacement: FloatArray
    velocity: FloatArray
    acceleration: FloatArray


@dataclass
class TimeValues:
    """What functions of time prescribe at the end of a step.

    Attributes:
        time: time there [T].
        prescribed: motion of prescribed degrees of freedom.
        factors: amplitudes of loads, (num_loads) [1].
        places: displacements of rigid masters, (num_contacts, 3) [L].
    """

    time: float
    prescribed: Prescribed
    factors: FloatArray
    places: FloatArray


class StepMotion:
    """Acceleration a_1 = acceleration_factor (u_1 - u_0) + acceleration_rest of a step, and the velocity likewise.

    Prescribed degrees of freedom have the derivatives of their functions of time. Those without mass follow no
    equation of motion: their velocity is the mean of the step.

    Args:
        scheme: parameters.
        step: length of the step [T].
        start: motion at its start.
        massless: mask of degrees of freedom without mass, owned.
        prescribed: prescribed motion at its end.

    Attributes:
        start: motion at the start.
        step: length of the step [T].
        acceleration_factor: over owned degrees of freedom [1/T^2].
        acceleration_rest: over owned degrees of freedom [L/T^2].
        velocity_factor: over owned degrees of freedom [1/T].
        velocity_rest: over owned degrees of freedom [L/T].
    """

    def __init__(
        self, scheme: ImplicitScheme, step: float, start: State, massless: BoolArray, prescribed: Prescribed
    ) -> None:
        self.scheme, self.step, self.start = scheme, step, start
        self._massless, self._prescribed = massless, prescribed
        beta, gamma, m, f = scheme.beta, scheme.gamma, scheme.alpha_m, scheme.alpha_f
        v0, a0, mean0 = start.velocity, start.acceleration, start.mean
        # A_1 = (u_1 - u_0) / (beta h^2) + rest of Newmark's formula for the displacement.
        mean_factor, self._mean_rest = 1.0 / (beta * step**2), -v0 / (beta * step) - (0.5 / beta - 1.0) * mean0
        self._mean_factor = mean_factor
        shape = v0.shape
        self.acceleration_factor = np.full(shape, (1.0 - m) / (1.0 - f) * mean_factor)
        self.acceleration_rest = ((1.0 - m) * self._mean_rest + m * mean0 - f * a0) / (1.0 - f)
        self.velocity_factor = np.full(shape, gamma * step * mean_factor)
        self.velocity_rest = v0 + step * ((1.0 - gamma) * mean0 + gamma * self._mean_rest)
        self.velocity_factor[massless], self.velocity_rest[massless] = 1.0 / step, 0.0
        self.acceleration_factor[massless], self.acceleration_rest[massless] = 0.0, 0.0
        fixed = prescribed.mask
        self.velocity_factor[fixed], self.velocity_rest[fixed] = 0.0, prescribed.velocity[fixed]
        self.acceleration_factor[fixed], self.acceleration_rest[fixed] = 0.0, prescribed.acceleration[fixed]

    def end(self, displacement: FloatArray) -> State:
        """Motion at the end of the step.

        Args:
            displacement: displacement there, over owned degrees of freedom [L].

        Returns:
            Motion.
        """
        moved = displacement - self.start.displacement
        velocity = self.velocity_factor * moved + self.velocity_rest
        acceleration = self.acceleration_factor * moved + self.acceleration_rest
        mean = self._mean_factor * moved + self._mean_rest
        fixed, massless = self._prescribed.mask, self._massless
        mean[fixed] = acceleration[fixed]
        mean[massless] = 0.0
        return State(displacement.copy(), velocity, acceleration, mean)

    def predictor(self) -> FloatArray:
        """Displacement at the end of a step with constant acceleration, over owned degrees of freedom [L]."""
        s = self.start
        moved = self.step * s.velocity + 0.5 * self.step**2 * s.mean
        return s.displacement + moved
