# SPDX-License-Identifier: MIT
"""A law of friction of one's own, and how it becomes a kernel."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from dolfinx.fem import Function

from .. import _cpp
from ..forms import friction
from .compiled_law import CompiledLaw, Part, call


class FrictionLaw(CompiledLaw[_cpp.enforcement.FrictionLaw]):
    """Coulomb's coefficient at a contact point as a UFL expression, compiled into a kernel.

    |t| <= mu p, and where a point slips |t| = mu p against the slip velocity v, exactly: for the argument `friction` of
    a ContactPair with Lagrange multipliers (static, implicit, rolling) or kinematic contact (explicit). Laws with a
    penalty have the same functions as the argument `friction` of an InterfaceLaw. docs/interface_laws.md.

    The function takes what it needs, by the names of its arguments: `pressure` [F/L^2], `slip_rate`, tangential
    velocity of the slave relative to the master, a vector [L/T], the unit `normal` out of the master,
    `fields.NAME_slave` and `fields.NAME_master`, `parameters.NAME`. Static problems have no velocity, and refuse laws
    that ask for it. A coefficient below zero counts as zero.

    Args:
        coefficient: mu, a function [1].
        fields: functions on the mesh by name, scalar and of the degree of the displacement.
        parameters: numbers by name; `set` changes them without compiling anew.
        name: name for messages.

    Raises:
        TypeError: an argument of a wrong kind, or a function that asks for what a law does not have.
    """

    def __init__(
        self,
        coefficient: Part,
        *,
        fields: Mapping[str, Function] | None = None,
        parameters: Mapping[str, float] | None = None,
        name: str = "law of friction",
    ) -> None:
        if not callable(coefficient):
            raise TypeError(f"coefficient of a law must be a function, found {type(coefficient).__name__}")
        self._coefficient = coefficient
        super().__init__(fields, parameters, name)

    def coefficient(self, point: Any) -> Any:
        """Coulomb's coefficient of a point in UFL (forms/friction.py).

        Args:
            point: what the law sees of it.

        Raises:
            TypeError: the function asks for what a law does not have.
        """
        return call(self._coefficient, vars(point), "coefficient")

    def _form(self, gdim: int) -> friction.FrictionForm:
        return friction.FrictionForm(self, gdim, tuple(self.fields), tuple(self._parameters))

    def _make(self, kernel: int, gdim: int, functions: dict[str, Any]) -> _cpp.enforcement.FrictionLaw:
        return _cpp.enforcement.FrictionLaw(kernel, gdim, self._parameters, functions)

    def __repr__(self) -> str:
        numbers = "".join(f", {name}={value:g}" for name, value in self._parameters.items())
        return f"FrictionLaw({getattr(self._coefficient, '__name__', 'coefficient')}{numbers})"
