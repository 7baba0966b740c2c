# SPDX-License-Identifier: MIT
"""What is written in one series of frames."""

from __future__ import annotations

from typing import Protocol

from dolfinx.fem import Function


class FieldSource(Protocol):
    """Functions of one element that are written together.

    Attributes:
        series: name of the series, without ending.
        functions: the functions, with the names of their fields.
        dimensions: dimension of each; empty where it is not known.
    """

    series: str
    functions: list[Function]
    dimensions: list[str]

    def update(self) -> None:
        """Set the functions to their values at the present state. Collective."""


class MotionFields:
    """Displacement, velocity and acceleration, which the problem itself keeps up to date; see FieldSource.

    Args:
        functions: functions, named.
        dimensions: dimension of each.
    """

    series = "fields"

    def __init__(self, functions: list[Function], dimensions: list[str]) -> None:
        self.functions, self.dimensions = functions, dimensions

    def update(self) -> None:
        """Nothing: the problem has set them."""
