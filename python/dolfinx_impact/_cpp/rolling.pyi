# SPDX-License-Identifier: MIT
# Written by `make stub` from cpp/bindings: not to be changed by hand.
from collections.abc import Sequence
from typing import Any, overload

import dolfinx.cpp
import numpy
from numpy.typing import NDArray

import dolfinx_impact._cpp

class Flow:
    """How the material of all bodies flows through the mesh"""

    def __init__(self, V: dolfinx.cpp.fem.FunctionSpace_float64, motions: Sequence[Motion]) -> None: ...
    @property
    def lateral(self) -> float:
        """Speed of the first spinning body along its axis, over the speed [1]"""

    @lateral.setter
    def lateral(self, arg: float, /) -> None: ...
    @property
    def turn(self) -> float:
        """Turn of that body about the contact's normal, over the speed [1/L]"""

    @turn.setter
    def turn(self, arg: float, /) -> None: ...

class Motion:
    """Motion of the material of a body through its mesh"""

    @staticmethod
    def spin(
        point: Sequence[float],
        axis: Sequence[float],
        omega: dolfinx.cpp.fem.Constant_float64,
        nodes: NDArray[numpy.integer[Any]],
    ) -> Motion:
        """Rotation about a fixed axis"""

    @staticmethod
    def translation(velocity: dolfinx.cpp.fem.Constant_float64, nodes: NDArray[numpy.integer[Any]]) -> Motion:
        """Translation with one velocity"""

class RollingContact(dolfinx_impact._cpp.multipliers.MortarContact):
    """Contact of bodies that flow past each other"""

    @overload
    def __init__(
        self,
        V: dolfinx.cpp.fem.FunctionSpace_float64,
        slave: dolfinx_impact._cpp.surface.Facets,
        master: dolfinx_impact._cpp.surface.Facets,
        options: dolfinx_impact._cpp.multipliers.MortarOptions,
        fixed: NDArray[numpy.bool_],
        flow: Flow,
    ) -> None:
        """Collective"""

    @overload
    def __init__(
        self,
        V: dolfinx.cpp.fem.FunctionSpace_float64,
        slave: dolfinx_impact._cpp.surface.Facets,
        master: dolfinx_impact._cpp.gap.Rigid,
        options: dolfinx_impact._cpp.multipliers.MortarOptions,
        fixed: NDArray[numpy.bool_],
        flow: Flow,
    ) -> None: ...
    @property
    def obstacle_velocity(self) -> list[float]:
        """Velocity of the surface of a rigid master [L/T]"""

    @obstacle_velocity.setter
    def obstacle_velocity(self, arg: Sequence[float], /) -> None: ...
    @property
    def slip_velocity(self) -> NDArray[numpy.float64]:
        """Of slave against master, (n, gdim) [L/T]"""

    @property
    def friction_power(self) -> float:
        """Of all ranks [F L/T]"""

    def speed(self) -> float:
        """Largest speed at the surfaces, of all ranks [L/T]. Collective"""
