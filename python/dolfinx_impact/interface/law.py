# SPDX-License-Identifier: MIT
"""A law of the interface of one's own, and how it becomes a kernel."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any

import ufl
from dolfinx.fem import Function

from .. import _cpp
from ..common.arguments import number
from ..forms import interface
from ..forms.interface import TANGENTIAL, InterfaceUpdate
from .compiled_law import CompiledLaw, Part, call

__all__ = ["TANGENTIAL", "InterfaceLaw", "InterfaceUpdate", "Part"]

# What functions of a law may ask for, by the names of their arguments.
INPUTS = ("gap", "slip", "gap_rate", "slip_rate", "rate", "normal", "fields", "history", "parameters", "unknown")


class InterfaceLaw(CompiledLaw[_cpp.enforcement.InterfaceLaw]):
    """Pressure and shear traction at a contact point as UFL expressions, compiled into one kernel.

    The functions of a law take what they need, by the names of their arguments: `gap` [L], `slip` (tangential
    displacement of the slave relative to the master, a vector) [L], their rates `gap_rate` and `slip_rate` [L/T], or
    `rate.gap` and `rate.slip`; the unit `normal` out of the master; `fields.NAME_slave` and `fields.NAME_master`,
    `history.NAME`, `parameters.NAME`; and with `response` the local `unknown`. Those of `shear`, `friction` and
    `energy` may also take the `pressure`. What is derived of a law is in docs/interface_laws.md.

    A law is one of
    - `pressure` alone, or with `shear` or `friction`;
    - `traction`, which returns both, (pressure, shear);
    - `energy` alone: pressure and shear are minus its derivatives by gap and slip;
    - `response`, which returns an InterfaceUpdate.

    Args:
        pressure: contact pressure, positive in compression [F/L^2].
        shear: traction on the slave along the surface, a vector [F/L^2].
        traction: both of them.
        energy: energy stored per area [F/L].
        friction: Coulomb's coefficient: a number, or a function; sticking points have the stiffness `tangential` [1].
        tangential: shear traction per slip of sticking points, with `friction` [F/L^3].
        response: everything at once, a function of `point`, which has the arguments above as attributes.
        history: internal variables by name, with the shape of each: () for a number, (n,), or "tangential" for a vector
            along the surface, which turns with the surface; all are zero at first.
        update: new values of the internal variables, a dictionary by name.
        unknown: shape of the unknown of local equations that `response` states, () or (n,).
        fields: functions on the mesh by name, scalar and of the degree of the displacement.
        parameters: numbers by name; `set` changes them without compiling anew.
        reach: largest gap at which the law acts; beyond it points have no traction and forget their slip [L].
        name: name for messages.
        only_in_space: whether the law has no meaning in the plane.

    Raises:
        TypeError: an argument of a wrong kind, or a function that asks for what a law does not have.
        ValueError: parts that do not go together.
    """

    def __init__(
        self,
        pressure: Part | None = None,
        shear: Part | None = None,
        *,
        traction: Part | None = None,
        energy: Part | None = None,
        friction: Part | float | None = None,
        tangential: float | None = None,
        response: Callable[[Any], InterfaceUpdate] | None = None,
        history: Mapping[str, tuple[int, ...] | str] | None = None,
        update: Part | None = None,
        unknown: tuple[int, ...] | None = None,
        fields: Mapping[str, Function] | None = None,
        parameters: Mapping[str, float] | None = None,
        reach: float | None = None,
        name: str = "law",
        only_in_space: bool = False,
    ) -> None:
        parts = dict(pressure=pressure, shear=shear, traction=traction, energy=energy, response=response, update=update)
        for what, part in parts.items():
            if part is not None and not callable(part):
                raise TypeError(f"{what} of a law must be a function, found {type(part).__name__}")
        self.pressure, self.shear, self.traction, self.energy = pressure, shear, traction, energy
        self.friction, self.response, self.update = friction, response, update
        self._check_parts()
        self.tangential = None if friction is None else number("tangential", tangential, 0.0, " [F/L^3]")
        values = dict(parameters or {})
        if self.tangential is not None:
            values[STIFFNESS] = self.tangential
        super().__init__(fields, values, name)
        self.history = _shapes(history or {})
        self.unknown, self.only_in_space = unknown, only_in_space
        if friction is not None:
            self.history = self.history | {SLID: TANGENTIAL}
        self.reach = math.inf if reach is None else number("reach", reach, 0.0, " [L]")

    def _check_parts(self) -> None:
        """Refuse parts that do not go together."""
        main = [w for w in ("pressure", "traction", "response") if getattr(self, w) is not None]
        if len(main) > 1 or (not main and self.energy is None):
            raise ValueError(
                "a law is given by one of `pressure`, `traction`, `response`, or by its `energy` alone; found "
                f"{main or 'none of them'}"
            )
        if self.shear is not None and (main != ["pressure"] or self.friction is not None):
            raise ValueError("`shear` goes with `pressure`, without `friction`")
        if self.friction is not None and main != ["pressure"]:
            raise ValueError("`friction` goes with `pressure`: the coefficient times the pressure is the limit")
        if self.response is not None and (self.energy is not None or self.update is not None):
            raise ValueError("`response` returns energy and history itself, in the InterfaceUpdate")

    def respond(self, point: Any) -> InterfaceUpdate:
        """Pressure and shear traction of a point in UFL (forms/interface.py).

        Args:
            point: what the law sees of it.

        Raises:
            TypeError: a function of the law asks for what a law does not have.
        """
        if self.response is not None:
            return self.response(point)
        given = vars(point) | {"rate": SimpleNamespace(gap=point.gap_rate, slip=point.slip_rate)}
        shear = energy = shear_energy = sticks = None
        history = {} if self.update is None else dict(call(self.update, given, "update"))
        if self.traction is not None:
            pressure, shear = call(self.traction, given, "traction")
        elif self.pressure is not None:
            pressure = call(self.pressure, given, "pressure")
            if self.shear is not None:
                shear = call(self.shear, given | {"pressure": pressure}, "shear")
        else:
            assert self.energy is not None
            gap, slip = ufl.variable(point.gap), ufl.variable(point.slip)
            stored = ufl.as_ufl(call(self.energy, given | {"gap": gap, "slip": slip}, "energy"))
            pressure, shear = -ufl.diff(stored, gap), -ufl.diff(stored, slip)
        given["pressure"] = pressure
        if self.friction is not None:
            shear, slid, sticks, shear_energy = self._coulomb(point, given)
            history[SLID] = slid
        if self.energy is not None:
            energy = call(self.energy, given, "energy")
            energy = energy if shear_energy is None else energy + shear_energy
        return InterfaceUpdate(pressure, shear, energy, shear_energy, history, sticks)

    def _coulomb(self, point: Any, given: dict[str, Any]) -> tuple[Any, Any, Any, Any]:
        """Coulomb's law by return mapping: shear traction, slip without its elastic part, condition of sticking and
        elastic energy."""
        k = getattr(point.parameters, STIFFNESS)
        coefficient = call(self.friction, given, "friction") if callable(self.friction) else self.friction
        trial = -k * (point.slip - getattr(point.history, SLID))
        limit = coefficient * ufl.max_value(given["pressure"], 0)
        size = ufl.sqrt(ufl.dot(trial, trial))
        sticks = ufl.le(size, limit)
        factor = ufl.conditional(sticks, 1.0, limit / size)
        shear = factor * trial
        return shear, point.slip + shear / k, sticks, ufl.dot(shear, shear) / (2 * k)

    def _form(self, gdim: int) -> interface.InterfaceForm:
        return interface.InterfaceForm(self, gdim, tuple(self.fields), tuple(self._parameters))

    def _make(self, kernel: int, gdim: int, functions: dict[str, Any]) -> _cpp.enforcement.InterfaceLaw:
        tangential = [name for name, shape in self.history.items() if shape == TANGENTIAL]
        return _cpp.enforcement.InterfaceLaw(kernel, gdim, self._parameters, functions, tangential, self.reach)

    def identity(self, gdim: int) -> str:
        return f"{super().identity(gdim)}; reach {self.reach!r}"

    def __repr__(self) -> str:
        given = [w for w in ("pressure", "shear", "traction", "energy", "friction", "response") if getattr(self, w)]
        numbers = "".join(f", {name}={value:g}" for name, value in self._parameters.items())
        return f"InterfaceLaw({', '.join(given)}{numbers})"


SLID = "slid"  # history of friction: slip without its elastic part
STIFFNESS = "friction_stiffness"  # parameter of friction: `tangential`


def _shapes(history: Mapping[str, tuple[int, ...] | str]) -> dict[str, tuple[int, ...] | str]:
    """Shapes of internal variables, checked."""
    for name, shape in history.items():
        whole = isinstance(shape, tuple) and len(shape) < 2 and all(isinstance(n, int) and n > 0 for n in shape)
        if shape != TANGENTIAL and not whole:
            raise ValueError(f"history {name!r} has shape {shape!r}: it must be (), (n,) or {TANGENTIAL!r}")
    return dict(history)
